//! The files that are written: a CSV file and a picture per family, and what the rule says of each.

use std::{
    fmt::Write,
    fs,
    path::{Path, PathBuf},
};

use crate::{
    Bench, FAMILIES, Family, Measured, Result, chart,
    point::{Point, distinct},
    provenance, rule,
};

/// Writes DIR/family.csv: what was measured, on what and when, in `#` lines before the table.
pub(crate) fn write_csv(dir: &Path, family: &Family, bench: &Bench, measured: &Measured, seconds: f64) -> Result<()> {
    fs::create_dir_all(dir)?;
    let mut head = vec![
        format!("{} (cargo bench --bench work_precision -- {})", family.title, family.name),
        format!("adapter: {}", provenance::machine(&bench.gpu)),
        format!("commit: {}", provenance::commit()),
        format!("date: {}, took {seconds:.0} s{}", provenance::date(), quickly(bench)),
    ];
    head.extend(measured.notes.iter().cloned());
    head.push(format!("ms: {}; the least of several runs", family.time));
    head.push(
        "uncertainty: of what the error is taken from; default: the setting of a scene that names none".to_owned(),
    );
    head.push("candidate: may become the default of accurate".to_owned());
    let mut text: String = head.iter().map(|line| format!("# {line}\n")).collect();
    let mut table = csv::Writer::from_writer(Vec::new());
    for point in &measured.points {
        table.serialize(point)?;
    }
    text.push_str(&String::from_utf8(table.into_inner()?)?);
    fs::write(csv_path(dir, family), text)?;
    Ok(())
}

fn quickly(bench: &Bench) -> &'static str {
    if bench.quick { "; a quick run: no figure of it means anything" } else { "" }
}

fn csv_path(dir: &Path, family: &Family) -> PathBuf {
    dir.join(family.name).with_extension("csv")
}

/// Draws DIR/family.svg of every family that has a CSV file, and writes DIR/defaults.md.
pub(crate) fn show(dir: &Path) -> Result<()> {
    let mut text =
        "# What the rule picks\n\nMade by `cargo bench --bench work_precision`; see [README](../README.md). \
        The rule: of the settings within 10 % of the floor, the cheapest. \
        The floor is the least error, or how uncertain that is with which it is compared. \
        Where a single setting reaches it there is no floor, and the knee is chosen: the setting after which twice the time buys \
        less than a halving of the error.\n"
            .to_owned();
    for family in FAMILIES {
        let path = csv_path(dir, family);
        if !path.exists() {
            continue;
        }
        let file = fs::read_to_string(&path)?;
        let points = csv::ReaderBuilder::new()
            .comment(Some(b'#'))
            .from_reader(file.as_bytes())
            .into_deserialize()
            .collect::<std::result::Result<Vec<Point>, _>>()?;
        chart::draw(&path.with_extension("svg"), family, &points)?;
        write!(text, "\n## {}\n\n", family.title)?;
        for line in file.lines().take_while(|line| line.starts_with('#')).filter(|line| provenance(line)) {
            writeln!(text, "{}  ", line.trim_start_matches("# "))?;
        }
        text.push_str(&table(&points));
    }
    fs::write(dir.join("defaults.md"), text)?;
    Ok(())
}

fn provenance(line: &str) -> bool {
    ["# adapter:", "# commit:", "# date:"].iter().any(|start| line.starts_with(start))
}

/// Table of the rule's choice and the default for each error.
fn table(points: &[Point]) -> String {
    let mut text =
        "\n| Error | Floor | Rule's choice | ms | error | Default | ms | error | Default over choice: time, error |\n\
        |---|---|---|---|---|---|---|---|---|\n"
            .to_owned();
    for kind in distinct(points, |point| &point.error_kind) {
        let of_kind: Vec<&Point> = points.iter().filter(|point| point.error_kind == kind).collect();
        let cells = |point: Option<&Point>| match point {
            Some(p) => format!("{}, {} | {:.3} | {:.2e}", p.series, p.setting, p.ms, p.error),
            None => "not among the settings | | ".to_owned(),
        };
        let (choice, default) = (rule::choice(&of_kind), of_kind.iter().copied().find(|point| point.default));
        let ratio = choice.zip(default).map(|(c, d)| format!("{:.2}, {:.2}", d.ms / c.ms, d.error / c.error));
        let floor = rule::floor(&of_kind).map_or_else(|| "none".to_owned(), |floor| format!("{floor:.2e}"));
        let row = [kind.to_owned(), floor, cells(choice), cells(default), ratio.unwrap_or_default()];
        text.push_str(&format!("| {} |\n", row.join(" | ")));
    }
    text
}
