//! Links of the Markdown pages, for `cargo xtask docs` and for `tests/documents.rs`, which includes this file.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path, PathBuf};

/// Texts of pages, by their paths in the repository.
pub(crate) type Pages = BTreeMap<PathBuf, String>;

/// What a page has in the place of a part that `docs/generate.py` writes, before the part's name.
pub(crate) const MARK: &str = "<!-- generated: ";

/// Folder of the repository in which the book has its pages, and in which it has the APIs once it is built.
pub(crate) const BOOK: &str = "docs";

/// The text outside blocks of code, in which alone links are looked for.
pub(crate) fn prose(text: &str) -> String {
    text.split("```").step_by(2).collect()
}

/// The text with each link outside blocks of code replaced by what the function makes of it.
pub(crate) fn replaced(text: &str, mut replace: impl FnMut(&str) -> String) -> String {
    let mut made = Vec::new();
    for (k, part) in text.split("```").enumerate() {
        let mut pieces = part.split("](");
        let mut own = pieces.next().unwrap_or_default().to_owned();
        for piece in pieces {
            own += "](";
            match piece.split_once(')') {
                Some((link, rest)) if k % 2 == 0 => own += &format!("{}){rest}", replace(link)),
                _ => own += piece,
            }
        }
        made.push(own);
    }
    made.join("```")
}

/// Whether a link leads out of the repository.
pub(crate) fn is_outside(link: &str) -> bool {
    link.contains("://")
}

/// The path that a link of a page leads to, and its anchor, empty where there is none.
pub(crate) fn target<'a>(page: &Path, link: &'a str) -> (PathBuf, &'a str) {
    let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
    if file.is_empty() {
        return (page.to_owned(), anchor);
    }
    let mut path = page.parent().map(Path::to_owned).unwrap_or_default();
    for part in Path::new(file).components() {
        match part {
            Component::ParentDir => drop(path.pop()),
            Component::CurDir => (),
            part => path.push(part),
        }
    }
    (path, anchor)
}

/// Each link of the pages that leads nowhere, with its page. `exists` says whether a file that is no page is there.
pub(crate) fn broken(pages: &Pages, exists: impl Fn(&Path) -> bool) -> Vec<String> {
    let mut broken = Vec::new();
    for (page, text) in pages {
        replaced(text, |link| {
            let (path, anchor) = target(page, link);
            let found = is_outside(link)
                || match pages.get(&path) {
                    Some(text) => anchor.is_empty() || text.contains(MARK) || anchors(text).contains(anchor),
                    None => exists(&path),
                };
            if !found {
                broken.push(format!("{}: {link}", page.display()));
            }
            link.to_owned()
        });
    }
    broken
}

/// Anchors of a page's headings, as GitHub and mdBook make them.
pub(crate) fn anchors(text: &str) -> BTreeSet<String> {
    let slug = |heading: &str| -> String {
        let kept =
            heading.to_lowercase().chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c)).collect::<String>();
        kept.trim().replace(' ', "-")
    };
    prose(text).lines().filter(|line| line.starts_with('#')).map(|line| slug(line.trim_start_matches('#'))).collect()
}
