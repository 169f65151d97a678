//! Pictures: error over time on log axes, a panel per error, a line per series.

use std::path::Path;

use plotters::{
    prelude::*,
    style::text_anchor::{HPos, Pos, VPos},
};

use crate::{
    Family, Result,
    axes::{self, Area, Axis, COLOURS, LEGEND_LINE, PANEL, TITLE, number, power, range},
    point::{Point, distinct},
    rule,
};

/// Number of entries in a line of the legend.
const LEGEND_COLUMNS: usize = 3;

/// Draws the points of a family into an SVG file.
pub(crate) fn draw(path: &Path, family: &Family, points: &[Point]) -> Result<()> {
    let kinds = distinct(points, |point| &point.error_kind);
    let lines = lines(points);
    let columns = if kinds.len() == 4 { 2 } else { kinds.len().clamp(1, 3) };
    let rows = kinds.len().div_ceil(columns);
    let entries = lines.len() + NOTES;
    let legend = LEGEND_LINE * (entries.div_ceil(LEGEND_COLUMNS) as u32 + 1);
    let size = (PANEL.0 * columns as u32, TITLE + PANEL.1 * rows as u32 + legend);
    let root = SVGBackend::new(path, size).into_drawing_area();
    root.fill(&WHITE)?;
    root.draw(&Text::new(family.title, (10, 8), ("sans-serif", 18)))?;
    let (_, below) = root.split_vertically(TITLE);
    let (panels, keys) = below.split_vertically(PANEL.1 * rows as u32);
    for (area, kind) in panels.split_evenly((rows, columns)).iter().zip(&kinds) {
        let of_kind: Vec<&Point> = points.iter().filter(|point| point.error_kind == *kind).collect();
        panel(area, family, kind, &lines, &of_kind)?;
    }
    key(&keys, family, &lines)?;
    root.present()?;
    Ok(())
}

/// A series and how it looks.
struct Line<'a> {
    series: &'a str,
    colour: RGBColor,
    dashed: bool,
}

/// Lines of a picture, in the order of the colours: candidates are full, the others dashed.
fn lines(points: &[Point]) -> Vec<Line<'_>> {
    let mut counts = [0; 2];
    let line = |series| {
        let dashed = points.iter().any(|point| point.series == series && !point.candidate);
        let count: &mut usize = &mut counts[usize::from(dashed)];
        let colour = COLOURS[*count % COLOURS.len()];
        *count += 1;
        Line { series, colour, dashed }
    };
    distinct(points, |point| &point.series).into_iter().map(line).collect()
}

fn panel(area: &Area<'_>, family: &Family, kind: &str, lines: &[Line<'_>], points: &[&Point]) -> Result<()> {
    let drawn: Vec<&Point> = points.iter().copied().filter(|point| point.is_finite()).collect();
    let x = Axis { label: family.time, range: range(drawn.iter().map(|p| p.ms)), number: |ms| number(*ms) };
    let y = Axis { label: "error", range: range(drawn.iter().map(|p| p.error)), number: power };
    let mut chart = axes::panel(area, kind, &x, &y)?;
    if let Some(floor) = rule::floor(points) {
        let top = rule::FLOOR * floor;
        let ends = [(x.range.start, top), (x.range.end, top)];
        chart.draw_series(DashedLineSeries::new(ends, 2, 3, BLACK.stroke_width(1)))?;
    }
    for line in lines {
        let at: Vec<(f64, f64)> = drawn.iter().filter(|p| p.series == line.series).map(|p| (p.ms, p.error)).collect();
        let style = line.colour.stroke_width(2);
        if line.dashed {
            chart.draw_series(DashedLineSeries::new(at.iter().copied(), 6, 4, style))?;
        } else {
            chart.draw_series(LineSeries::new(at.iter().copied(), style))?;
        }
        chart.draw_series(at.iter().map(|&at| Circle::new(at, 3, line.colour.filled())))?;
    }
    let defaults = drawn.iter().filter(|point| point.default);
    chart.draw_series(defaults.map(|p| Circle::new((p.ms, p.error), 8, BLACK.stroke_width(2))))?;
    let choice = rule::choice(points);
    chart.draw_series(choice.iter().map(|p| EmptyElement::at((p.ms, p.error)) + triangle((0, 0))))?;
    Ok(())
}

/// The mark of the rule's choice about a pixel.
fn triangle((x, y): (i32, i32)) -> PathElement<(i32, i32)> {
    PathElement::new([(x - 10, y + 7), (x + 10, y + 7), (x, y - 11), (x - 10, y + 7)], BLACK.stroke_width(2))
}

/// Number of entries of the legend that are no series.
const NOTES: usize = 2;

fn key(area: &Area<'_>, family: &Family, lines: &[Line<'_>]) -> Result<()> {
    let (width, _) = area.dim_in_pixel();
    let column = width as i32 / LEGEND_COLUMNS as i32;
    let middle = Pos::new(HPos::Left, VPos::Center);
    let text = |words: &str, x: i32, y: i32| {
        let style = ("sans-serif", 12).into_text_style(area).pos(middle);
        Text::new(words.to_owned(), (x, y), style)
    };
    let place = |i: usize| {
        let (row, col) = (i / LEGEND_COLUMNS, i % LEGEND_COLUMNS);
        (12 + column * col as i32, LEGEND_LINE as i32 * row as i32 + 10)
    };
    for (i, line) in lines.iter().enumerate() {
        let (x, y) = place(i);
        let style = line.colour.stroke_width(2);
        let ends = if line.dashed { vec![(x, x + 6), (x + 18, x + 24)] } else { vec![(x, x + 24)] };
        for (from, to) in ends {
            area.draw(&PathElement::new(vec![(from, y), (to, y)], style))?;
        }
        area.draw(&Circle::new((x + 12, y), 3, line.colour.filled()))?;
        area.draw(&text(line.series, x + 32, y))?;
    }
    let (x, y) = place(lines.len());
    area.draw(&Circle::new((x + 12, y), 8, BLACK.stroke_width(2)))?;
    area.draw(&text("the default now", x + 32, y))?;
    let (x, y) = place(lines.len() + 1);
    area.draw(&triangle((x + 12, y)))?;
    area.draw(&text("the rule's choice: the cheapest below the dotted line", x + 32, y))?;
    let last = (lines.len() + NOTES).next_multiple_of(LEGEND_COLUMNS);
    let (x, y) = place(last);
    area.draw(&text(&format!("dotted: 1.1 × the floor; {}", family.along), x, y))?;
    Ok(())
}
