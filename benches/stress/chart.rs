//! Pictures: a panel per sweep that has an axis, a line per series, and the bound.

use std::path::Path;

use plotters::prelude::*;
use windswept_validate::stress::{Sample, Sweep};

use crate::{
    Result, Stressed,
    axes::{self, Area, Axis, COLOURS, LEGEND_LINE, PANEL, TITLE, number, power, range},
};

/// Entries in a line of the legend, per panel; one where a name has more letters than fit half a panel.
const COLUMNS: usize = 2;
const LETTERS: usize = 30;
/// Values of a curve are drawn no lower than this part of its bound: zeros stand there.
const LOWEST: f64 = 1e-6;

/// Name of the picture of a stress; `None` where no sweep has an axis.
pub(crate) fn file(stressed: &Stressed) -> Option<String> {
    drawn(stressed).next().map(|_| format!("stress-{}.svg", stressed.stress.name.replace(' ', "-")))
}

fn drawn(stressed: &Stressed) -> impl Iterator<Item = &Sweep> {
    stressed.sweeps.iter().filter(|sweep| sweep.axis.is_some())
}

/// Draws the picture of a stress into a folder.
pub(crate) fn draw(folder: &Path, stressed: &Stressed) -> Result<()> {
    let Some(file) = file(stressed) else { return Ok(()) };
    let sweeps: Vec<&Sweep> = drawn(stressed).collect();
    let mut series: Vec<&str> = Vec::new();
    for sample in sweeps.iter().flat_map(|sweep| &sweep.samples) {
        if !series.contains(&sample.series.as_str()) {
            series.push(&sample.series);
        }
    }
    let wide = series.iter().any(|name| name.len() > LETTERS);
    let columns = if wide { sweeps.len() } else { COLUMNS * sweeps.len() };
    let legend = LEGEND_LINE * ((series.len() + 1).div_ceil(columns) as u32 + 1);
    let size = (PANEL.0 * sweeps.len() as u32, TITLE + PANEL.1 + legend);
    let path = folder.join(file);
    let root = SVGBackend::new(&path, size).into_drawing_area();
    root.fill(&WHITE)?;
    root.draw(&Text::new(format!("Stress: {}", stressed.stress.name), (10, 8), ("sans-serif", 18)))?;
    let (_, below) = root.split_vertically(TITLE);
    let (panels, keys) = below.split_vertically(PANEL.1);
    for (area, sweep) in panels.split_evenly((1, sweeps.len())).iter().zip(&sweeps) {
        panel(area, sweep, &series)?;
    }
    let place = |i: usize| {
        (12 + (size.0 as usize / columns * (i % columns)) as i32, (LEGEND_LINE as usize * (i / columns)) as i32 + 10)
    };
    for (i, name) in series.iter().enumerate() {
        let (x, y) = place(i);
        keys.draw(&PathElement::new([(x, y), (x + 24, y)], style(i)))?;
        keys.draw(&mark(i, (x + 12, y)))?;
        keys.draw(&Text::new((*name).to_owned(), (x + 32, y - 6), ("sans-serif", 12)))?;
    }
    if sweeps.iter().flat_map(|sweep| &sweep.samples).any(|sample| sample.bound.is_finite()) {
        let (x, y) = place(series.len());
        keys.draw(&Text::new("dotted: the bound".to_owned(), (x, y - 6), ("sans-serif", 12)))?;
    }
    root.present()?;
    Ok(())
}

fn style(i: usize) -> ShapeStyle {
    COLOURS[i % COLOURS.len()].stroke_width(2)
}

/// The dot of a series: full, or a ring once the colours come again.
fn mark<C>(i: usize, at: C) -> Circle<C, i32> {
    let colour = COLOURS[i % COLOURS.len()];
    if i < COLOURS.len() { Circle::new(at, 3, colour.filled()) } else { Circle::new(at, 5, colour.stroke_width(2)) }
}

fn panel(area: &Area<'_>, sweep: &Sweep, series: &[&str]) -> Result<()> {
    let shown = |sample: &&Sample| sample.at > 0.0 && sample.measured.is_finite();
    let bound = sweep.samples.iter().map(|sample| sample.bound).filter(|bound| bound.is_finite()).fold(0.0, f64::max);
    let height = |sample: &Sample| sample.measured.abs().max(LOWEST * if bound > 0.0 { bound } else { 1.0 });
    let all: Vec<&Sample> = sweep.samples.iter().filter(shown).collect();
    let bounds = (bound > 0.0).then_some(bound);
    let unit = if sweep.unit.is_empty() { String::new() } else { format!(" [{}]", sweep.unit) };
    let x = Axis {
        label: sweep.axis.unwrap_or_default(),
        range: range(all.iter().map(|s| s.at)),
        number: |x| if (1e-3..1e4).contains(x) { number(*x) } else { power(x) },
    };
    let y = Axis { label: "", range: range(all.iter().map(|s| height(s)).chain(bounds)), number: power };
    let mut chart = axes::panel(area, &format!("{}{unit}", sweep.quantity), &x, &y)?;
    if let Some(bound) = bounds {
        chart.draw_series(DashedLineSeries::new(
            [(x.range.start, bound), (x.range.end, bound)],
            2,
            3,
            BLACK.stroke_width(1),
        ))?;
    }
    for (i, name) in series.iter().enumerate() {
        let at: Vec<(f64, f64)> = all.iter().filter(|s| s.series == *name).map(|s| (s.at, height(s))).collect();
        chart.draw_series(LineSeries::new(at.iter().copied(), style(i)))?;
        chart.draw_series(at.iter().map(|&at| mark(i, at)))?;
    }
    Ok(())
}
