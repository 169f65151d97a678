//! Stage `viscosity`: neighbours share velocity (XSPH, eqs. 7, 8).

use glam::DVec3;

use crate::{Parameters, State, neighbours::Neighbours, sph_kernels::poly6, step::Scratch};

/// Runs the stage: neighbours exchange velocity, unless nothing is viscous.
pub fn run(s: &State, w: &mut Scratch, p: &Parameters) {
    if p.air && (p.viscosity_hair > 0.0 || p.viscosity_air > 0.0 || p.viscosity_eddies > 0.0) {
        let (x, v) = (&w.predicted, &w.new_velocity);
        w.eddies.resize(x.len(), 0.0);
        w.exchange = limit(p, x, &s.volume, &w.near, &w.density, &w.eddies);
        w.new_velocity = xsph(p, x, v, &s.inverse_mass, &s.volume, &w.near, &w.density, &w.eddies, &w.exchange);
    }
}

/// Weight of a pair w_ij = 2 √(V_i V_j) W/(θ_i + θ_j), symmetric; θ = ρ/ρ0.
fn weight(p: &Parameters, i: usize, j: usize, x: &[DVec3], volume: &[f64], theta: &[f64]) -> f64 {
    let r = p.separation(i, j, x[i], x[j]).length();
    2.0 * (volume[i] * volume[j]).sqrt() * poly6(r, p.kernel_radius) / (theta[i] + theta[j])
}

/// Part S_i = Σ_j c_ij w_ij of its velocity that a particle would exchange; 0 without the limiter.
#[must_use]
pub fn limit(
    p: &Parameters,
    x: &[DVec3],
    volume: &[f64],
    near: &Neighbours,
    theta: &[f64],
    eddies: &[f64],
) -> Vec<f64> {
    if !p.limited {
        return vec![0.0; x.len()];
    }
    let sum = |i: usize| {
        near.of(i)
            .filter(|&j| p.shares(i, j))
            .map(|j| p.viscosity(i, j, eddies) * weight(p, i, j, x, volume, theta))
            .sum()
    };
    (0..x.len()).map(sum).collect()
}

/// Velocities after XSPH, as equal and opposite impulses (Schechter & Bridson 2012; eqs. 7, 8):
/// v_i += Σ_j 2 w_i/(w_i + w_j) c_ij w_ij (v_j − v_i)/max(1, S_i, S_j) \[m/s\].
#[must_use]
pub fn xsph(
    p: &Parameters,
    x: &[DVec3],
    v: &[DVec3],
    inverse_mass: &[f64],
    volume: &[f64],
    near: &Neighbours,
    theta: &[f64],
    eddies: &[f64],
    exchange: &[f64],
) -> Vec<DVec3> {
    let pair = |i: usize, j: usize| {
        let both = inverse_mass[i] + inverse_mass[j];
        if both == 0.0 {
            return DVec3::ZERO;
        }
        let share =
            p.viscosity(i, j, eddies) * weight(p, i, j, x, volume, theta) / exchange[i].max(exchange[j]).max(1.0);
        2.0 * inverse_mass[i] / both * share * (v[j] - v[i])
    };
    let sum = |i: usize| near.of(i).filter(|&j| p.shares(i, j)).map(|j| pair(i, j)).sum::<DVec3>();
    (0..x.len()).map(|i| v[i] + sum(i)).collect()
}
