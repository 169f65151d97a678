//! A choice of tables in a scene file: which of them the file means.

use crate::{
    declare::{Row, join},
    keys::{Fallback, Key, Variant},
    reader::Reader,
};

/// A choice of tables.
pub(crate) struct Choice {
    /// The word of each, for errors.
    pub(crate) words: &'static [&'static str],
    /// Name and meaning of each.
    pub(crate) variants: Vec<Variant>,
    /// The keys of each, and the words of the default of those that it needs.
    pub(crate) tables: Vec<(&'static str, Vec<Key>)>,
    /// The key that names the table, where there is one.
    pub(crate) tag: Option<Row<&'static str>>,
}

impl Choice {
    /// Appends the key that names the table and the keys of all tables, each once. A key that not every table needs
    /// says which one does.
    pub(crate) fn list(self, path: &str, all: &mut Vec<Key>) {
        let (first, tagged) = (all.len(), self.tag.is_some());
        if let Some(tag) = self.tag {
            all.push(Key { variants: self.variants.clone(), ..tag.key(path, |word| format!("\"{word}\"")) });
        }
        let needed = |path: &str| {
            self.tables
                .iter()
                .all(|(_, keys)| keys.iter().any(|key| key.path == path && key.default == Fallback::Required))
        };
        for ((case, keys), variant) in self.tables.iter().zip(&self.variants) {
            for key in keys {
                let (path, own) = (join(path, &key.path), !key.path.contains('.'));
                let variant = Some(*variant).filter(|_| own && tagged);
                if let Some(known) = all[first..].iter_mut().find(|other| other.path == path) {
                    known.variants.extend(variant);
                    continue;
                }
                let needed = own && key.default == Fallback::Required && !needed(&key.path);
                let default = if needed { Fallback::RequiredIf(case) } else { key.default.clone() };
                let variants = if own { variant.into_iter().collect() } else { key.variants.clone() };
                all.push(Key { path, default, variants, ..key.clone() });
            }
        }
    }

    /// Index of the table that the file means. Keys of the others are faults. `None` where the key that names it has a
    /// wrong value.
    pub(crate) fn of(&self, reader: &Reader<'_>) -> Option<usize> {
        let has = |table: usize, path: &str| self.tables[table].1.iter().any(|key| key.path == path);
        let chosen = match &self.tag {
            Some(tag) => {
                let word = reader.has(tag.name).then(|| reader.said::<String>(tag.name));
                let default = || tag.default.value(reader.published()).map(str::to_owned);
                let word = word.unwrap_or_else(default)?;
                self.words.iter().position(|own| *own == word)?
            }
            None => {
                let names = |i: usize| {
                    let own = self.tables[i].1.iter().filter(|key| key.default == Fallback::Required);
                    own.filter(|key| (0..self.tables.len()).all(|other| other == i || !has(other, &key.path)))
                        .any(|key| reader.has(&key.path))
                };
                (1..self.tables.len()).find(|&i| names(i)).unwrap_or_default()
            }
        };
        let others = (0..self.tables.len()).filter(|&other| other != chosen);
        let mut said = Vec::new();
        for (other, key) in others.flat_map(|other| self.tables[other].1.iter().map(move |key| (other, key))) {
            if has(chosen, &key.path) || said.contains(&&key.path) || !reader.has(&key.path) {
                continue;
            }
            said.push(&key.path);
            let (own, other) = (self.words[chosen], self.words[other]);
            let words = match &self.tag {
                Some(tag) => format!("goes with {0} \"{other}\": expected no such key with {0} \"{own}\"", tag.name),
                None => format!("goes with {other}: expected no such key with {own}"),
            };
            reader.at.fault(&key.path, words);
        }
        Some(chosen)
    }
}
