//! Hair and air as one position-based fluid (Macklin & Müller 2013), with volumes and two masses (design 3.1, 3.5).

use glam::DVec3;

use crate::{
    Parameters,
    grid::Neighbours,
    sph_kernels::{poly6, spiky_gradient},
};

/// x* = wrap(x + Δt v) \[m\]: air leaves the box through one face and enters through the other.
#[must_use]
pub fn predict(p: &Parameters, position: DVec3, velocity: DVec3) -> DVec3 {
    wrap(p, position + p.step * velocity)
}

/// Into \[0, box).
#[must_use]
pub fn wrap(p: &Parameters, position: DVec3) -> DVec3 {
    position - p.box_size * (position / p.box_size).floor()
}

/// ρ_i/ρ0 = Σ_j V_j W, self included, and λ_i = −C_i/(Σ_k w_k |∇_k C_i|² + α) \[kg m²\].
///
/// C = ρ/ρ0 − 1; negative C counts with `tension`. `volume` in m³, `inverse_mass` in 1/kg.
#[must_use]
pub fn density(
    p: &Parameters,
    x: &[DVec3],
    inverse_mass: &[f64],
    volume: &[f64],
    near: &Neighbours,
) -> (Vec<f64>, Vec<f64>) {
    let h = p.kernel_radius;
    let each = |i: usize| {
        let mut ratio = volume[i] * poly6(0.0, h);
        let mut own = DVec3::ZERO;
        let mut others = 0.0;
        for j in near.of(i).filter(|&j| p.meets(i, j)) {
            let gap = p.separation(i, j, x[i], x[j]);
            let gradient = volume[j] * spiky_gradient(i, j, gap, h);
            ratio += volume[j] * poly6(gap.length(), h);
            own += gradient;
            others += inverse_mass[j] * gradient.length_squared();
        }
        let error = ratio - 1.0;
        let constraint = error.max(0.0) + p.tension * error.min(0.0);
        let sum = inverse_mass[i] * own.length_squared() + others;
        (ratio, -constraint / (sum + p.density_softening))
    };
    (0..x.len()).map(each).unzip()
}

/// Δx_i = relaxation w_i Σ_j (λ_i V_j + λ_j V_i) ∇_i W \[m\]: equal and opposite in m Δx for a pair.
#[must_use]
pub fn correct(
    p: &Parameters,
    x: &[DVec3],
    inverse_mass: &[f64],
    volume: &[f64],
    near: &Neighbours,
    lambda: &[f64],
) -> Vec<DVec3> {
    let pair = |i: usize, j: usize| {
        let gap = p.separation(i, j, x[i], x[j]);
        (lambda[i] * volume[j] + lambda[j] * volume[i]) * spiky_gradient(i, j, gap, p.kernel_radius)
    };
    let shift = |i: usize| p.relaxation * inverse_mass[i] * near.of(i).filter(|&j| p.meets(i, j)).map(|j| pair(i, j)).sum::<DVec3>();
    (0..x.len()).map(shift).collect()
}

/// Of air: its own velocity and what the density constraint moved it by \[m/s\].
#[must_use]
pub fn velocity(p: &Parameters, own: DVec3, correction: DVec3) -> DVec3 {
    own + correction / p.step
}

/// w_ij = 2 √(V_i V_j) W/(θ_i + θ_j), symmetric; θ = ρ/ρ0.
fn weight(p: &Parameters, i: usize, j: usize, x: &[DVec3], volume: &[f64], theta: &[f64]) -> f64 {
    let r = p.separation(i, j, x[i], x[j]).length();
    2.0 * (volume[i] * volume[j]).sqrt() * poly6(r, p.kernel_radius) / (theta[i] + theta[j])
}

/// S_i = Σ_j c_ij w_ij: how much of its velocity a particle would exchange; 0 without the limiter.
#[must_use]
pub fn limit(p: &Parameters, x: &[DVec3], volume: &[f64], near: &Neighbours, theta: &[f64]) -> Vec<f64> {
    if !p.limited {
        return vec![0.0; x.len()];
    }
    let sum = |i: usize| near.of(i).filter(|&j| p.meets(i, j)).map(|j| p.viscosity(i, j) * weight(p, i, j, x, volume, theta)).sum();
    (0..x.len()).map(sum).collect()
}

/// XSPH as equal and opposite impulses (Schechter & Bridson 2012; eqs. 7, 8):
/// v_i += Σ_j 2 w_i/(w_i + w_j) c_ij w_ij (v_j − v_i)/max(1, S_i, S_j) \[m/s\].
#[must_use]
pub fn viscosity(
    p: &Parameters,
    x: &[DVec3],
    v: &[DVec3],
    inverse_mass: &[f64],
    volume: &[f64],
    near: &Neighbours,
    theta: &[f64],
    exchange: &[f64],
) -> Vec<DVec3> {
    let pair = |i: usize, j: usize| {
        let both = inverse_mass[i] + inverse_mass[j];
        if both == 0.0 {
            return DVec3::ZERO;
        }
        let share = p.viscosity(i, j) * weight(p, i, j, x, volume, theta) / exchange[i].max(exchange[j]).max(1.0);
        2.0 * inverse_mass[i] / both * share * (v[j] - v[i])
    };
    let sum = |i: usize| near.of(i).filter(|&j| p.meets(i, j)).map(|j| pair(i, j)).sum::<DVec3>();
    (0..x.len()).map(|i| v[i] + sum(i)).collect()
}
