//! Walls: boundary conditions of bodies for the air near them, for solver `divergence`.
//!
//! A body is a plane at the distance φ of its nearest surface, with that surface's normal n. The air's sums lack the
//! parts of the kernels beyond the plane, P of Spiky's gradient and Ψ of Poly6, which are integrals of φ alone. Beyond
//! it the air sees its mirror image: as dense, and with its normal velocity reversed about that of the body.

use glam::DVec3;
use windswept_scene::{FluidSolver, Model};

use crate::{
    Parameters,
    contact::{self, Nearest, Placed},
    step::Scratch,
};

/// Least distance of air from a surface \[particle spacings\].
pub const CLEARANCE: f64 = 0.4;
/// Distance from a body up to which density errors are fed back in full, and from twice which on they are not
/// \[particle spacings\].
const NEAR: f64 = 4.0;

/// The nearest surface to a particle.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Wall {
    /// Unit vector out of the body.
    pub normal: DVec3,
    /// Distance φ from the surface, negative inside \[m\].
    pub distance: f64,
    /// Velocity of the surface there \[m/s\].
    pub velocity: DVec3,
    /// Way of the air in a step beside the body \[particle spacings\], at most 1; 0 far from it.
    pub way: f64,
    /// Index of the body.
    pub body: usize,
    /// Impulse that the particle has given the body in this step, over the mass of an air particle \[m/s\].
    pub impulse: DVec3,
}

/// The part P of the kernel's gradient beyond a plane \[1/m\]: ∫ ∇W dV = −P n over all that is farther than φ along −n.
#[must_use]
pub fn gradient_beyond(p: &Parameters, distance: f64) -> f64 {
    let u = 1.0 - distance.max(0.0) / p.kernel_radius;
    if u > 0.0 { 30.0 / p.kernel_radius * (u.powi(4) / 4.0 - u.powi(5) / 5.0) } else { 0.0 }
}

/// The part Ψ of the kernel beyond a plane: ∫ W dV.
#[must_use]
pub fn density_beyond(p: &Parameters, distance: f64) -> f64 {
    let q = (distance / p.kernel_radius).clamp(-1.0, 1.0);
    let odd = |n: i32, factor: f64| factor * q.powi(n) / f64::from(n);
    0.5 - 315.0 / 256.0 * (odd(1, 1.0) - odd(3, 4.0) + odd(5, 6.0) - odd(7, 4.0) + odd(9, 1.0))
}

/// The part of the kernel that bodies take at a place before the step for which they are placed.
#[must_use]
pub fn solid(p: &Parameters, placed: &[Placed], x: DVec3) -> f64 {
    density_beyond(p, contact::nearest_body(p, placed, true, x).distance)
}

/// Whether bodies are walls to the air.
#[must_use]
pub fn has_walls(p: &Parameters) -> bool {
    p.air && p.fluid.solver == FluidSolver::Divergence && !p.bodies.is_empty()
}

/// The wall that a surface is to a particle of this speed \[m/s\].
#[must_use]
pub fn wall(p: &Parameters, near: Nearest, speed: f64) -> Wall {
    let Nearest { normal, distance, velocity, body } = near;
    let spacing = p.spacing();
    let close = (2.0 - distance / (NEAR * spacing)).clamp(0.0, 1.0);
    let fastest = p.largest_wind.max(speed).max(velocity.length());
    let way = close * (fastest * p.step / spacing).min(1.0);
    Wall { normal, distance, velocity, way, body, impulse: DVec3::ZERO }
}

/// Moves air that is nearer to a body than its clearance out of it, and finds the wall at each particle that pressure
/// acts on; none in a scene without walls.
pub fn walls(w: &mut Scratch, p: &Parameters) {
    w.walls.clear();
    if !has_walls(p) {
        return;
    }
    for i in 0..w.predicted.len() {
        let placed = &w.moving.bodies;
        let near = if p.is_air(i) {
            let cleared = contact::cleared(p, placed, w.predicted[i]);
            w.predicted[i] = cleared.x;
            Some(cleared.near)
        } else {
            (p.interaction.model == Model::Particles).then(|| contact::nearest_body(p, placed, false, w.predicted[i]))
        };
        w.walls.push(near.map_or_else(Wall::default, |near| wall(p, near, w.new_velocity[i].length())));
    }
}
