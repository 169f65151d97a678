//! The files that studies write: rows as CSV, below lines with `#` that say how they were measured, and pages of
//! Markdown whose sections are replaced one by one.

use std::{fs, path::Path};

use windswept_validate::{Role, Row, Sweep};

use crate::Result;

/// Columns of a CSV file; the quantity has the unit of the values, and the head says of which quantity `at` is.
const COLUMNS: [&str; 7] = ["quantity", "series", "setting", "at", "measured", "tolerance", "role"];

/// Writes the rows of sweeps below the lines of a head.
pub(crate) fn write(path: &Path, head: &[String], sweeps: &[Sweep]) -> Result<()> {
    let mut table = csv::Writer::from_writer(Vec::new());
    table.write_record(COLUMNS)?;
    for row in sweeps.iter().flat_map(|sweep| &sweep.rows) {
        let quantity = quantity(&row.quantity, row.unit);
        let [at, measured, tolerance] = [row.at, row.measured, row.tolerance].map(|x| x.to_string());
        let role = Role::ALL.iter().find(|(_, role)| *role == row.role).map_or("", |(word, _)| word);
        table.write_record([&quantity, &row.series, &row.setting, &at, &measured, &tolerance, role])?;
    }
    let head: String = head.iter().map(|line| format!("# {line}\n")).collect();
    fs::create_dir_all(path.parent().unwrap_or(path))?;
    fs::write(path, head + &String::from_utf8(table.into_inner()?)?)?;
    Ok(())
}

/// The lines of the head of a CSV file, and its sweeps over an axis.
pub(crate) fn read(path: &Path, axis: &'static str) -> Result<(Vec<String>, Vec<Sweep>)> {
    let text = fs::read_to_string(path)?;
    let head = text.lines().map_while(|line| line.strip_prefix("# ")).map(str::to_owned).collect();
    let mut sweeps = Vec::new();
    for record in csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes()).records() {
        let record = record?;
        let cell = |k: usize| record.get(k).ok_or(format!("{}: a row without {}", path.display(), COLUMNS[k]));
        let number = |k: usize| Ok::<f64, Box<dyn std::error::Error>>(cell(k)?.parse()?);
        let role = cell(6)?;
        let role =
            Role::ALL.iter().find(|(word, _)| *word == role).ok_or(format!("{}: role {role:?}", path.display()))?;
        let row = sweep(&mut sweeps, cell(0)?, axis).add(cell(1)?, cell(2)?, number(3)?, number(4)?);
        (row.tolerance, row.role) = (number(5)?, role.1);
    }
    Ok((head, sweeps))
}

/// The sweep of a quantity over an axis, which is added where there is none.
pub(crate) fn sweep<'a>(sweeps: &'a mut Vec<Sweep>, quantity: &str, axis: &'static str) -> &'a mut Sweep {
    let found = sweeps.iter().position(|sweep| sweep.quantity == quantity);
    let k = found.unwrap_or_else(|| {
        sweeps.push(Sweep::new(quantity, 0.0, "").over(axis));
        sweeps.len() - 1
    });
    &mut sweeps[k]
}

/// A quantity with its unit, if it has one.
pub(crate) fn quantity(words: &str, unit: &str) -> String {
    if unit.is_empty() { words.to_owned() } else { format!("{words} [{unit}]") }
}

/// Writes sections of a page, by title, in the place of those that it had; others stay. The head is made of the text of
/// all sections.
pub(crate) fn page(path: &Path, head: fn(&str) -> String, sections: &[(&str, String)]) -> Result<()> {
    let before = fs::read_to_string(path).unwrap_or_default();
    let mut all: Vec<(&str, &str)> = before.split("\n## ").skip(1).filter_map(|own| own.split_once('\n')).collect();
    for (title, body) in sections {
        match all.iter_mut().find(|(other, _)| other == title) {
            Some(section) => section.1 = body,
            None => all.push((title, body)),
        }
    }
    let text: String = all.iter().map(|(title, body)| format!("\n## {title}\n\n{}\n", body.trim())).collect();
    fs::create_dir_all(path.parent().unwrap_or(path))?;
    fs::write(path, head(&text) + &text)?;
    Ok(())
}

/// Number of digits that a value shows.
const DIGITS: usize = 3;

/// The value of a row, with as many digits as show on which side of its bound it is.
pub(crate) fn measured(row: &Row) -> String {
    let as_bound = |text: &String| text.parse() == Ok(row.tolerance) && row.measured != row.tolerance;
    let text = (DIGITS..17).map(|digits| number(row.measured, digits)).find(|text| !as_bound(text));
    in_unit(row, text.unwrap_or_else(|| row.measured.to_string()))
}

fn number(x: f64, digits: usize) -> String {
    match x {
        x if x == x.round() && x.abs() < 1e6 => format!("{x}"),
        x if (1e-3..1e4).contains(&x.abs()) => {
            let whole = x.abs().log10().floor() as i32 + 1;
            format!("{x:.*}", usize::try_from(digits as i32 - whole).unwrap_or(0))
        }
        x => format!("{x:.*e}", digits - 1),
    }
}

/// The bound of a row as it is, but for what rounding added to one that was computed.
pub(crate) fn bound(row: &Row) -> String {
    match row.tolerance {
        f64::INFINITY => "none".to_owned(),
        x if x == 0.0 || x >= 1e-3 => in_unit(row, format!("{}", (1e9 * x).round() / 1e9)),
        x => in_unit(row, format!("{x:e}")),
    }
}

fn in_unit(row: &Row, number: String) -> String {
    if row.unit.is_empty() { number } else { format!("{number} {}", row.unit) }
}
