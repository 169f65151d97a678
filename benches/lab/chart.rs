//! Pictures: a panel per sweep on log axes, a line per series.

use std::{ops::Range, path::Path};

use plotters::{coord::Shift, prelude::*};
use windswept_validate::{Role, Row, Sweep};

use crate::{Result, results::quantity};

/// Width and height of a panel \[px\].
const PANEL: (u32, u32) = (470, 360);
/// Height of the title above the panels, and of a line of the legend below them \[px\].
const TITLE: u32 = 34;
const LINE: u32 = 20;
/// Width of an entry of the legend without its words, and of a letter \[px\].
const ENTRY: u32 = 50;
const LETTER: u32 = 7;
/// Values are drawn no lower than this part of the panel's limit: zeros stand there.
const LOWEST: f64 = 1e-6;
/// Letters of text \[px\].
const TEXT: (&str, i32) = ("sans-serif", 12);

/// Line colours that colour-blind eyes tell apart (Okabe & Ito 2008), grey for their yellow, brown and violet after
/// them.
const COLOURS: [RGBColor; 10] = [
    RGBColor(0, 114, 178),
    RGBColor(230, 159, 0),
    RGBColor(0, 158, 115),
    RGBColor(213, 94, 0),
    RGBColor(86, 180, 233),
    RGBColor(204, 121, 167),
    RGBColor(0, 0, 0),
    RGBColor(150, 150, 150),
    RGBColor(115, 60, 15),
    RGBColor(100, 40, 170),
];

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Marks of a panel: a level that is dotted, and a row with a triangle. Defaults have rings.
pub(crate) type Marks<'a> = (Option<f64>, Option<&'a Row>);

/// A series and how it looks.
struct Line<'a> {
    series: &'a str,
    colour: RGBColor,
    /// Whether the colours have come again: dots are rings.
    again: bool,
    /// Whether the series does not compete.
    dashed: bool,
}

impl Line<'_> {
    fn dot<C>(&self, at: C) -> Circle<C, i32> {
        if self.again {
            Circle::new(at, 5, self.colour.stroke_width(2))
        } else {
            Circle::new(at, 3, self.colour.filled())
        }
    }
}

/// Draws sweeps that have an axis into an SVG file; `notes` end the legend, a line each.
pub(crate) fn draw<'a>(
    path: &Path,
    title: &str,
    notes: &[&str],
    sweeps: &'a [Sweep],
    marks: impl Fn(&'a Sweep) -> Marks<'a>,
) -> Result<()> {
    let panels: Vec<&Sweep> = sweeps.iter().filter(|sweep| sweep.axis.is_some()).collect();
    let lines = lines(sweeps);
    let columns = if panels.len() == 4 { 2 } else { panels.len().clamp(1, 3) };
    let rows = panels.len().div_ceil(columns);
    let width = PANEL.0 * columns as u32;
    let letters = lines.iter().map(|line| line.series.chars().count()).max().unwrap_or(0) as u32;
    let in_line = (width / (ENTRY + LETTER * letters)).max(1) as usize;
    let of_lines = LINE * lines.len().div_ceil(in_line) as u32;
    let below = of_lines + LINE * (notes.len() as u32 + 1);
    let root = SVGBackend::new(path, (width, TITLE + PANEL.1 * rows as u32 + below)).into_drawing_area();
    root.fill(&WHITE)?;
    root.draw(&Text::new(title, (10, 8), ("sans-serif", 18)))?;
    let (areas, legend) = root.split_vertically(TITLE).1.split_vertically(PANEL.1 * rows as u32);
    for (area, sweep) in areas.split_evenly((rows, columns)).iter().zip(&panels) {
        panel(area, sweep, &lines, marks(sweep))?;
    }
    for (i, line) in lines.iter().enumerate() {
        let (x, y) =
            ((width as usize / in_line * (i % in_line)) as i32 + 12, (LINE as usize * (i / in_line)) as i32 + 10);
        let ends = if line.dashed { vec![(x, x + 6), (x + 18, x + 24)] } else { vec![(x, x + 24)] };
        for (from, to) in ends {
            legend.draw(&PathElement::new([(from, y), (to, y)], line.colour.stroke_width(2)))?;
        }
        legend.draw(&line.dot((x + 12, y)))?;
        legend.draw(&Text::new(line.series.to_owned(), (x + 32, y - 6), TEXT))?;
    }
    for (note, k) in notes.iter().zip(0..) {
        legend.draw(&Text::new((*note).to_owned(), (12, (of_lines + LINE * k) as i32 + 4), TEXT))?;
    }
    root.present()?;
    Ok(())
}

/// Lines of a picture: those that compete and the others have the colours in their order.
fn lines(sweeps: &[Sweep]) -> Vec<Line<'_>> {
    let mut counts = [0; 2];
    let rows = || sweeps.iter().flat_map(|sweep| &sweep.rows);
    let line = |series| {
        let dashed = rows().any(|row| row.series == series && row.role == Role::Aside);
        let count: &mut usize = &mut counts[usize::from(dashed)];
        *count += 1;
        Line { series, colour: COLOURS[(*count - 1) % COLOURS.len()], again: *count > COLOURS.len(), dashed }
    };
    Sweep::series(sweeps).into_iter().map(line).collect()
}

fn panel(area: &Area<'_>, sweep: &Sweep, lines: &[Line<'_>], (dotted, chosen): Marks<'_>) -> Result<()> {
    let lowest = LOWEST * dotted.unwrap_or(1.0);
    let drawn = || sweep.rows.iter().filter(|row| row.at > 0.0 && row.measured.is_finite());
    let place = |row: &Row| (row.at, row.measured.abs().max(lowest));
    let across = range(drawn().map(|row| row.at));
    let up = range(drawn().map(|row| place(row).1).chain(dotted));
    let mut chart = ChartBuilder::on(area)
        .caption(quantity(&sweep.quantity, sweep.unit), ("sans-serif", 14))
        .margin(8)
        .x_label_area_size(40)
        .y_label_area_size(62)
        .build_cartesian_2d(
            across.clone().log_scale().with_key_points(ticks(&across)),
            up.clone().log_scale().with_key_points(ticks(&up)),
        )?;
    chart
        .configure_mesh()
        .x_desc(sweep.axis.unwrap_or_default())
        .x_label_formatter(&|x| if (1e-3..1e4).contains(x) { number(*x) } else { format!("{x:.0e}") })
        .y_label_formatter(&|y| format!("{y:.0e}"))
        .bold_line_style(RGBColor(205, 205, 205))
        .light_line_style(RGBColor(238, 238, 238))
        .label_style(("sans-serif", 11))
        .draw()?;
    if let Some(level) = dotted {
        let ends = [(across.start, level), (across.end, level)];
        chart.draw_series(DashedLineSeries::new(ends, 2, 3, BLACK.stroke_width(1)))?;
    }
    for line in lines {
        let at: Vec<(f64, f64)> = drawn().filter(|row| row.series == line.series).map(place).collect();
        let style = line.colour.stroke_width(2);
        if line.dashed {
            chart.draw_series(DashedLineSeries::new(at.iter().copied(), 6, 4, style))?;
        } else {
            chart.draw_series(LineSeries::new(at.iter().copied(), style))?;
        }
        chart.draw_series(at.iter().map(|&at| line.dot(at)))?;
    }
    let defaults = drawn().filter(|row| row.role == Role::Default);
    chart.draw_series(defaults.map(|row| Circle::new(place(row), 8, BLACK.stroke_width(2))))?;
    let corners = [(-10, 7), (10, 7), (0, -11), (-10, 7)];
    let triangle = |row| EmptyElement::at(place(row)) + PathElement::new(corners, BLACK.stroke_width(2));
    chart.draw_series(chosen.into_iter().map(triangle))?;
    Ok(())
}

/// The range of some positive values, with room around it.
fn range(values: impl Iterator<Item = f64> + Clone) -> Range<f64> {
    let low = values.clone().fold(f64::INFINITY, f64::min);
    let high = values.fold(0.0, f64::max);
    if low <= high { 0.7 * low..1.5 * high } else { 0.1..1.0 }
}

/// Ticks within a range: 1, 2 and 5 times powers of ten; over more than three decades the powers alone.
fn ticks(range: &Range<f64>) -> Vec<f64> {
    let steps: &[f64] = if range.end / range.start > 1e3 { &[1.0] } else { &[1.0, 2.0, 5.0] };
    let powers = range.start.log10().floor() as i32..=range.end.log10().ceil() as i32;
    let all = powers.flat_map(|power| steps.iter().map(move |step| step * 10_f64.powi(power)));
    all.filter(|tick| range.contains(tick)).collect()
}

/// A number as short as it is exact to three digits.
fn number(x: f64) -> String {
    let rounded: f64 = format!("{x:.2e}").parse().unwrap_or(x);
    rounded.to_string()
}
