//! The rule that defaults are chosen by: the cheapest setting within 10 % of the error floor.

use crate::point::Point;

/// Largest error that counts as on the floor, over the floor.
pub(crate) const FLOOR: f64 = 1.1;

/// The floor among points of one error: the least error of the candidates, or the uncertainty of what they are compared
/// with if that is larger.
pub(crate) fn floor(points: &[&Point]) -> Option<f64> {
    let least = points.iter().filter(|p| p.candidate && p.is_finite()).map(|p| p.error).min_by(f64::total_cmp)?;
    Some(points.iter().map(|p| p.uncertainty).fold(least, f64::max))
}

/// The cheapest candidate on the floor, among points of one error.
pub(crate) fn choice<'a>(points: &[&'a Point]) -> Option<&'a Point> {
    let floor = floor(points)?;
    let on_floor = points.iter().filter(|p| p.candidate && p.is_finite() && p.error <= FLOOR * floor);
    on_floor.min_by(|a, b| a.ms.total_cmp(&b.ms)).copied()
}
