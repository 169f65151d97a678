//! Heading 3: hair and air as one position-based fluid (Macklin & Müller 2013), where a particle has a volume and, apart
//! from it, an inertial mass.

use glam::DVec3;
use windswept_scene::Model;

use crate::{
    Parameters, State,
    neighbours::Neighbours,
    sph_kernels::{poly6, spiky_gradient},
    step::Scratch,
};

/// Runs the heading: density constraints (eq. 1) of hair and air together, or of each for itself. Where none is solved the
/// density is found all the same, for viscosity.
pub fn run(s: &State, w: &mut Scratch, p: &Parameters) {
    w.correction = vec![DVec3::ZERO; w.predicted.len()];
    if !p.air {
        return;
    }
    let mut multiplier = vec![0.0; p.hair_points];
    for iteration in 0..p.fluid_iterations.max(1) {
        let lambda;
        (w.density, lambda) = density(p, &w.predicted, &s.inverse_mass, &s.volume, &w.near);
        if iteration < p.fluid_iterations {
            let shift = correct(p, &w.predicted, &s.inverse_mass, &s.volume, &w.near, &lambda);
            for (i, shift) in shift.into_iter().enumerate() {
                w.predicted[i] += shift;
                w.correction[i] += shift;
            }
            multiplier.iter_mut().zip(&lambda).for_each(|(sum, lambda)| *sum += p.relaxation * lambda);
        }
    }
    if p.model == Model::TwoWay && p.friction > 0.0 {
        // Velocities that lead the step hold all that acted on a point in the last step but impulses, its rod as well.
        let led: Vec<_> = s.velocity.iter().zip(&s.velocity_before).map(|(now, before)| 2.0 * *now - *before).collect();
        let change = friction(p, &w.predicted, &led, &s.inverse_mass, &s.volume, &multiplier, &w.near);
        for (i, change) in change.into_iter().enumerate() {
            w.predicted[i] += p.step * change;
            w.correction[i] += p.step * change;
        }
    }
    if p.model == Model::TwoWay {
        // Air that hair is to feel has been through the density constraint; nothing is left for heading 6 to add.
        for i in p.hair_points..w.predicted.len() {
            w.new_velocity[i] = velocity(p, w.new_velocity[i], w.correction[i]);
            w.correction[i] = DVec3::ZERO;
        }
    }
}

/// Density ρ_i/ρ0 = Σ_j V_j W, self included, and its multiplier λ_i = −C_i/(Σ_k w_k |∇_k C_i|² + α) \[kg m²\].
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

/// Shift Δx_i = relaxation w_i Σ_j (λ_i V_j + λ_j V_i) ∇_i W \[m\]: equal and opposite in m Δx for a pair.
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
    let shift = |i: usize| {
        p.relaxation * inverse_mass[i] * near.of(i).filter(|&j| p.meets(i, j)).map(|j| pair(i, j)).sum::<DVec3>()
    };
    (0..x.len()).map(shift).collect()
}

/// Velocity of air: its own, and what the density constraint moved it by over Δt \[m/s\].
#[must_use]
pub fn velocity(p: &Parameters, own: DVec3, correction: DVec3) -> DVec3 {
    own + correction / p.step
}

/// Change of the velocity of each hair point by friction of hair on hair \[m/s\]: equal and opposite impulses between points of
/// different strands, across the line that joins them,
///
/// ```text
///   J_ij = −min(μ p_ij, m_ij s_ij |u|) u/|u|      u: what of v_i − v_j is normal to x_i − x_j, m_ij = 1/(w_i + w_j)
///   p_ij = |(Λ_i V_j + Λ_j V_i) ∇W|/Δt            the impulse that the density constraint gave the pair (Coulomb's cap)
///   s_ij = W_ij/max(S_i, S_j),  S_i = Σ_j W_ij    its share: all of them together stop a point, and no more
/// ```
/// `v` are velocities that lead the step; `multiplier` Λ is the sum of λ times the relaxation over the iterations
/// \[kg m²\]. Macklin et al. 2014, eq. 24, with the constraint's own impulse for the depth.
#[must_use]
pub fn friction(
    p: &Parameters,
    x: &[DVec3],
    v: &[DVec3],
    inverse_mass: &[f64],
    volume: &[f64],
    multiplier: &[f64],
    near: &Neighbours,
) -> Vec<DVec3> {
    let h = p.kernel_radius;
    let others = |i: usize| near.of(i).filter(move |&j| !p.is_air(j) && p.strand_of[i] != p.strand_of[j]);
    let kernel = |i: usize, j: usize| poly6((x[i] - x[j]).length(), h);
    let sums: Vec<f64> = (0..p.hair_points).map(|i| others(i).map(|j| kernel(i, j)).sum()).collect();
    let pair = |i: usize, j: usize| {
        let gap = x[i] - x[j];
        let slip = (v[i] - v[j]).reject_from(gap);
        let (both, speed) = (inverse_mass[i] + inverse_mass[j], slip.length());
        if both == 0.0 || speed == 0.0 || gap == DVec3::ZERO {
            return DVec3::ZERO;
        }
        let squeeze = (multiplier[i] * volume[j] + multiplier[j] * volume[i]) * spiky_gradient(i, j, gap, h);
        let needed = kernel(i, j) / sums[i].max(sums[j]) / both * speed;
        -needed.min(p.friction * squeeze.length() / p.step) / speed * slip
    };
    (0..p.hair_points).map(|i| inverse_mass[i] * others(i).map(|j| pair(i, j)).sum::<DVec3>()).collect()
}
