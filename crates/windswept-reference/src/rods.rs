//! Heading 4: Cosserat rods (Kugelstadt & Schömer 2016), integrated by BDF2 or Euler, solved directly or by Gauss-Seidel.
//! Forces on hair from outside its rods meet in one load of each point; air that drags hair is slowed by it.

mod direct;
mod drag;
mod finish;
mod gauss_seidel;
mod integrate;
mod start;
mod within;

use glam::DVec3;
use windswept_scene::Model;

use self::integrate::{cross_matrix, nearest_rest};
pub use self::{
    direct::{FITS, QUIET, direct},
    drag::{Local, ahead, drag, follows_wind, react, sample, undisturbed, undisturbed_part, weight},
    finish::{finish, forget, hold, place, remember, rescue, settle, still},
    gauss_seidel::gauss_seidel,
    integrate::{damping, free_move, largest_moves, rate, response, rotation, rotation_vector, turned},
    start::{Choice, choose, load, start},
    within::{Drive, Load, Moving, Point, Segment, State},
};
use crate::{Parameters, drive, state, step::Scratch};

/// Stretch |l/l0 − 1| of a segment beyond which its strand is strained.
pub const STRAINED: f64 = 0.05;
/// Over-strained steps on end at which a strand is warned of.
pub const STRAINED_STEPS: u32 = 50;
/// Gap |C| of stretch-shear where velocities lead, beyond which a strand is not calm.
pub const TORN: f64 = 0.1;
/// Gap |C + α μ| of stretch-shear from which the direct solver has lost a strand.
pub const LOST: f64 = 1.0;
/// Gap |C + α μ| that the direct solver may leave in a calm strand.
pub const MISFIT: f64 = 1e-2;
/// Steps on end in which velocities must lead a strand without tearing it before BDF2 may go on.
pub const CALM_STEPS: u32 = 3;
/// Resistance Δt w D_n from which on a strand in the wind takes Euler.
pub const STORMY: f64 = 1.0 / 3.0;
/// Move of a free point by its load that any whole strand bears in a step, over the length of the strand.
pub const LOADED: f64 = 0.4;
/// Growth of the farthest free move from step to step that a strand bears where air drags it, or once it had to be put.
pub const GROWTH: f64 = 2.0;
/// Part of a free move that a strand could not follow, which the next step asks of it.
pub const EASED: f64 = 0.25;
/// Force on the tip of a strand that bends it as far as a force on all of it, over that: 3/8 for a clamped beam, 1/ln n for a chain
/// of n points.
const AT_TIP: f64 = 0.25;
/// Steps at rest that a strand needs to fall asleep, however long they are.
pub const STILL_STEPS: u32 = 10;
/// Turn of a frame at rest \[rad\].
pub const STILL_TURN: f64 = 1e-3;

/// Function that adds a force to the load of each hair point, [`Scratch::hair_force`].
pub type Force = fn(&mut state::State, &mut Scratch, &Parameters);

/// Forces on hair from outside its rods, each with the name of its pass, in the order in which they act.
pub const FORCES: &[(&str, Force)] = &[("wind/drag", drag::act), ("force/push_hair", push_hair)];

/// Runs the heading: strands keep their length and shape, and what drag gave them the air loses.
pub fn run(s: &mut state::State, w: &mut Scratch, p: &Parameters) {
    begin(s, w, p);
    w.local = feel(s, w, p);
    FORCES.iter().for_each(|(_, force)| force(s, w, p));
    bear(s, w, p);
    set_off(s, w, p);
    for strand in 0..s.hair.len() {
        if p.direct {
            for _ in 0..p.newton_steps {
                let quiet = direct(p, &s.hair, strand, &mut w.drives[strand], &mut w.moving);
                s.quiet_steps += usize::from(quiet);
            }
            s.rescued_steps += usize::from(rescue(p, &s.hair, strand, &mut w.drives[strand], &mut w.moving));
        }
        gauss_seidel(p, &s.hair, strand, &w.drives[strand], &mut w.moving);
    }
    leave(s, w, p);
    w.drag_impulse = keep(s, w, p);
    if exchanges(p) {
        let change = react(p, &w.local, &w.drag_impulse, &w.predicted, &s.volume, &s.inverse_mass, &w.near);
        w.new_velocity[p.hair_points..].iter_mut().zip(change).for_each(|(v, change)| *v += change);
    }
}

/// Whether hair and air particles exchange drag.
fn exchanges(p: &Parameters) -> bool {
    p.model == Model::TwoWay && p.air
}

/// Begins the heading: what points and segments start from, BDF2 or Euler, and the air at hair points. No force acts yet.
pub fn begin(s: &state::State, w: &mut Scratch, p: &Parameters) {
    let largest = largest_moves(&s.hair);
    w.moving.points = (0..p.hair_points).map(|i| begin_points(p, s, i, w.correction[i], largest[i])).collect();
    w.hair_force = vec![Load::default(); p.hair_points];
    let segments = (0..s.hair.len()).flat_map(|strand| s.hair.segments(strand).map(move |k| (strand, k)));
    w.moving.segments = segments.map(|(strand, k)| begin_segments(s, strand, k)).collect();
    for strand in 0..s.hair.len() {
        choose(p, s, strand, &mut w.drives[strand], &w.moving);
    }
    w.local = if exchanges(p) {
        sample(p, w.blowing, &w.predicted, &w.new_velocity, &s.volume, &w.near)
    } else {
        vec![undisturbed(w.blowing); p.hair_points]
    };
}

/// Air at every hair point with the wind of force fields, where no air carries it: to the part to which the mean wind counts there.
#[must_use]
pub fn feel(s: &state::State, w: &Scratch, p: &Parameters) -> Vec<Local> {
    let at = |(i, local): (usize, &Local)| {
        let position = if exchanges(p) { local.position } else { s.position[i] + p.step * s.velocity[i] };
        let (wind, _) = drive::gale(p, s.steps, position);
        Local { wind: local.wind + undisturbed_part(local) * wind, ..*local }
    };
    w.local.iter().enumerate().map(at).collect()
}

/// Adds the force m a of the acceleration that was set to the load of each hair point that nothing holds.
pub fn push_hair(s: &mut state::State, w: &mut Scratch, _: &Parameters) {
    for (i, (load, a)) in w.hair_force.iter_mut().zip(&s.pushed).enumerate() {
        if s.inverse_mass[i] > 0.0 {
            load.force += s.hair.weight(i) / s.inverse_mass[i] * *a;
        }
    }
}

/// Impulses of the air's drag \[N s\]: those of the whole load without what the acceleration that was set gave. A force that was cut
/// cuts both alike.
#[must_use]
pub fn keep(s: &state::State, w: &Scratch, p: &Parameters) -> Vec<DVec3> {
    let mut impulses = w.drag_impulse.clone();
    for (i, a) in s.pushed.iter().enumerate().take(p.hair_points) {
        let (all, felt) = (w.hair_force[i].force.length(), w.moving.points[i].load.force.length());
        if s.inverse_mass[i] > 0.0 && all > 0.0 {
            impulses[i] -= p.step * (felt / all).min(1.0) / s.inverse_mass[i] * s.hair.weight(i) * *a;
        }
    }
    impulses
}

/// Hands the loads to the rods.
pub fn bear(s: &state::State, w: &mut Scratch, p: &Parameters) {
    for (i, force) in w.hair_force.iter().enumerate() {
        load(p, s, i, *force, &mut w.moving.points[i]);
    }
}

/// Decides how each strand goes through the step.
pub fn set_off(s: &mut state::State, w: &mut Scratch, p: &Parameters) {
    for strand in 0..s.hair.len() {
        let choice = start(p, s, strand, &mut w.drives[strand], &mut w.moving);
        s.capped += choice.capped;
        s.euler_steps += usize::from(choice.euler);
        s.asleep_steps += usize::from(w.drives[strand].state == State::Asleep);
        s.teleports += usize::from(w.drives[strand].state == State::Teleported);
    }
}

/// Leaves the rods: the health of each strand is found, and hair goes where its rods took it.
pub fn leave(s: &mut state::State, w: &mut Scratch, p: &Parameters) {
    w.strained_before.clone_from(&s.strained_steps);
    for strand in 0..s.hair.len() {
        let stretch = finish(&s.hair, strand, &w.moving);
        s.bad[strand] = stretch.is_none();
        let Some(stretch) = stretch else {
            hold(&s.hair, strand, &mut w.moving);
            s.reach[strand] = 0.0;
            s.resets += 1;
            continue;
        };
        s.max_stretch = s.max_stretch.max(stretch);
        s.strained_steps[strand] = if stretch > STRAINED { s.strained_steps[strand] + 1 } else { 0 };
        s.over_strained += usize::from(s.strained_steps[strand] == STRAINED_STEPS);
        if w.drives[strand].state.is_swept(p) {
            forget(&s.hair, strand, &mut w.moving);
        }
        // A misfit that is not a number counts as well.
        if w.drives[strand].misfit.partial_cmp(&MISFIT).is_none_or(|order| order.is_gt()) {
            (s.calm[strand], s.still[strand]) = (0, 0);
            // It was put: the next step asks less of it.
            let drive = &w.drives[strand];
            if drive.far && drive.state == State::Solved && drive.misses() {
                s.reach[strand] *= if s.reach[strand] < 0.0 { EASED / GROWTH } else { -EASED };
            }
        }
        if p.sleep {
            let still = still(p, &s.hair, strand, &w.moving);
            s.still[strand] = if still { s.still[strand] + 1 } else { 0 };
            if s.asleep[strand] {
                continue;
            }
            if still {
                remember(&s.hair, strand, &mut w.moving, s.still[strand]);
            } else {
                settle(&s.hair, strand, &mut w.moving);
            }
        }
    }
    for (i, point) in w.moving.points.iter().enumerate() {
        w.predicted[i] = s.position[i] + point.travel;
    }
    w.drag_impulse = w.moving.points.iter().map(|point| place(p, point)).collect();
}

/// Start of hair point `i`: what density moved the drifting point by, `correction` \[m\], is an impulse on it.
#[must_use]
pub fn begin_points(p: &Parameters, s: &state::State, i: usize, correction: DVec3, largest: f64) -> Point {
    let inverse_mass = s.inverse_mass[i];
    let change = if inverse_mass > 0.0 { correction / p.step } else { DVec3::ZERO };
    Point {
        velocity: s.velocity[i] + change,
        before: s.velocity_before[i] + change,
        carried: s.travel[i],
        change,
        inverse_mass,
        weight: s.hair.weight(i),
        largest,
        strayed: s.strayed[i],
        ..Point::default()
    }
}

/// Start of segment `k`, which belongs to `strand`.
#[must_use]
pub fn begin_segments(s: &state::State, strand: usize, k: usize) -> Segment {
    let point = s.hair.points(strand).start + k - s.hair.segments(strand).start;
    Segment {
        start: s.orientation[k],
        angular_velocity: s.angular_velocity[k],
        before: s.angular_velocity_before[k],
        carried: s.turn[k],
        chord: s.position[point + 1] - s.position[point],
        force: s.force[k],
        moment: s.moment[k],
        strayed: s.segment_strayed[k],
        ..Segment::default()
    }
}
