//! The rule that defaults are chosen by: the cheapest setting within 10 % of the error floor.

use windswept_validate::{Role, Row, Sweep};

/// Largest error that counts as on the floor, over the floor.
pub(crate) const FLOOR: f64 = 1.1;

/// Candidates that have an error.
fn candidates(sweep: &Sweep) -> impl Iterator<Item = &Row> {
    sweep.rows.iter().filter(|row| row.role != Role::Aside && row.measured.is_finite() && row.measured > 0.0)
}

/// The floor of an error: the least of the candidates, or the uncertainty of the expected value if that is larger.
pub(crate) fn floor(sweep: &Sweep) -> Option<f64> {
    let least = candidates(sweep).map(|row| row.measured).min_by(f64::total_cmp)?;
    Some(sweep.rows.iter().map(|row| row.tolerance).fold(least, f64::max))
}

/// The setting that the rule chooses: the cheapest candidate on the floor; where a single setting is on it, and the
/// truth would tell a better one, there is no floor, and the rule chooses the knee, after which twice the time buys
/// less than a halving of the error: the setting of the least error times time.
pub(crate) fn choice(sweep: &Sweep) -> Option<&Row> {
    let floor = floor(sweep)?;
    let on_floor: Vec<&Row> = candidates(sweep).filter(|row| row.measured <= FLOOR * floor).collect();
    if on_floor.len() > 1 || sweep.rows.iter().any(|row| row.tolerance >= floor) {
        on_floor.into_iter().min_by(|a, b| a.at.total_cmp(&b.at))
    } else {
        candidates(sweep).min_by(|a, b| (a.measured * a.at).total_cmp(&(b.measured * b.at)))
    }
}
