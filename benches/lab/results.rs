//! The files that studies write: rows as CSV, below lines with `#` that say how they were measured, and tables of many
//! measurements, whose parts are replaced one by one. `docs/generate.py` makes pages of them.

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

/// Writes rows of a table, whose first cell says what they are of, in the place of those of the same that it had;
/// others stay.
pub(crate) fn replace(path: &Path, columns: &[&str], rows: &[Vec<String>]) -> Result<()> {
    let before = fs::read_to_string(path).unwrap_or_default();
    let mut all = Vec::new();
    for record in csv::Reader::from_reader(before.as_bytes()).records() {
        all.push(record?.iter().map(str::to_owned).collect::<Vec<_>>());
    }
    for group in rows.chunk_by(|a, b| a[0] == b[0]) {
        let place = all.iter().position(|row| row[0] == group[0][0]).unwrap_or(all.len());
        all.retain(|row| row[0] != group[0][0]);
        all.splice(place..place, group.iter().cloned());
    }
    let mut table = csv::Writer::from_writer(Vec::new());
    table.write_record(columns)?;
    all.iter().try_for_each(|row| table.write_record(row))?;
    fs::create_dir_all(path.parent().unwrap_or(path))?;
    fs::write(path, table.into_inner()?)?;
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
