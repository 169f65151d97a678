//! What pictures on log axes share: colours, ranges, ticks, numbers.

use plotters::style::RGBColor;

/// Line colours that colour-blind eyes tell apart (Okabe & Ito 2008), grey for their yellow, brown and violet after them.
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
pub(crate) fn range(values: impl Iterator<Item = f64> + Clone) -> std::ops::Range<f64> {
    let low = values.clone().fold(f64::INFINITY, f64::min);
    let high = values.fold(0.0, f64::max);
    if low <= high { 0.7 * low..1.5 * high } else { 0.1..1.0 }
}

/// Ticks within a range: 1, 2 and 5 times powers of ten; over more than three decades the powers alone.
pub(crate) fn ticks(range: &std::ops::Range<f64>) -> Vec<f64> {
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
