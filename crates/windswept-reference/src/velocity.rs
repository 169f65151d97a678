//! Heading 6: moves of hair by contact, and of air by the density constraint, become velocities.

use glam::DVec3;

use crate::{Parameters, State, fluid, rods::Point, step::Scratch};

/// Runs the heading: hair's velocity follows from its moves, by its rods, which the engine finds in heading 4, and by contact; air adds
/// what the density constraint moved it by.
pub fn run(s: &State, w: &mut Scratch, p: &Parameters) {
    for (i, point) in w.moving.points.iter_mut().enumerate() {
        let went = if point.stays { DVec3::ZERO } else { point.shift + point.travel };
        let shift = w.predicted[i] - (s.position[i] + went);
        w.new_velocity[i] = velocity(p, point, shift);
        point.before = point.velocity + shift / p.step;
    }
    for i in p.hair_points..w.predicted.len() {
        w.new_velocity[i] = fluid::velocity(p, w.new_velocity[i], w.correction[i]);
    }
    w.rod_velocity = w.new_velocity[..p.hair_points].to_vec();
}

/// Velocity of a hair point from its move, as its integrator says; what a contact added to the move, `shift` \[m\], is an
/// impulse on top \[m/s\].
#[must_use]
pub fn velocity(p: &Parameters, point: &Point, shift: DVec3) -> DVec3 {
    point.velocity_after(p) + shift / p.step
}
