//! Common parts of pictures of panels on log axes: sizes, colours, axes, numbers.

use std::ops::Range;

use plotters::{
    coord::{
        Shift,
        combinators::{LogCoord, WithKeyPoints},
    },
    prelude::*,
};

use crate::Result;

/// Width and height of a panel \[px\].
pub(crate) const PANEL: (u32, u32) = (470, 360);
/// Height of the title above the panels \[px\].
pub(crate) const TITLE: u32 = 34;
/// Height of a line of the legend below the panels \[px\].
pub(crate) const LEGEND_LINE: u32 = 20;

/// Where a picture or a panel is drawn.
pub(crate) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
/// A log axis with its ticks.
type Ticked = WithKeyPoints<LogCoord<f64>>;
/// A panel with its axes.
pub(crate) type Panel<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<Ticked, Ticked>>;

/// An axis of a panel.
pub(crate) struct Axis<'a> {
    pub(crate) label: &'a str,
    pub(crate) range: Range<f64>,
    pub(crate) number: fn(&f64) -> String,
}

/// Draws the caption, the axes and their mesh.
pub(crate) fn panel<'a, 'b>(area: &'a Area<'b>, caption: &str, x: &Axis<'_>, y: &Axis<'_>) -> Result<Panel<'a, 'b>> {
    let coordinate = |axis: &Axis<'_>| axis.range.clone().log_scale().with_key_points(ticks(&axis.range));
    let mut panel = ChartBuilder::on(area)
        .caption(caption, ("sans-serif", 14))
        .margin(8)
        .x_label_area_size(40)
        .y_label_area_size(62)
        .build_cartesian_2d(coordinate(x), coordinate(y))?;
    panel
        .configure_mesh()
        .x_desc(x.label)
        .y_desc(y.label)
        .x_label_formatter(&x.number)
        .y_label_formatter(&y.number)
        .bold_line_style(RGBColor(205, 205, 205))
        .light_line_style(RGBColor(238, 238, 238))
        .label_style(("sans-serif", 11))
        .draw()?;
    Ok(panel)
}

/// A power of ten, or a number near one.
pub(crate) fn power(x: &f64) -> String {
    format!("{x:.0e}")
}

/// Line colours that colour-blind eyes tell apart (Okabe & Ito 2008), grey for their yellow, brown and violet after
/// them.
pub(crate) const COLOURS: [RGBColor; 10] = [
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

/// The range of some positive values, with room around it.
pub(crate) fn range(values: impl Iterator<Item = f64> + Clone) -> Range<f64> {
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
pub(crate) fn number(x: f64) -> String {
    let rounded: f64 = format!("{x:.2e}").parse().unwrap_or(x);
    rounded.to_string()
}
