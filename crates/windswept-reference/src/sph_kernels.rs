//! Smoothing kernels (Müller et al. 2003), radius h \[m\].

use std::f64::consts::PI;

use glam::DVec3;

/// Poly6, W(r) = 315/(64 π h⁹) (h² − r²)³ \[1/m³\].
#[must_use]
pub fn poly6(r: f64, h: f64) -> f64 {
    if r >= h { 0.0 } else { 315.0 / (64.0 * PI * h.powi(9)) * (h * h - r * r).powi(3) }
}

/// Spiky's slope, |∇W|(r) = 45/(π h⁶) (h − r)² \[1/m⁴\].
#[must_use]
pub fn spiky_slope(r: f64, h: f64) -> f64 {
    if r >= h { 0.0 } else { 45.0 / (PI * h.powi(6)) * (h - r).powi(2) }
}

/// Distance in units of h below which particles lie on one another.
const COINCIDENT: f64 = 1e-6;

/// Whether particles lie on one another.
#[must_use]
pub fn coincide(gap: DVec3, h: f64) -> bool {
    gap.length() < COINCIDENT * h
}

/// Spiky's gradient ∇_i W for x_i − x_j = `gap`; 0 for coincident particles, which have no direction.
#[must_use]
pub fn gradient(gap: DVec3, h: f64) -> DVec3 {
    if coincide(gap, h) { DVec3::ZERO } else { -spiky_slope(gap.length(), h) * gap.normalize() }
}

/// Spiky's gradient ∇_i W for x_i − x_j = `gap`. Coincident particles take a direction from their indices, opposite for
/// (j, i).
#[must_use]
pub fn spiky_gradient(i: usize, j: usize, gap: DVec3, h: f64) -> DVec3 {
    if coincide(gap, h) { -spiky_slope(gap.length(), h) * coincident_direction(i, j) } else { gradient(gap, h) }
}

/// Unit vector drawn from two indices, antisymmetric: coincident particles must separate.
#[must_use]
pub fn coincident_direction(i: usize, j: usize) -> DVec3 {
    let (low, high) = (i.min(j) as u32, i.max(j) as u32);
    let word = low.wrapping_mul(2_654_435_769) ^ high.wrapping_mul(2_246_822_519);
    let word = (word ^ (word >> 15)).wrapping_mul(3_266_489_917);
    let drawn = |bits: u32| f64::from(bits & 1023) - 511.5;
    let direction = DVec3::new(drawn(word), drawn(word >> 10), drawn(word >> 20)).normalize();
    if i < j { direction } else { -direction }
}
