//! The page of results: a table, what does not hold, and the pictures.

use std::{fmt::Write, time::Duration};

use windswept::Gpu;
use windswept_validate::stress::{Sample, Sweep};

use crate::{Stressed, chart, provenance};

/// Settings of a sweep that does not hold which the page names.
const NAMED: usize = 6;

/// The page as Markdown.
pub(crate) fn page(gpu: &Gpu, all: &[Stressed], took: Duration) -> String {
    let rows = || all.iter().flat_map(|stressed| stressed.sweeps.iter().map(move |sweep| (stressed, sweep)));
    let holding = rows().filter(|(_, sweep)| sweep.failing() == 0).count();
    let mut text = format!(
        "# Stress\n\nMade by `cargo xtask stress`; [README](../README.md#stress) says how to read it. {holding} of {} rows hold.\n\n\
         adapter: {}  \ncommit: {}  \ndate: {}, took {:.0} s\n\n\
         | Stress | Settings | Quantity | Worst | at | Bound | Holds |\n|---|---|---|---|---|---|---|\n",
        rows().count(),
        gpu.info(),
        provenance::commit(),
        provenance::date(),
        took.as_secs_f64(),
    );
    for (stressed, sweep) in rows() {
        let first = std::ptr::eq(sweep, &raw const stressed.sweeps[0]);
        let (name, swept) = if first { (stressed.stress.name, stressed.stress.swept) } else { ("", "") };
        let cells = [name.to_owned(), swept.to_owned(), sweep.quantity.clone(), worst(sweep), holds(sweep)];
        writeln!(text, "| {} |", cells.join(" | ")).unwrap_or_default();
    }
    text.push_str("\n## What does not hold\n\n");
    for (stressed, sweep) in rows().filter(|(_, sweep)| sweep.failing() > 0) {
        writeln!(text, "* **{}, {}**: {}", stressed.stress.name, sweep.quantity, failures(sweep)).unwrap_or_default();
    }
    for stressed in all {
        if let Some(file) = chart::file(stressed) {
            write!(
                text,
                "\n## {}\n\n{}.\n\n![{}]({file})\n",
                stressed.stress.name, stressed.stress.swept, stressed.stress.name
            )
            .unwrap_or_default();
        }
    }
    text
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
        |worst| format!("{} | {} | {}", value(sweep, worst.measured), place(worst), value(sweep, worst.bound)),
    )
}

fn holds(sweep: &Sweep) -> String {
    match sweep.failing() {
        0 => "yes".to_owned(),
        failing => format!("**no**: {failing} of {}", sweep.samples.len()),
    }
}

fn failures(sweep: &Sweep) -> String {
    let failing = sweep.samples.iter().filter(|sample| !sample.holds());
    let named: Vec<_> = failing
        .clone()
        .take(NAMED)
        .map(|sample| format!("{} {}", place(sample), value(sweep, sample.measured)))
        .collect();
    let more = failing.count() - named.len();
    let more = if more > 0 { format!("; and {more} more") } else { String::new() };
    format!("{}{more}", named.join("; "))
}

fn place(sample: &Sample) -> String {
    format!("{}, {}", sample.series, sample.setting).replace('|', "/").replace('\n', " ")
}

fn value(sweep: &Sweep, value: f64) -> String {
    let number = match value {
        value if value == f64::INFINITY => return "none".to_owned(),
        value if value == value.round() && value.abs() < 1e6 => format!("{value}"),
        value if (1e-3..1e4).contains(&value.abs()) => format!("{value:.3}"),
        value => format!("{value:.2e}"),
    };
    if sweep.unit.is_empty() { number } else { format!("{number} {}", sweep.unit) }
}
