//! `windswept validate`: formulas and independent numbers beside what this adapter computes.

use std::time::Instant;

use serde_json::json;
use windswept::{AdapterChoice, AdapterInfo, Gpu};
use windswept_validate::{CHECKS, Check, LONG_CHECKS, Row};

use crate::arguments::ValidateOptions;
use crate::console::Console;
use crate::failure::Failure;

pub(crate) fn validate(options: &ValidateOptions, console: &mut Console<'_>) -> Result<(), Failure> {
    let gpu = Gpu::new(&AdapterChoice::from_flag(options.adapter.as_deref()))?;
    console.note(format_args!("running on {}", gpu.info()));
    let mut rows = Vec::new();
    let named = |check: &&Check| options.checks.iter().any(|name| name == check.name);
    let asked: Vec<&Check> = match options.checks.is_empty() {
        true => CHECKS.iter().collect(),
        false => CHECKS.iter().chain(LONG_CHECKS).filter(named).collect(),
    };
    for check in asked {
        let started = Instant::now();
        let measured = check.rows(&gpu);
        let (passed, seconds) = (passing(&measured), started.elapsed().as_secs_f64());
        console.note(format_args!("{}: {passed} of {} pass, {seconds:.1} s", check.name, measured.len()));
        rows.extend(measured);
    }
    if options.json {
        document(gpu.info(), &rows, console)?
    } else {
        table(gpu.info(), &rows, console)
    }
    verdict(&rows)
}

/// The end of the command: one row that does not pass is a failed run.
fn verdict(rows: &[Row]) -> Result<(), Failure> {
    match rows.len() - passing(rows) {
        0 => Ok(()),
        failed => Err(Failure::Run(format!("{failed} of {} do not pass on this adapter", rows.len()))),
    }
}

fn passing(rows: &[Row]) -> usize {
    rows.iter().filter(|row| row.passes()).count()
}

fn table(adapter: &AdapterInfo, rows: &[Row], console: &mut Console<'_>) {
    let width = rows.iter().map(|row| row.quantity.chars().count()).max().unwrap_or(0);
    console.print(format_args!("windswept {} on {adapter}", env!("CARGO_PKG_VERSION")));
    console.print(format_args!(
        "{:<width$}  {:>13}  {:>13}  {:>9}  {:<5}  pass",
        "test", "expected", "measured", "tolerance", "unit"
    ));
    for row in rows {
        console.print(format_args!(
            "{:<width$}  {:>13}  {:>13}  {:>9}  {:<5}  {}",
            row.quantity,
            number(row.expected),
            number(row.measured),
            format!("{:.1e}", row.tolerance),
            row.unit,
            if row.passes() { "yes" } else { "NO" },
        ));
    }
    console.print(format_args!("{} of {} pass", passing(rows), rows.len()));
}

/// Eight decimals, or powers of ten where these would show fewer than four digits.
fn number(x: f64) -> String {
    if x == 0.0 || x.abs() >= 1e-4 { format!("{x:.8}") } else { format!("{x:.3e}") }
}

fn document(adapter: &AdapterInfo, rows: &[Row], console: &mut Console<'_>) -> Result<(), Failure> {
    let all = json!({
        "windswept": env!("CARGO_PKG_VERSION"),
        "adapter": adapter,
        "rows": rows,
        "passed": passing(rows) == rows.len(),
    });
    let text = serde_json::to_string_pretty(&all);
    console.print_lines(text.map_err(|e| Failure::Run(format!("the rows cannot be written: {e}")))?);
    Ok(())
}

#[cfg(test)]
mod tests {
    use windswept::AdapterInfo;
    use windswept_validate::Row;

    use super::{number, table, verdict};
    use crate::console::Console;

    fn row(test: &str, measured: f64) -> Row {
        Row::new(test, 1.0, measured, 1e-6, "here").in_unit("m")
    }

    /// One row that does not pass, or could not be measured, ends the command with status 1; none with 0.
    #[test]
    fn a_row_that_does_not_pass_is_status_1() {
        assert!(verdict(&[row("good", 1.0), row("good", 1.0)]).is_ok());
        for bad in [1.1, f64::NAN] {
            let failure = verdict(&[row("good", 1.0), row("bad", bad)]).err();
            let failure = failure.map(|failure| (failure.status(), failure.render(false)));
            assert_eq!(failure, Some((1, "error: 1 of 2 do not pass on this adapter".to_owned())));
        }
    }

    /// Every row is a line with its verdict, and the last line counts.
    #[test]
    fn a_table_says_what_does_not_pass() {
        let rows = [row("good", 1.0), row("bad", 1.1), row("lost", f64::NAN)];
        let adapter =
            AdapterInfo { name: "none".into(), backend: "vulkan".into(), driver: "0".into(), kind: "software".into() };
        let (mut out, mut err) = (Vec::new(), Vec::new());
        table(&adapter, &rows, &mut Console::new(&mut out, &mut err, false));
        let text = String::from_utf8_lossy(&out);
        let lines: Vec<_> = text.lines().collect();
        assert!(lines[0].ends_with("on none (software, vulkan, 0)"), "{text}");
        let verdicts: Vec<_> = lines[2..5].iter().map(|line| line.split_whitespace().last()).collect();
        assert_eq!(verdicts, [Some("yes"), Some("NO"), Some("NO")], "{text}");
        assert_eq!(lines[5], "1 of 3 pass");
        assert!(err.is_empty());
    }

    #[test]
    fn small_numbers_keep_their_digits() {
        assert_eq!(
            [0.0, 0.945_050_23, 3.988e-5, -0.1].map(number),
            ["0.00000000", "0.94505023", "3.988e-5", "-0.10000000"]
        );
    }
}
