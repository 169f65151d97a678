//! Stage `fluid`: air is not compressed, by pressure (solver `divergence`) or, as hair on hair, by a constraint on its
//! density (Macklin & Müller 2013). A particle has a volume and, apart from it, an inertial mass.

mod coarse;
mod friction;
mod pressure;
mod wall;

use glam::DVec3;
use windswept_scene::{FluidSolver, Model};

pub use self::{
    coarse::{
        Solid, coarse_deposit, coarse_gather, coarse_impulse, coarse_mean, coarse_push, coarse_solid, coarse_solve,
        coarse_waves, source,
    },
    friction::{FrictionPoint, STIFFNESS, friction, normal_impulse, slip},
    pressure::{
        LASTING, Moments, Pressed, THIN, begin, deform, divergence, eddies, give_bodies, moments, path, push, relax,
        relaxations, spread, start,
    },
    wall::{CLEARANCE, Wall, density_beyond, gradient_beyond, has_walls, solid, wall, walls},
};
use crate::{
    Parameters, State,
    neighbours::Neighbours,
    sph_kernels::{poly6, spiky_gradient},
    step::{Observer, Scratch},
};

/// C of air above which only the share `ABRUPT`/C of a move by the density constraint becomes velocity.
pub const ABRUPT: f64 = 0.2;

/// Runs the stage: the pressure of solver `divergence`, of air or of hair and air; and density constraints (eq. 1) of
/// the particles that it leaves out. Where no constraint is solved the density is found all the same, for viscosity.
pub fn run(s: &State, w: &mut Scratch, p: &Parameters, see: &mut Observer<'_>) {
    w.correction = vec![DVec3::ZERO; w.predicted.len()];
    w.tangential_spring.clone_from(&s.tangential_spring);
    w.pressed.clone_from(&s.pressed);
    if !p.air {
        return;
    }
    let constrained = match (p.fluid.solver, p.interaction.model) {
        (FluidSolver::Pbf, _) => w.predicted.len(),
        (FluidSolver::Divergence, Model::TwoWay) => p.hair_points,
        (FluidSolver::Divergence, _) => 0,
    };
    w.density = vec![0.0; w.predicted.len()];
    let multiplier = constrain(s, w, p, constrained, see);
    if p.has_friction() {
        let slipping = |i: usize| slip(p, s, i, w.correction[i], multiplier[i]);
        w.friction_points = (0..p.hair_points).map(slipping).collect();
        see("fluid/slip", s, w);
        let (x, points) = (&w.predicted, &w.friction_points);
        w.normal_impulses = normal_impulse(p, x, &s.inverse_mass, &s.volume, points, &w.near);
        let change;
        (change, w.tangential_spring) =
            friction(p, x, &s.tangential_spring, &s.inverse_mass, &s.volume, points, &w.normal_impulses, &w.near);
        w.shift = change.into_iter().map(|change| p.step * change).collect();
        see("fluid/friction", s, w);
        for (i, shift) in w.shift.iter().enumerate() {
            w.predicted[i] += *shift;
            w.correction[i] += *shift;
        }
        see("fluid/move", s, w);
    }
    match p.fluid.solver {
        FluidSolver::Pbf => {
            for i in p.hair_points..w.predicted.len() {
                w.new_velocity[i] = velocity(p, w.new_velocity[i], w.correction[i]);
                w.correction[i] = DVec3::ZERO;
            }
            see("fluid/velocity", s, w);
        }
        FluidSolver::Divergence => pressure::run(s, w, p, constrained, see),
    }
}

/// Solves the density constraint of the first `count` particles. Returns the sum of each hair point's multipliers times
/// the relaxation \[kg m²\].
fn constrain(s: &State, w: &mut Scratch, p: &Parameters, count: usize, see: &mut Observer<'_>) -> Vec<f64> {
    let mut multiplier = vec![0.0; p.hair_points];
    for iteration in 0..p.fluid.iterations.max(1) {
        let x = &w.predicted[..count];
        let density;
        (density, w.multiplier) = self::density(p, x, &s.inverse_mass, &s.volume, &w.near);
        w.density[..count].copy_from_slice(&density);
        w.felt = felt(p, &density, &w.multiplier);
        see("fluid/density", s, w);
        if iteration < p.fluid.iterations {
            let x = &w.predicted[..count];
            w.shift = correct(p, x, &s.inverse_mass, &s.volume, &w.near, &w.multiplier);
            w.velocity_shift = correct(p, x, &s.inverse_mass, &s.volume, &w.near, &w.felt);
            see("fluid/correct", s, w);
            for (i, (shift, felt)) in w.shift.iter().zip(&w.velocity_shift).enumerate() {
                w.predicted[i] += *shift;
                w.correction[i] += *felt;
            }
            see("fluid/move", s, w);
            multiplier.iter_mut().zip(&w.multiplier).for_each(|(sum, lambda)| *sum += p.fluid.relaxation * lambda);
        }
    }
    multiplier
}

/// Density ρ_i/ρ0 = Σ_j V_j W, self included, and its multiplier λ_i = −C_i/(Σ_k w_k |∇_k C_i|² + α) \[kg m²\].
///
/// C = ρ/ρ0 − 1; negative C counts as 0. `volume` in m³, `inverse_mass` in 1/kg.
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
        let constraint = error.max(0.0);
        let sum = inverse_mass[i] * own.length_squared() + others;
        (ratio, -constraint / (sum + p.density_softening))
    };
    (0..x.len()).map(each).unzip()
}

/// The part of each multiplier that becomes velocity \[kg m²\]: all of a hair point's, and of air's what C up to
/// [`ABRUPT`] gives.
#[must_use]
pub fn felt(p: &Parameters, density: &[f64], lambda: &[f64]) -> Vec<f64> {
    let part = |(i, (density, lambda)): (usize, (&f64, &f64))| {
        let error = density - 1.0;
        if i >= p.hair_points && error > ABRUPT { lambda * ABRUPT / error } else { *lambda }
    };
    density.iter().zip(lambda).enumerate().map(part).collect()
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
        p.fluid.relaxation * inverse_mass[i] * near.of(i).filter(|&j| p.meets(i, j)).map(|j| pair(i, j)).sum::<DVec3>()
    };
    (0..x.len()).map(shift).collect()
}

/// Velocity of air: its own, and what the density constraint moved it by over Δt \[m/s\].
#[must_use]
pub fn velocity(p: &Parameters, own: DVec3, correction: DVec3) -> DVec3 {
    own + correction / p.step
}
