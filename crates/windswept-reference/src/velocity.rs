//! Heading 6: moves of air by the density constraint become velocities. Hair has those of its rods' moves, from heading 4.

use crate::{Parameters, fluid, step::Scratch};

/// Runs the heading: air adds what the density constraint moved it by.
pub fn run(w: &mut Scratch, p: &Parameters) {
    for i in p.hair_points..w.predicted.len() {
        w.new_velocity[i] = fluid::velocity(p, w.new_velocity[i], w.correction[i]);
    }
}
