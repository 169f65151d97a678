//! The page of results: a table, what does not hold, and the pictures.

use std::{fmt::Write, time::Duration};

use windswept::Gpu;
use windswept_validate::stress::{STRESSES, Sample, Stress, Sweep};

use crate::{Stressed, chart, provenance};

/// Settings of a sweep that does not hold which the page names.
const NAMED: usize = 20;

/// The page as Markdown. Parts of `before`, the page that is there, about stresses that were not run now stay.
pub(crate) fn page(gpu: &Gpu, all: &[Stressed], took: Duration, before: &str) -> String {
    let of = |stress: &Stress| all.iter().find(|stressed| stressed.stress.name == stress.name);
    let parts: Vec<Part> =
        STRESSES.iter().filter_map(|s| of(s).map(Part::of).or_else(|| Part::in_page(before, s))).collect();
    let rows: String = parts.iter().map(|part| part.rows.as_str()).collect();
    let failures: String = parts.iter().map(|part| part.failures.as_str()).collect();
    let pictures: String = parts.iter().map(|part| part.picture.as_str()).collect();
    let ends = |with: &str| rows.lines().filter(|row| row.ends_with(&format!("| {with} |"))).count();
    let (holding, bounded) = (ends(HOLDS), rows.lines().count() - ends(UNBOUNDED));
    let commit = provenance::commit();
    let (date, took) = (provenance::date(), took.as_secs_f64());
    let names: Vec<_> = all.iter().map(|stressed| stressed.stress.name).collect();
    let run = match provenance_in(before).filter(|_| parts.len() > all.len()) {
        Some(whole) => format!("{whole}  \nrun again: {}; commit {commit}, {date}, took {took:.0} s", names.join(", ")),
        None => format!("adapter: {}  \ncommit: {commit}  \ndate: {date}, took {took:.0} s", provenance::machine(gpu)),
    };
    format!(
        "# Stress\n\nMade by `cargo xtask stress`; [README](../README.md#stress) says how to read it. {holding} of {bounded} rows hold.\n\n\
         {run}\n\n{TABLE}{rows}\n{FAILURES}{failures}{pictures}",
    )
}

const TABLE: &str = "| Stress | Settings | Quantity | Worst | at | Bound | Holds |\n|---|---|---|---|---|---|---|\n";
const FAILURES: &str = "## What does not hold\n\n";
/// Last column of a row that holds, and of a row without a bound.
const HOLDS: &str = "yes";
const UNBOUNDED: &str = "–";

/// When, where and of what commit a page was made.
fn provenance_in(page: &str) -> Option<&str> {
    let (head, _) = page.split_once(&format!("\n\n{TABLE}"))?;
    head.split_once("rows hold.\n\n").map(|(_, run)| run)
}

/// Part of a page about a stress.
#[derive(Default)]
struct Part {
    /// Rows of the table.
    rows: String,
    /// Lines about what does not hold.
    failures: String,
    /// Section with the picture, where there is one.
    picture: String,
}

impl Part {
    fn of(stressed: &Stressed) -> Self {
        let (name, swept) = (stressed.stress.name, stressed.stress.swept);
        let mut part = Self::default();
        for (k, sweep) in stressed.sweeps.iter().enumerate() {
            let (first, second) = if k == 0 { (name, swept) } else { ("", "") };
            let cells = [first.to_owned(), second.to_owned(), sweep.quantity.clone(), worst(sweep), holds(sweep)];
            part.rows += &format!("| {} |\n", cells.join(" | "));
            if sweep.failing() > 0 {
                part.failures += &format!("* **{name}, {}**: {}\n", sweep.quantity, failures(sweep));
            }
        }
        if let Some(file) = chart::file(stressed) {
            part.picture = format!("\n## {name}\n\n{swept}.\n\n![{name}]({file})\n");
        }
        part
    }

    /// Part of an earlier page about a stress, if it has one.
    fn in_page(page: &str, stress: &Stress) -> Option<Self> {
        let lines = |text: &str, mut keep: Box<dyn FnMut(&str) -> bool + '_>| -> String {
            text.lines().filter(|line| keep(line)).flat_map(|line| [line, "\n"]).collect()
        };
        let (table, rest) = page.split_once(TABLE)?.1.split_once(FAILURES)?;
        let mut own = false;
        let own_rows = |row: &str| {
            let first = row.split(" | ").next().unwrap_or_default().trim_start_matches('|').trim();
            own = if first.is_empty() { own } else { first == stress.name };
            own && row.starts_with('|')
        };
        let rows = lines(table, Box::new(own_rows));
        let start = format!("* **{}, ", stress.name);
        let failures = lines(rest, Box::new(|line| line.starts_with(&start)));
        let picture = rest.split("\n## ").find(|section| section.starts_with(&format!("{}\n", stress.name)));
        let picture = picture.map_or_else(String::new, |section| format!("\n## {}\n", section.trim_end()));
        (!rows.is_empty()).then_some(Self { rows, failures, picture })
    }
}

/// The rows of a stress as they are printed.
pub(crate) fn lines(stressed: &Stressed) -> String {
    let mut text = format!("{} ({:.0} s)", stressed.stress.name, stressed.took.as_secs_f64());
    for sweep in &stressed.sweeps {
        write!(text, "\n  {}: {} | {}", sweep.quantity, worst(sweep), holds(sweep)).unwrap_or_default();
        if sweep.failing() > 0 {
            write!(text, "\n    {}", failures(sweep)).unwrap_or_default();
        }
    }
    text
}

fn worst(sweep: &Sweep) -> String {
    sweep.worst().map_or_else(
        || "nothing | | ".to_owned(),
        |worst| format!("{} | {} | {}", measured(sweep, worst), place(worst), in_unit(sweep, bound(worst.bound))),
    )
}

fn holds(sweep: &Sweep) -> String {
    match sweep.failing() {
        0 if sweep.samples.iter().all(|sample| sample.bound.is_infinite()) => UNBOUNDED.to_owned(),
        0 => HOLDS.to_owned(),
        failing => format!("**no**: {failing} of {}", sweep.samples.len()),
    }
}

fn failures(sweep: &Sweep) -> String {
    let failing = sweep.samples.iter().filter(|sample| !sample.holds());
    let named: Vec<_> =
        failing.clone().take(NAMED).map(|sample| format!("{} {}", place(sample), measured(sweep, sample))).collect();
    let more = failing.count() - named.len();
    let more = if more > 0 { format!("; and {more} more") } else { String::new() };
    format!("{}{more}", named.join("; "))
}

fn place(sample: &Sample) -> String {
    let parts = [sample.series.as_str(), sample.setting.as_str()];
    parts
        .into_iter()
        .filter(|part| !part.is_empty())
        .collect::<Vec<_>>()
        .join(", ")
        .replace('|', "/")
        .replace('\n', " ")
}

/// Significant digits of a value.
const DIGITS: usize = 3;

/// The value of a sample, with as many digits as show on which side of its bound it is.
fn measured(sweep: &Sweep, sample: &Sample) -> String {
    let as_bound = |text: &String| text.parse() == Ok(sample.bound) && sample.measured != sample.bound;
    let number = (DIGITS..17).map(|digits| number(sample.measured, digits)).find(|text| !as_bound(text));
    in_unit(sweep, number.unwrap_or_else(|| sample.measured.to_string()))
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

/// A bound as it is, but for what rounding added to one that was computed.
fn bound(x: f64) -> String {
    match x {
        f64::INFINITY => "none".to_owned(),
        x if x == 0.0 || x >= 1e-3 => format!("{}", (1e9 * x).round() / 1e9),
        x => format!("{x:e}"),
    }
}

fn in_unit(sweep: &Sweep, number: String) -> String {
    if sweep.unit.is_empty() || number == bound(f64::INFINITY) { number } else { format!("{number} {}", sweep.unit) }
}
