//! Coarse solve for the pressure: the long waves that a few iterations do not reach, in one solve on nodes about three
//! spacings apart.
//!
//! ```text
//!   r_n  = Σ_i φ_n(x_i) s_i/max(1, θ_i)                       φ_n: product of a quadratic B-spline along each axis
//!   ĉ(k) = r̂(k)/S(k), ĉ(0) = 0                               S: Σ_i ∇φ_m · ∇φ_n for particles spread evenly
//!   q_i  = −σ Σ_n c_n ∇φ_n(x_i),  v_i += p (q_i − mean of q)  σ = min(1, d/(U Δt))
//! ```
//! The pressure around an obstacle stands still while λ travels with the particles: without the coarse solve it lags.
//! Air is pushed by the gradient of c itself and not by the transpose of the divergence, since among disordered
//! particles that of a constant is not zero: forces of a pair are not opposite here, and the mean is taken out instead.
//! Nor does such a push always take energy from the air, so that only the part p of it is made that does. c is not
//! kept.

use std::f64::consts::TAU;

use glam::DVec3;

use super::{LASTING, Moments, THIN};
use crate::{
    Parameters,
    contact::Placed,
    turbulence::{self, b_spline, places, spline_nodes, transformed},
};

/// Degree of the B-splines.
const DEGREE: u32 = 2;
/// Part of a push that is made at most, over the part that takes the most energy.
const BEYOND: f64 = 1.15;
/// Weight of a wall's part of the divergence.
const WALL: f64 = 1.25;
/// Sites along each axis of a cell, at which bodies are asked for.
const SITES: usize = 3;

/// Sum r_n of the divergences `rate` \[1/s\] of air at every node, x first. Where air is dense it counts once; at a
/// surface, where pressure does not pull, only what is compressed counts.
#[must_use]
pub fn coarse_deposit(p: &Parameters, x: &[DVec3], v: &[DVec3], rate: &[f64], moments: &[Moments]) -> Vec<f64> {
    let mut sums = vec![0.0; p.coarse_nodes.iter().product()];
    for i in p.hair_points..x.len() {
        for (node, weight, _) in stencil(p, x[i]) {
            sums[node] += weight * source(rate[i], &moments[i], v[i]);
        }
    }
    sums
}

/// Divergence that a particle of velocity `v` brings to the grid \[1/s\]. A wall's part counts 1.25 times: a box full
/// of air sends only 1/2 to 2/3 of a layer of sources outward.
#[must_use]
pub fn source(rate: f64, moments: &Moments, v: DVec3) -> f64 {
    let (density, rate) = (moments.density, rate - (WALL - 1.0) * (moments.wall.dot(v) - moments.wall_rate));
    if density < THIN { rate.max(0.0) } else { rate / density.max(1.0) }
}

/// Hartley transform of the values on the nodes, Σ_m r_m cas(2π k_x m_x/n_x) cas(2π k_y m_y/n_y) cas(2π k_z m_z/n_z)
/// with cas t = cos t + sin t, which the engine solves by (Bracewell 1983): from Fourier's, whose real part it is along
/// each axis less the imaginary one.
#[must_use]
pub fn coarse_waves(p: &Parameters, values: &[f64]) -> Vec<f64> {
    (0..3).fold(values.to_vec(), |values, axis| {
        let waves: Vec<[f64; 2]> = values.iter().map(|value| [*value, 0.0]).collect();
        let turned = transformed(p.coarse_nodes, &waves, axis, -1.0);
        turned.into_iter().map(|[real, imaginary]| real - imaginary).collect()
    })
}

/// Coefficients c_n of the coarse pressure \[m²/s\] from what was deposited: the equations of all nodes are solved,
/// wave by wave, for air that fills the box. Where a body or a hole leaves it out c is too small, and so it stays
/// stable.
#[must_use]
pub fn coarse_solve(p: &Parameters, deposited: &[f64]) -> Vec<f64> {
    let nodes = p.coarse_nodes;
    let spacing = coarse_spacing(p);
    let each = spacing.element_product() / p.air_volume;
    let mut waves: Vec<[f64; 2]> = deposited.iter().map(|sum| [*sum, 0.0]).collect();
    for axis in 0..3 {
        waves = transformed(nodes, &waves, axis, -1.0);
    }
    for (wave, place) in waves.iter_mut().zip(places(nodes)) {
        let turn = |axis: usize| TAU * place[axis] as f64 / nodes[axis] as f64;
        let mass = [0, 1, 2].map(|axis| overlap(turn(axis)));
        let along = |a: usize, b: usize, c: usize| stiffness(turn(a)) / spacing[a].powi(2) * mass[b] * mass[c];
        let symbol = each * (along(0, 1, 2) + along(1, 2, 0) + along(2, 0, 1));
        *wave = if place == [0; 3] { [0.0; 2] } else { wave.map(|part| part / symbol) };
    }
    for axis in 0..3 {
        waves = transformed(nodes, &waves, axis, 1.0);
    }
    waves.into_iter().map(|[real, _]| real / deposited.len() as f64).collect()
}

/// Change q_i of each air particle's velocity by the coarse pressure \[m/s\], before its mean is taken out; 0 for hair.
#[must_use]
pub fn coarse_gather(p: &Parameters, x: &[DVec3], pressure: &[f64]) -> Vec<DVec3> {
    (0..x.len()).map(|i| if p.is_air(i) { pushed(p, x[i], pressure) } else { DVec3::ZERO }).collect()
}

/// Change q at a place by the coarse pressure \[m/s\].
fn pushed(p: &Parameters, x: DVec3, pressure: &[f64]) -> DVec3 {
    let part = (p.spacing() / (p.largest_wind * p.step)).min(1.0);
    -part * stencil(p, x).into_iter().map(|(node, _, slope)| pressure[node] * slope).sum::<DVec3>()
}

/// Sums over a body as if air filled it and moved with it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Solid {
    /// Number of particles that would fill it.
    pub particles: f64,
    /// Sum of the changes q \[m/s\].
    pub change: DVec3,
    /// Sum of the velocities v \[m/s\].
    pub velocity: DVec3,
    /// Sum of q · v \[m²/s²\].
    pub work: f64,
}

/// Change that the coarse pressure would make to each body, from the sites of a lattice that lie in it, and in no body
/// before it.
#[must_use]
pub fn coarse_solid(p: &Parameters, placed: &[Placed], pressure: &[f64]) -> Vec<Solid> {
    let mut solids = vec![Solid::default(); placed.len()];
    if placed.is_empty() {
        return solids;
    }
    let pitch = coarse_spacing(p) / SITES as f64;
    let particles = pitch.element_product() / p.air_volume;
    for site in places(p.coarse_nodes.map(|nodes| SITES * nodes)) {
        let x = pitch * (DVec3::from_array(site.map(|k| k as f64)) + 0.5);
        let Some(body) = placed.iter().position(|placed| placed.surface(x).distance < 0.0) else { continue };
        let (q, v) = (pushed(p, x, pressure), placed[body].velocity(x, p.step));
        let solid = &mut solids[body];
        solid.particles += particles;
        solid.change += particles * q;
        solid.velocity += particles * v;
        solid.work += particles * q.dot(v);
    }
    solids
}

/// Impulses of the coarse pressure on bodies, over the mass of an air particle \[m/s\], with all that BDF2 makes of
/// them.
#[must_use]
pub fn coarse_impulse(solids: &[Solid], mean: DVec3, part: f64) -> Vec<DVec3> {
    solids.iter().map(|solid| LASTING * part * (solid.change - solid.particles * mean)).collect()
}

/// Mean of the changes q of the velocities of air and bodies \[m/s\], and the part p of what is left of them that air
/// of velocities `v` gets: p = 1.15 a/b, from 0 to 1, with a = −Σ (q − mean of q) · v over air and bodies and b = Σ |q
/// − mean of q|² over air. A change of p q changes the energy by m (−p a + p² b/2), with the work on bodies.
#[must_use]
pub fn coarse_mean(p: &Parameters, v: &[DVec3], change: &[DVec3], solids: &[Solid]) -> (DVec3, f64) {
    let air = (change.len() - p.hair_points) as f64;
    let all = air + solids.iter().map(|solid| solid.particles).sum::<f64>();
    let sum = air * turbulence::mean(p, change) + solids.iter().map(|solid| solid.change).sum::<DVec3>();
    let mean = sum / all;
    let of_bodies: f64 = solids.iter().map(|solid| solid.work - mean.dot(solid.velocity)).sum();
    let left = || change.iter().zip(v).skip(p.hair_points).map(|(q, v)| (*q - mean, *v));
    let taken: f64 = -left().map(|(q, v)| q.dot(v)).sum::<f64>() - of_bodies;
    let square: f64 = left().map(|(q, _)| q.length_squared()).sum();
    (mean, (BEYOND * taken / square.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0))
}

/// Change p (q_i − mean of q) of each air particle's velocity that is made \[m/s\]; 0 for hair.
#[must_use]
pub fn coarse_push(p: &Parameters, change: &[DVec3], mean: DVec3, part: f64) -> Vec<DVec3> {
    (0..change.len()).map(|i| if p.is_air(i) { part * (change[i] - mean) } else { DVec3::ZERO }).collect()
}

/// Distance between nodes \[m\].
fn coarse_spacing(p: &Parameters) -> DVec3 {
    p.box_size / DVec3::from_array(p.coarse_nodes.map(|n| n as f64))
}

/// Nodes near a position, with φ_n and ∇φ_n \[1/m\] there.
fn stencil(p: &Parameters, x: DVec3) -> Vec<(usize, f64, DVec3)> {
    let spacing = coarse_spacing(p);
    let [nx, ny, _] = p.coarse_nodes;
    // Node, spline and slope.
    let along = [0, 1, 2].map(|axis| -> Vec<(usize, f64, f64)> {
        let near = spline_nodes(DEGREE, x[axis] / spacing[axis], p.coarse_nodes[axis]);
        let values = near.into_iter().map(|(node, gap)| {
            let slope = b_spline(DEGREE - 1, gap + 0.5) - b_spline(DEGREE - 1, gap - 0.5);
            (node, b_spline(DEGREE, gap), slope / spacing[axis])
        });
        values.collect()
    });
    let mut all = Vec::new();
    for &(k, c, dc) in &along[2] {
        for &(j, b, db) in &along[1] {
            all.extend(along[0].iter().map(|&(i, a, da)| {
                let slope = DVec3::new(da * b * c, a * db * c, a * b * dc);
                (i + nx * (j + ny * k), a * b * c, slope)
            }));
        }
    }
    all
}

/// ∫ φ_m φ_n dx over a wave that turns by `turn` from node to node, in node spacings.
fn overlap(turn: f64) -> f64 {
    (66.0 + 52.0 * turn.cos() + 2.0 * (2.0 * turn).cos()) / 120.0
}

/// ∫ φ_m' φ_n' dx over a wave that turns by `turn` from node to node, times the node spacing.
fn stiffness(turn: f64) -> f64 {
    1.0 - 2.0 / 3.0 * turn.cos() - 1.0 / 3.0 * (2.0 * turn).cos()
}
