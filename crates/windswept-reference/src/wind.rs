//! The wind enters (design 3.2).

use std::f64::consts::PI;

use glam::DVec3;

use crate::Parameters;

/// Part of the wind that has risen after `steps` steps.
#[must_use]
pub fn risen(p: &Parameters, steps: u64) -> f64 {
    if p.ramp > 0.0 { (steps as f64 * p.step / p.ramp).min(1.0) } else { 1.0 }
}

/// What the wind adds to air at `position` that moves with `velocity` in step number `steps` \[m/s\].
///
/// The mean wind's change, then v += (1 − e^{−σΔt})(U − v), σ = 10 max(|U|, 0.3 m/s)/ℓ sin²(π x/ℓ) within the thickness
/// ℓ of the face that U enters through; several faces count with the cosines of U.
#[must_use]
pub fn fringe(p: &Parameters, steps: u64, position: DVec3, velocity: DVec3) -> DVec3 {
    if p.wind == DVec3::ZERO {
        return DVec3::ZERO;
    }
    let wind = p.wind * risen(p, steps + 1);
    let change = wind - p.wind * risen(p, steps);
    let mut sigma = 0.0;
    for axis in 0..3 {
        let depth = if wind[axis] >= 0.0 { position[axis] } else { p.box_size[axis] - position[axis] };
        if depth < p.fringe {
            let cosine = wind[axis].abs() / wind.length();
            sigma += cosine * 10.0 * wind.length().max(0.3) / p.fringe * (PI * depth / p.fringe).sin().powi(2);
        }
    }
    change + (1.0 - (-sigma * p.step).exp()) * (wind - (velocity + change))
}
