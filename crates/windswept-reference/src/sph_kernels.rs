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
    let first = pcg((i.min(j) as u32) ^ pcg(i.max(j) as u32));
    let second = pcg(first);
    let unit = |word: u32| f64::from(word) / 4_294_967_296.0;
    let (z, angle) = (2.0 * unit(first) - 1.0, 2.0 * PI * unit(second));
    let ring = (1.0 - z * z).sqrt();
    let direction = DVec3::new(ring * angle.cos(), ring * angle.sin(), z);
    if i < j { direction } else { -direction }
}

/// PCG hash (Jarzynski & Olano 2020).
fn pcg(x: u32) -> u32 {
    let state = x.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}
