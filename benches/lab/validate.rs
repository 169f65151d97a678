//! The rows of `windswept validate` on this adapter: `cargo xtask bench validate [CHECK…]`. Writes those of each check
//! into `validate.csv`, of which the book makes its pages.

use windswept_validate::{CHECKS, Check, LONG_CHECKS};

use crate::{Lab, Result, asked, provenance, results};

#[derive(clap::Args, Default)]
pub(crate) struct Arguments {
    /// Checks to run, those that take minutes by name only [default: the others]
    checks: Vec<String>,
}

const COLUMNS: [&str; 10] =
    ["check", "adapter", "commit", "date", "quantity", "expected", "measured", "tolerance", "unit", "passed"];

pub(crate) fn run(lab: &Lab, Arguments { checks }: &Arguments) -> Result<()> {
    let all = match checks.is_empty() {
        true => CHECKS.to_vec(),
        false => [CHECKS, LONG_CHECKS].concat(),
    };
    let provenance = provenance::now(&lab.gpu).map(|(_, value)| value);
    for check in lab.some(&asked(&all, |check: &Check| check.name, checks)?) {
        let measured = check.rows(&lab.gpu);
        println!("{}: {} of {} pass", check.name, measured.iter().filter(|row| row.passes()).count(), measured.len());
        let mut rows = Vec::new();
        for row in measured {
            let [adapter, commit, date] = provenance.clone();
            let [expected, measured, tolerance] = [row.expected, row.measured, row.tolerance].map(|x| x.to_string());
            let (unit, passed) = (row.unit.to_owned(), row.passes().to_string());
            let check = check.name.to_owned();
            rows.push(vec![check, adapter, commit, date, row.quantity, expected, measured, tolerance, unit, passed]);
        }
        if !lab.quick {
            results::replace(&lab.out.join("validate.csv"), &COLUMNS, &rows)?;
        }
    }
    Ok(())
}
