//! Stage `rods`: Cosserat rods (Kugelstadt & Schömer 2016), integrated by BDF2 or Euler, solved directly or by
//! Gauss-Seidel. External forces on hair are summed in one load of each point; air that drags hair is slowed by it.
//! Contacts with bodies are solved with the rods.

mod drag;
mod gauss_seidel;
mod integrate;
mod predict;
mod solve;
mod touch;
mod update;
mod within;

use glam::DVec3;
use windswept_scene::Model;

use self::integrate::{cross_matrix, nearest_rest};
pub use self::{
    drag::{Local, ahead, drag, follows_wind, react, sample_air, undisturbed, undisturbed_part, weight},
    gauss_seidel::gauss_seidel,
    integrate::{damping, free_move, rate, response, rotation, rotation_vector, turned},
    predict::predict,
    solve::{RELATIVE, SETTLED, TURN, WHOLE, potential, solve},
    update::{measure, remember, rests, update},
    within::{Load, Moving, Point, Segment, State, StrandMotion},
};
use crate::{
    Parameters, contact, forcing, state,
    step::{Observer, Scratch},
};

/// Stretch |l/l0 − 1| of a segment beyond which its strand is strained.
pub const STRAINED: f64 = 0.05;
/// Consecutive over-strained steps at which a strand is warned of.
pub const STRAINED_STEPS: u32 = 50;
/// Resistance Δt w D_n from which on a strand in the wind takes Euler.
pub const STORMY: f64 = 1.0 / 3.0;
/// Force on the tip of a strand that bends it as far as a force on all of it, over that: 3/8 for a clamped beam, 1/ln n
/// for a chain of n points.
const AT_TIP: f64 = 0.25;
/// Steps at rest that a strand needs to fall asleep, however long they are.
pub const RESTING_STEPS: u32 = 10;
/// Turn of a frame at rest \[rad\].
pub const STILL_TURN: f64 = 1e-3;

/// Function that adds a force to the load of each hair point, [`Point::load`].
pub type Force = fn(&mut state::State, &mut Scratch, &Parameters);

/// External forces on hair, each with the name of its pass, in the order in which they act.
pub const FORCES: &[(&str, Force)] = &[("rods/drag", drag::act), ("rods/push_hair", push_hair)];

/// Runs the stage: strands keep their length and shape, and the air loses the impulse of its drag on them.
pub fn run(s: &mut state::State, w: &mut Scratch, p: &Parameters, see: &mut Observer<'_>) {
    begin(s, w, p);
    see("rods/begin", s, w);
    see("rods/sample_air", s, w);
    w.local = sample_fields(s, w, p);
    see("rods/sample_fields", s, w);
    for (pass, force) in FORCES {
        force(s, w, p);
        see(pass, s, w);
    }
    contact::contacts(s, w, p);
    see("rods/contacts", s, w);
    predict_all(s, w, p);
    see("rods/predict", s, w);
    solve_all(s, w, p);
    see(if p.direct() { "rods/solve" } else { "rods/gauss_seidel" }, s, w);
    update_all(s, w, p);
    see("rods/update", s, w);
    see("rods/drag_impulse", s, w);
    w.drag_impulse = exclude_push(s, w, p);
    see("rods/exclude_push", s, w);
    if exchanges(p) {
        let change = react(p, &w.local, &w.drag_impulse, &w.predicted, &s.volume, &s.inverse_mass, &w.near);
        w.new_velocity[p.hair_points..].iter_mut().zip(change).for_each(|(v, change)| *v += change);
        see("rods/react", s, w);
    }
}

/// Whether hair and air particles exchange drag.
fn exchanges(p: &Parameters) -> bool {
    p.interaction.model == Model::TwoWay && p.air
}

/// Begins the stage: the start of points and segments, and the air at hair points. No force acts yet.
pub fn begin(s: &state::State, w: &mut Scratch, p: &Parameters) {
    w.moving.points = (0..p.hair_points).map(|i| begin_point(p, s, i, w.correction[i])).collect();
    let segments = (0..s.hair.len()).flat_map(|strand| s.hair.segments(strand).map(move |k| (strand, k)));
    w.moving.segments = segments.map(|(strand, k)| begin_segment(s, strand, k)).collect();
    w.local = if exchanges(p) {
        sample_air(p, w.blowing, &w.predicted, &w.new_velocity, &s.volume, &w.near)
    } else {
        vec![undisturbed(w.blowing); p.hair_points]
    };
}

/// Air at every hair point with the wind of force fields, where no air carries it: to the part to which the mean wind
/// counts there.
#[must_use]
pub fn sample_fields(s: &state::State, w: &Scratch, p: &Parameters) -> Vec<Local> {
    let at = |(i, local): (usize, &Local)| {
        let position = if exchanges(p) { local.position } else { s.position[i] + p.step * s.velocity[i] };
        let (wind, _) = forcing::force_field_velocity(p, s.steps, position);
        Local { wind: local.wind + undisturbed_part(local) * wind, ..*local }
    };
    w.local.iter().enumerate().map(at).collect()
}

/// Adds the force m a of the acceleration that was set to the load of each hair point that nothing holds.
pub fn push_hair(s: &mut state::State, w: &mut Scratch, _: &Parameters) {
    for (i, (point, a)) in w.moving.points.iter_mut().zip(&s.pushed).enumerate() {
        if s.inverse_mass[i] > 0.0 {
            point.load.force += s.hair.weight(i) / s.inverse_mass[i] * *a;
        }
    }
}

/// Impulses of the air's drag \[N s\]: those of the whole load less those of the acceleration that was set. A placed
/// point that does not sleep has neither.
#[must_use]
pub fn exclude_push(s: &state::State, w: &Scratch, p: &Parameters) -> Vec<DVec3> {
    let mut impulses = w.drag_impulse.clone();
    for (i, a) in s.pushed.iter().enumerate().take(p.hair_points) {
        let felt = w.moving.points[i].step.is_finite() || s.sleeping[p.strand_of[i]];
        if s.inverse_mass[i] > 0.0 && felt {
            impulses[i] -= p.step / s.inverse_mass[i] * s.hair.weight(i) * *a;
        }
    }
    impulses
}

/// Decides how each strand goes through the step, and where its solver starts.
pub fn predict_all(s: &mut state::State, w: &mut Scratch, p: &Parameters) {
    for strand in 0..s.hair.len() {
        predict(p, s, strand, &mut w.motions[strand], &mut w.moving);
        let motion = &w.motions[strand];
        s.euler_steps += usize::from(motion.state == State::Free && p.bdf2() && motion.step == p.step);
        s.sleeping_steps += usize::from(motion.state == State::Sleeping);
        s.teleports += usize::from(motion.state == State::Teleported);
    }
}

/// Solves every strand.
pub fn solve_all(s: &state::State, w: &mut Scratch, p: &Parameters) {
    for strand in 0..s.hair.len() {
        if p.direct() {
            solve(p, &s.hair, strand, &mut w.motions[strand], &mut w.moving);
        } else {
            gauss_seidel(p, &s.hair, strand, &w.motions[strand], &mut w.moving);
        }
    }
}

/// Finds how each strand is, and puts hair where its rods took it, with the velocity of that move; and the impulse J =
/// Δt (force − resistance v) that each point had from its load.
pub fn update_all(s: &mut state::State, w: &mut Scratch, p: &Parameters) {
    for strand in 0..s.hair.len() {
        update(p, s, strand, w);
    }
    w.drag_impulse.clear();
    w.rod_velocity = w.moving.points.iter().map(|point| point.velocity_after(p)).collect();
    w.new_velocity[..p.hair_points].copy_from_slice(&w.rod_velocity);
    for (i, point) in w.moving.points.iter_mut().enumerate() {
        w.predicted[i] =
            s.position[i] + if point.held_tip { point.tip_displacement } else { point.shift + point.displacement };
        w.drag_impulse.push(p.step * point.load.at(w.rod_velocity[i]));
        point.before = point.velocity;
    }
}

/// Start of hair point `i`: the density constraint's move of the drifting point, `correction` \[m\], is an impulse on
/// it.
#[must_use]
pub fn begin_point(p: &Parameters, s: &state::State, i: usize, correction: DVec3) -> Point {
    let inverse_mass = s.inverse_mass[i];
    let change = if inverse_mass > 0.0 { correction / p.step } else { DVec3::ZERO };
    Point {
        start: s.position[i],
        velocity: s.velocity[i] + change,
        before: s.velocity_before[i] + change,
        previous_move: s.displacement[i],
        external_dv: change,
        impulse_change: change - s.external_dv[i],
        inverse_mass,
        weight: s.hair.weight(i),
        held_tip: inverse_mass == 0.0 && i > s.hair.points(p.strand_of[i]).start,
        rest_drift: s.rest_drift[i],
        ..Point::default()
    }
}

/// Start of segment `k`, which belongs to `strand`.
#[must_use]
pub fn begin_segment(s: &state::State, strand: usize, k: usize) -> Segment {
    let point = s.hair.points(strand).start + k - s.hair.segments(strand).start;
    Segment {
        start: s.orientation[k],
        angular_velocity: s.angular_velocity[k],
        before: s.angular_velocity_before[k],
        previous_move: s.turn[k],
        chord: s.position[point + 1] - s.position[point],
        rest_drift: s.segment_rest_drift[k],
        ..Segment::default()
    }
}
