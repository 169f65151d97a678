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

/// The setting that the rule chooses, among points of one error: the cheapest candidate on the floor; where a single
/// setting is on it, and the truth would tell a better one, there is no floor, and the knee counts.
pub(crate) fn choice<'a>(points: &[&'a Point]) -> Option<&'a Point> {
    let floor = floor(points)?;
    let candidates = || points.iter().copied().filter(|p| p.candidate && p.is_finite());
    let on_floor: Vec<&Point> = candidates().filter(|p| p.error <= FLOOR * floor).collect();
    let found = on_floor.len() > 1 || points.iter().any(|p| p.uncertainty >= floor);
    if found { on_floor.into_iter().min_by(|a, b| a.ms.total_cmp(&b.ms)) } else { knee(candidates()) }
}

/// The setting after which twice the time buys less than a halving of the error: that of the least error times time.
fn knee<'a>(candidates: impl Iterator<Item = &'a Point>) -> Option<&'a Point> {
    candidates.min_by(|a, b| (a.error * a.ms).total_cmp(&(b.error * b.ms)))
}
