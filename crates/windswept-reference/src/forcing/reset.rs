//! Strands that are invalid when a step begins, and strands that are reset.

use glam::DVec3;

use crate::{State, commit::FAST};

/// Distance from its root that no point of a strand has \[lengths of the strand\].
pub(crate) const FAR: f64 = 1e3;
/// Distance from the origin that no root has \[m\].
const WORLD: f64 = 1e9;
/// Largest distance of the square of a frame's length from 1.
const UNLIKE: f64 = 0.1;

/// Resets strands before any other function reads them: those that the step before left bad, and those that are
/// invalid, which are bad from here on. Returns the number of invalid strands.
pub fn recover(s: &mut State) -> usize {
    let mut invalid = 0;
    for strand in 0..s.hair.len() {
        if !s.failed[strand] && !inspect(s, strand) {
            s.failed[strand] = true;
            invalid += 1;
        }
        if s.failed[strand] {
            reset(s, strand);
        }
    }
    s.resets += invalid;
    invalid
}

/// Says whether a strand is sound: every place, speed and frame of it is finite, and one that a strand can have.
#[must_use]
pub fn inspect(s: &State, strand: usize) -> bool {
    let points = s.hair.points(strand);
    let root = root(s, strand);
    let place = |i: usize| in_reach(s, strand, root, s.position[i]);
    let speed = |i: usize| s.velocity[i].length() <= FAST && s.velocity_before[i].length() <= FAST;
    let memory = |i: usize| {
        [s.displacement[i], s.external_dv[i], s.own[i], s.tangential_spring[i]].iter().all(|v| v.is_finite())
    };
    let frame = |k: usize| (s.orientation[k].length_squared() - 1.0).abs() <= UNLIKE;
    points.clone().all(|i| place(i) && speed(i) && memory(i)) && s.hair.segments(strand).all(frame)
}

/// Place of a strand's root: at its clamp, or where the first point drifted to if nothing holds it \[m\].
fn root(s: &State, strand: usize) -> DVec3 {
    let first = s.hair.points(strand).start;
    let drifts = s.inverse_mass[first] > 0.0 && s.position[first].length() <= WORLD;
    if drifts { s.position[first] } else { s.clamps[strand].0 }
}

fn in_reach(s: &State, strand: usize, root: DVec3, place: DVec3) -> bool {
    let length: f64 = s.hair.rest_length[s.hair.segments(strand)].iter().sum();
    place.distance(root) <= FAR * length
}

/// Resets a strand: it is unrolled from its clamp into its rest shape, at rest and with no memory; a tip that is held
/// stays.
pub fn reset(s: &mut State, strand: usize) {
    let (points, root) = (s.hair.points(strand), root(s, strand));
    let (mut place, mut frame) = (root, s.clamps[strand].1);
    let mut places = vec![place];
    for k in s.hair.segments(strand) {
        frame = (frame * s.hair.rest_rotation[k]).normalize();
        place += s.hair.rest_length[k] * (frame * DVec3::Z);
        places.push(place);
    }
    let tip = points.end - 1;
    if s.inverse_mass[tip] == 0.0 && in_reach(s, strand, root, s.position[tip]) {
        places[tip - points.start] = s.position[tip];
    }
    for (i, place) in points.zip(places) {
        s.position[i] = place;
        (s.velocity[i], s.velocity_before[i], s.displacement[i]) = Default::default();
        (s.external_dv[i], s.own[i], s.tangential_spring[i], s.rest_drift[i]) = Default::default();
    }
}
