//! Pressure of solver `divergence`: the velocity of air, and with the model `particles` of hair among it, has no
//! divergence.
//!
//! ```text
//!   s_i  = Σ_j V_j (v_i − v_j) · B_i g_ij                    dθ/dt: where it is positive, air is compressed
//!   Δv_i = w_i Σ_j (λ_i V_j B_i + λ_j V_i B_j) g_ij          its transpose: equal and opposite in m Δv, whatever B is
//!   g_ij = ∇_i W(x_i − x_j) by Spiky, w = m_air/m            V volume [m³], B corrects the gradients of a disordered sum
//! ```
//! Jacobi iterations find λ, which starts from the step before. Air moves by BDF2, whose only history is `change`, the
//! pressure's change of the velocity in the last step, since other forces change v_n and v_{n−1} alike.

use glam::{DMat3, DVec3};
use windswept_scene::Model;

use super::{
    Wall, coarse_deposit, coarse_gather, coarse_impulse, coarse_mean, coarse_push, coarse_solid, coarse_solve,
    density_beyond, gradient_beyond, has_walls, walls,
};
use crate::{
    Parameters, State, contact,
    neighbours::{self, Neighbours},
    sph_kernels::{self, poly6, spiky_gradient},
    step::{Observer, Scratch, unobserved},
};

/// Most of the way U Δt/d in a step by which particles are spread: with 0.1 strong eddies crowd air more and more.
const MAX_BY_WAY: f64 = 0.065;
/// Most of the deformation |G| Δt of the flow in a step by which particles are spread in a scene without wind, where
/// air that whirls would clump. Where wind blows it would move them across the shear behind hair.
const BY_DEFORMATION: f64 = 0.05;
/// Way \[particle spacings\] or deformation in 1.38 ms below which air is still; from twice that on it is not.
const STILL: f64 = 1e-3;
/// Most that unresolved eddies add to the XSPH coefficient c.
const MAX_EDDIES: f64 = 0.25;
/// Largest spread in units of h² s_i.
const MAX_SPREAD: f64 = 0.1;
/// Longest move of a particle by the spread \[particle spacings\].
const LONGEST_SPREAD: f64 = 0.25;
/// Softening of M, which is about 1 where particles are.
const SOFTENING: f64 = 0.02;
/// Least determinant of M, and largest trace of B, with which gradients are corrected.
const MIN_DETERMINANT: f64 = 0.15;
const LARGEST_TRACE: f64 = 6.0;
/// Density ρ/ρ0 below which a particle is at a surface: there pressure pushes and does not pull.
pub const THIN: f64 = 0.6;
/// Largest eigenvalue of a⁻¹ D Dᵀ that the relaxations bear: measured up to 4.32, on a lattice.
const LARGEST: f64 = 4.5;
/// Least share of the spread beside bodies, of the way in a step there.
const BESIDE: f64 = 0.12;
/// Part of a density error that flows out beside bodies in a step in which air goes a spacing.
const FED_BACK: f64 = 0.3;
/// Rounds of the pressure before the first step.
const START: u32 = 8;
/// Density over that at rest beyond which a crowd takes less of a divergence, inverted.
const CROWD: f64 = 0.8;
/// Impulse of a push over time: BDF2 hands on a third of each change, and 1 + 1/3 + 1/9 + … = 3/2.
pub const LASTING: f64 = 1.5;

/// Memory of pressure that a particle has for the next step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Pressed {
    /// Change of the particle's velocity by pressure in the last step \[m/s\].
    pub change: DVec3,
    /// Multiplier λ \[m²/s\]: pressure over density, times the step; λ < 0 where pressure pushes.
    pub pressure: f64,
}

/// Surroundings of a particle.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Moments {
    /// Density θ = ρ/ρ0.
    pub density: f64,
    /// Matrix B, which corrects gradients.
    pub correction: DMat3,
    /// Diagonal a of the divergence of a push \[1/m²\].
    pub diagonal: f64,
    /// The wall's part k n of corrected gradients \[1/m\]; 0 where there is none.
    pub wall: DVec3,
    /// The wall's own part of the divergence: k times the velocity of the surface along n \[1/s\].
    pub wall_rate: f64,
    /// The rate at which a density error beside a body is to flow out \[1/s\].
    pub fed_back: f64,
}

/// Projects the velocities of air onto those without divergence, with the model `particles` those of hair as well: it
/// gets the impulse that pressure has over time.
///
/// The density of the first `constrained` particles is that of their constraint.
pub(super) fn run(s: &State, w: &mut Scratch, p: &Parameters, constrained: usize, see: &mut Observer<'_>) {
    let (mass, volume) = (&s.inverse_mass, &s.volume);
    w.deformation = deform(p, &w.predicted, &w.new_velocity, volume, &w.near);
    w.eddies = w.deformation.iter().map(|deformation| eddies(p, *deformation)).collect();
    w.shift = spread(p, &w.predicted, &w.new_velocity, volume, &w.near, &w.deformation, &w.walls);
    see("fluid/spread", s, w);
    // The coarse grid takes particles where they were: the move by the spread is small beside the distance of nodes.
    w.sorted_position.clone_from(&w.predicted);
    w.predicted.iter_mut().zip(&w.shift).for_each(|(x, shift)| *x += *shift);
    walls(w, p);
    see("fluid/place", s, w);
    w.moments = moments(p, &w.predicted, mass, volume, &w.near, &w.walls);
    let solved = w.density.iter_mut().zip(&w.moments).skip(constrained);
    solved.for_each(|(density, moments)| *density = moments.density);
    see("fluid/moments", s, w);
    w.pressed = (0..w.predicted.len()).map(|i| start(p, i, &w.moments[i], &s.pressed[i])).collect();
    let lambda: Vec<f64> = w.pressed.iter().map(|pressed| pressed.pressure).collect();
    give(w, push(p, &w.predicted, mass, volume, &w.near, &w.moments, &lambda));
    give_bodies(w, &lambda);
    see("fluid/push", s, w);
    solve(s, w, p, see);
    path(s, w, p);
    see("fluid/path", s, w);
    if p.interaction.model == Model::Particles {
        for i in 0..p.hair_points {
            w.correction[i] = LASTING * p.step * w.pressed[i].change;
        }
        see("fluid/impulse", s, w);
    }
}

/// Takes the divergence out, on a coarse grid, which sees particles where they were sorted, and then by iterations.
fn solve(s: &State, w: &mut Scratch, p: &Parameters, see: &mut Observer<'_>) {
    let (mass, volume) = (&s.inverse_mass, &s.volume);
    if p.coarse {
        w.divergence = divergence(p, &w.predicted, &w.new_velocity, volume, &w.near, &w.moments);
        see("fluid/divergence", s, w);
        w.coarse_divergence = coarse_deposit(p, &w.sorted_position, &w.new_velocity, &w.divergence, &w.moments);
        w.coarse = coarse_solve(p, &w.coarse_divergence);
        w.coarse_change = coarse_gather(p, &w.sorted_position, &w.coarse);
        see("fluid/coarse_gather", s, w);
        w.solids = coarse_solid(p, &w.moving.bodies, &w.coarse);
        let (mean, part) = coarse_mean(p, &w.new_velocity, &w.coarse_change, &w.solids);
        see("reduce/total", s, w);
        see("fluid/coarse_solid", s, w);
        give(w, coarse_push(p, &w.coarse_change, mean, part));
        w.coarse_impulse = coarse_impulse(&w.solids, mean, part);
        see("fluid/coarse_push", s, w);
    }
    for omega in relaxations(p.fluid.pressure_iterations) {
        w.divergence = divergence(p, &w.predicted, &w.new_velocity, volume, &w.near, &w.moments);
        let mu: Vec<f64> = (0..w.divergence.len())
            .map(|i| relax(omega, p.part(volume[i]), w.divergence[i], &w.moments[i], w.pressed[i].pressure))
            .collect();
        w.pressed.iter_mut().zip(&mu).for_each(|(pressed, mu)| pressed.pressure += mu);
        see("fluid/divergence", s, w);
        give(w, push(p, &w.predicted, mass, volume, &w.near, &w.moments, &mu));
        give_bodies(w, &mu);
        see("fluid/push", s, w);
    }
}

/// Adds the impulses of multipliers `lambda` on bodies \[m/s\]: a body gets the impulse of its wall on a particle, and
/// the impulses that BDF2 makes of it in the steps after.
pub fn give_bodies(w: &mut Scratch, lambda: &[f64]) {
    for ((wall, moments), lambda) in w.walls.iter_mut().zip(&w.moments).zip(lambda) {
        wall.impulse += LASTING * lambda * moments.wall;
    }
}

/// Moves air by what pressure changed differently from the step before, for half a step: x += ½ Δt (a − a_before). In a
/// scene with bodies air goes by the mean of its velocities before and after a step.
pub fn path(s: &State, w: &mut Scratch, p: &Parameters) {
    if has_walls(p) {
        for i in p.hair_points..w.predicted.len() {
            w.predicted[i] += 0.5 * p.step * (w.pressed[i].change - s.pressed[i].change);
        }
    }
}

/// Gives air beside bodies the velocity that it starts with, before the first step: without divergence, and along the
/// bodies. No time passes.
pub fn begin(s: &mut State, p: &Parameters) {
    if !has_walls(p) {
        return;
    }
    let mut w = Scratch { predicted: s.position.clone(), new_velocity: s.velocity.clone(), ..Scratch::default() };
    w.moving.bodies = contact::place(p, s.steps);
    walls(&mut w, p);
    neighbours::run(&mut w, p);
    w.moments = moments(p, &w.predicted, &s.inverse_mass, &s.volume, &w.near, &w.walls);
    w.pressed = vec![Pressed::default(); w.predicted.len()];
    w.sorted_position.clone_from(&w.predicted);
    for _ in 0..START {
        solve(s, &mut w, p, &mut unobserved);
    }
    s.velocity[p.hair_points..].copy_from_slice(&w.new_velocity[p.hair_points..]);
}

/// Adds changes to the velocities, and to what pressure is remembered by.
fn give(w: &mut Scratch, changes: Vec<DVec3>) {
    for (i, change) in changes.into_iter().enumerate() {
        w.new_velocity[i] += change;
        w.pressed[i].change += change;
    }
}

/// Particles that share pressure with particle `i`: hair does with the model `particles` only.
fn others<'a>(p: &'a Parameters, near: &'a Neighbours, i: usize) -> impl Iterator<Item = usize> + 'a {
    near.of(i).filter(move |&j| p.interaction.model == Model::Particles || p.is_air(i) && p.is_air(j))
}

/// Gradient g_ij = ∇_i W \[1/m⁴\]; 0 for particles that lie on one another.
fn gradient(p: &Parameters, i: usize, j: usize, x: &[DVec3]) -> DVec3 {
    sph_kernels::gradient(p.separation(i, j, x[i], x[j]), p.kernel_radius)
}

/// Moves δ of air that keep particles apart, and that velocity never sees \[m\]; 0 for hair.
///
/// δ_i = −h² a Σ_j V_j g_ij, |δ_i| ≤ d/4, a particle shift by the concentration gradient as that of Lind et al. (2012).
/// The factor a is at most 0.1, and the largest of
///
/// * min(0.065, f U Δt/d), f the scene's share, U its largest wind or the particle's own speed where that is more;
/// * without wind min(0.05, |G_i| Δt), G the `deformation` of [`deform`];
/// * without wind, but not with the model `particles`, the unevenness h |Σ_j V_j g_ij| min(1, 725 Δt/s): crowded air that
///   is still would stay crowded;
/// * beside bodies 0.12 of the way in a step; bodies also add −P n to the sum.
///
/// It goes with Δt, so that its diffusion |δ|²/2Δt vanishes with the step. A particle that lies on others leaves the
/// last of them in a random direction.
#[must_use]
pub fn spread(
    p: &Parameters,
    x: &[DVec3],
    v: &[DVec3],
    volume: &[f64],
    near: &Neighbours,
    deformation: &[f64],
    walls: &[Wall],
) -> Vec<DVec3> {
    let spacing = p.spacing();
    let each = |i: usize| {
        if !p.is_air(i) {
            return DVec3::ZERO;
        }
        let pairs = || others(p, near, i).map(|j| (j, volume[j] * gradient(p, i, j, x)));
        let met = others(p, near, i)
            .filter(|&j| sph_kernels::coincide(p.separation(i, j, x[i], x[j]), p.kernel_radius))
            .max();
        let away = met.map_or(DVec3::ZERO, |j| volume[j] * spiky_gradient(i, j, DVec3::ZERO, p.kernel_radius));
        let mut uneven: DVec3 = away + pairs().map(|(_, gradient)| gradient).sum::<DVec3>();
        if let Some(wall) = walls.get(i) {
            uneven -= gradient_beyond(p, wall.distance) * wall.normal;
        }
        let mut part = (p.spreading * p.largest_wind.max(v[i].length()) * p.step / spacing).min(MAX_BY_WAY);
        if p.largest_wind == 0.0 {
            let deformed = deformation[i];
            let motion = deformed.max(p.step * v[i].length() / spacing);
            let settles = (2.0 * p.settling - motion / STILL).clamp(0.0, p.settling);
            part = part.max(deformed.min(BY_DEFORMATION)).max(settles * p.kernel_radius * uneven.length());
        }
        if let Some(wall) = walls.get(i) {
            part = part.max(BESIDE * wall.way);
        }
        let part = part.min(MAX_SPREAD);
        (-p.kernel_radius.powi(2) * part * uneven).clamp_length_max(LONGEST_SPREAD * spacing)
    };
    (0..x.len()).map(each).collect()
}

/// Deformation |G_i| Δt of the flow in a step, G_i = Σ_j V_j (v_j − v_i) ⊗ g_ij, Frobenius's norm; 0 for hair.
#[must_use]
pub fn deform(p: &Parameters, x: &[DVec3], v: &[DVec3], volume: &[f64], near: &Neighbours) -> Vec<f64> {
    let each = |i: usize| {
        let gradients = others(p, near, i).map(|j| outer(v[j] - v[i], volume[j] * gradient(p, i, j, x)));
        p.step * gradients.sum::<DMat3>().to_cols_array().iter().map(|x| x * x).sum::<f64>().sqrt()
    };
    (0..x.len()).map(|i| if p.is_air(i) { each(i) } else { 0.0 }).collect()
}

/// XSPH coefficient c = 22 (C d/h)² |G_i| Δt of eddies smaller than the spacing d, ν = (C d)² |G_i| (Smagorinsky 1963),
/// at most 0.25, from a deformation |G_i| Δt.
#[must_use]
pub fn eddies(p: &Parameters, deformation: f64) -> f64 {
    (p.viscosity_eddies * deformation).min(MAX_EDDIES)
}

/// Matrix a bᵀ.
fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// Surroundings of every particle: density θ_i = Σ_j V_j W by Poly6, itself included; B_i = M_i⁻¹ with
/// M_i = −sym Σ_j V_j g_ij ⊗ (x_i − x_j) + 0.02, or 1 where M is nearly singular; and
/// a_i = w_i |Σ_j V_j B_i g_ij|² + Σ_j w_j V_j² |B_i g_ij|² + α, α the softening of the density constraint.
///
/// A wall adds Ψ to θ, 2 P φ n nᵀ to M, and −k n to the first sum of a, with k = 2 P n · B n: the factor is that of the
/// mirror image.
#[must_use]
pub fn moments(
    p: &Parameters,
    x: &[DVec3],
    inverse_mass: &[f64],
    volume: &[f64],
    near: &Neighbours,
    walls: &[Wall],
) -> Vec<Moments> {
    let h = p.kernel_radius;
    let each = |i: usize| {
        let mut density = volume[i] * poly6(0.0, h);
        let mut moment = DMat3::ZERO;
        for j in others(p, near, i) {
            let gap = p.separation(i, j, x[i], x[j]);
            density += volume[j] * poly6(gap.length(), h);
            moment -= volume[j] * outer(gap, gradient(p, i, j, x));
        }
        let beyond = walls.get(i).map(|wall| (wall, gradient_beyond(p, wall.distance)));
        if let Some((wall, beyond)) = beyond {
            density += density_beyond(p, wall.distance);
            moment += 2.0 * beyond * wall.distance.max(0.0) * outer(wall.normal, wall.normal);
        }
        let correction = inverse(0.5 * (moment + moment.transpose()) + DMat3::from_diagonal(DVec3::splat(SOFTENING)));
        let (mut own, mut sum) = (DVec3::ZERO, 0.0);
        for j in others(p, near, i) {
            let corrected = volume[j] * (correction * gradient(p, i, j, x));
            own += corrected;
            sum += p.weight(inverse_mass[j]) * corrected.length_squared();
        }
        let wall = beyond.map_or(DVec3::ZERO, |(wall, beyond)| {
            2.0 * beyond * wall.normal.dot(correction * wall.normal) * wall.normal
        });
        own -= wall;
        let diagonal = p.weight(inverse_mass[i]) * own.length_squared() + sum + p.weight(p.density_softening);
        let wall_rate = beyond.map_or(0.0, |(seen, _)| wall.dot(seen.velocity));
        let fed_back = beyond.map_or(0.0, |(seen, _)| FED_BACK * seen.way * (density - 1.0) / p.step);
        Moments { density, correction, diagonal, wall, wall_rate, fed_back }
    };
    (0..x.len()).map(each).collect()
}

/// Inverse of M, or 1 where it would be far from it.
fn inverse(moment: DMat3) -> DMat3 {
    if moment.determinant() < MIN_DETERMINANT {
        return DMat3::IDENTITY;
    }
    let inverse = moment.inverse();
    if inverse.x_axis.x + inverse.y_axis.y + inverse.z_axis.z > LARGEST_TRACE { DMat3::IDENTITY } else { inverse }
}

/// Memory of the last step that a particle starts from: λ, and for air a third of the change of its velocity by
/// pressure. At a surface pressure does not pull.
#[must_use]
pub fn start(p: &Parameters, i: usize, moments: &Moments, last: &Pressed) -> Pressed {
    Pressed {
        change: if p.is_air(i) { last.change / 3.0 } else { DVec3::ZERO },
        pressure: if moments.density < THIN { last.pressure.min(0.0) } else { last.pressure },
    }
}

/// Change Δv_i = w_i (Σ_j (λ_i V_j B_i + λ_j V_i B_j) g_ij − λ_i k n) of every particle's velocity by multipliers λ
/// \[m/s\].
#[must_use]
pub fn push(
    p: &Parameters,
    x: &[DVec3],
    inverse_mass: &[f64],
    volume: &[f64],
    near: &Neighbours,
    moments: &[Moments],
    lambda: &[f64],
) -> Vec<DVec3> {
    let pair = |i: usize, j: usize| {
        let (own, other) = (lambda[i] * volume[j], lambda[j] * volume[i]);
        (own * moments[i].correction + other * moments[j].correction) * gradient(p, i, j, x)
    };
    let each = |i: usize| {
        let sum = others(p, near, i).map(|j| pair(i, j)).sum::<DVec3>();
        p.weight(inverse_mass[i]) * (sum - lambda[i] * moments[i].wall)
    };
    (0..x.len()).map(each).collect()
}

/// Rate s_i = Σ_j V_j (v_i − v_j) · B_i g_ij − k (v_i − v_b) · n at which air is compressed at every particle, and
/// beside bodies the rate at which its density error is to flow out \[1/s\].
#[must_use]
pub fn divergence(
    p: &Parameters,
    x: &[DVec3],
    v: &[DVec3],
    volume: &[f64],
    near: &Neighbours,
    moments: &[Moments],
) -> Vec<f64> {
    let pair = |i: usize, j: usize| volume[j] * (v[i] - v[j]).dot(moments[i].correction * gradient(p, i, j, x));
    let each = |i: usize| {
        let sum: f64 = others(p, near, i).map(|j| pair(i, j)).sum();
        sum - (moments[i].wall.dot(v[i]) - moments[i].wall_rate) + moments[i].fed_back
    };
    (0..x.len()).map(each).collect()
}

/// Increment μ = −ω p s/a of a multiplier λ \[m²/s\] of a particle that takes this part p of a divergence; at a surface
/// λ + μ is no more than 0.
#[must_use]
pub fn relax(omega: f64, part: f64, rate: f64, moments: &Moments, lambda: f64) -> f64 {
    let increment = -omega * part * rate / (moments.diagonal * (CROWD * moments.density).max(1.0));
    if moments.density < THIN { increment.min(-lambda) } else { increment }
}

/// Relaxations ω of the iterations. The part of a divergence that they leave, Π (1 − ω μ) with μ an eigenvalue of
/// a⁻¹ D Dᵀ, is between 0 and 1 up to μ = 4.5: λ starts from the step before, and an iteration that overshot would
/// swing from step to step. So roots come in pairs, in the middle of 4.5/4 and 4.5, and an odd one stands at 4.5.
#[must_use]
pub fn relaxations(iterations: u32) -> Vec<f64> {
    let middle = |from: f64, to: f64| 2.0 / (from + to);
    let pairs = |to: f64, count: u32| vec![middle(LARGEST / 4.0, to); count as usize];
    match iterations % 2 {
        0 => pairs(LARGEST, iterations),
        _ => [vec![1.0 / LARGEST], pairs(0.8 * LARGEST, iterations - 1)].concat(),
    }
}
