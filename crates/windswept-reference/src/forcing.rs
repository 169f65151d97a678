//! Stage `forcing`: strands that are bad are reset; clamps and bodies move; the wind enters; air moves, and hair drifts
//! among it.

mod bonds;
mod fields;
mod reset;

use std::f64::consts::PI;

use glam::{DQuat, DVec3};
use windswept_scene::{FluidSolver, InflowWave, Model};

pub use self::bonds::{Bonded, bonded, bonds};
pub(crate) use self::fields::fields;
pub use self::fields::{Field, drive_air, field_strengths, force_field_velocity};
pub(crate) use self::reset::FAR;
pub use self::reset::{inspect, recover, reset};
use crate::{
    Parameters, State, contact, fluid,
    rods::{self, StrandMotion, rotation, rotation_vector},
    step::{Observer, Scratch},
};

/// Runs the stage: clamps and bodies move, the wind enters, air moves, and hair drifts among it as if nothing held it.
#[must_use]
pub fn run(s: &State, p: &Parameters, see: &mut Observer<'_>) -> Scratch {
    let mut w = Scratch {
        blowing: mean_wind(p, s.steps + 1),
        motions: (0..s.hair.len()).map(|strand| roots(p, s, strand)).collect(),
        moving: rods::Moving { bodies: contact::place(p, s.steps), ..rods::Moving::default() },
        predicted: s.position.clone(),
        new_velocity: s.velocity.clone(),
        ..Scratch::default()
    };
    see("forcing/bonds", s, &w);
    see("forcing/roots", s, &w);
    w.predicted[..p.hair_points].iter_mut().enumerate().for_each(|(i, x)| *x = hair_drift(p, s, i));
    see("forcing/hair_drift", s, &w);
    if p.fluid.solver == FluidSolver::Divergence && p.interaction.model == Model::Particles {
        w.new_velocity[..p.hair_points].iter_mut().enumerate().for_each(|(i, v)| *v = extrapolate(p, s, i));
        see("forcing/extrapolate", s, &w);
    }
    let air = p.hair_points..s.position.len();
    w.fringe_deficit = fringe_deficit(p, s.steps, &s.position[air.clone()], &s.velocity[air.clone()]);
    w.wind_deficit = hold(p, s.steps, w.fringe_deficit);
    let wind = |i: usize| fringe(p, s.steps, w.wind_deficit, s.position[i], s.velocity[i]);
    w.wind_change = air.clone().map(wind).collect();
    see("forcing/fringe", s, &w);
    for (i, change) in air.clone().zip(&mut w.wind_change) {
        *change += drive_air(p, s.steps, s.position[i], s.velocity[i] + *change);
    }
    see("forcing/drive_air", s, &w);
    air.clone().zip(&mut w.wind_change).for_each(|(i, change)| *change += push_air(p, s, i));
    see("forcing/push_air", s, &w);
    for (i, change) in air.zip(&w.wind_change) {
        let v = s.velocity[i] + *change;
        (w.predicted[i], w.new_velocity[i]) = match p.fluid.solver {
            FluidSolver::Divergence => advance(p, s.position[i], v, s.pressed[i].change),
            FluidSolver::Pbf => (predict(p, s.position[i], v), v),
        };
    }
    see("forcing/predict", s, &w);
    see("forcing/advance", s, &w);
    fluid::walls(&mut w, p);
    see("forcing/walls", s, &w);
    w
}

/// Way of the frame of `air.follows` after `steps` steps \[m\], and its velocity in the last of them \[m/s\].
#[must_use]
pub fn frame(p: &Parameters, steps: u64) -> (DVec3, DVec3) {
    let time = steps as f64 * p.step;
    let next = p.frame.partition_point(|entry| entry.time <= time);
    match (next.checked_sub(1).map(|last| p.frame[last]), p.frame.get(next)) {
        (Some(a), Some(b)) => {
            let part = (time - a.time) / (b.time - a.time);
            (a.place.lerp(b.place, part), a.velocity.lerp(b.velocity, part))
        }
        (Some(held), None) => (held.place, held.velocity),
        (None, Some(held)) => (held.place, held.velocity),
        (None, None) => (DVec3::ZERO, DVec3::ZERO),
    }
}

/// Takes the change of the frame's velocity in the step from the velocities of hair that is not held, and wakes
/// strands.
pub fn carry(s: &mut State, p: &Parameters) {
    // Hair starts at rest in the frame.
    let before = if s.steps == 0 { frame(p, 0).1 } else { s.frame_velocity };
    s.frame_velocity = frame(p, s.steps + 1).1;
    let change = s.frame_velocity - before;
    if change == DVec3::ZERO {
        return;
    }
    for i in (0..p.hair_points).filter(|&i| s.inverse_mass[i] > 0.0) {
        s.velocity[i] -= change;
        s.velocity_before[i] -= change;
        s.displacement[i] -= p.step * change;
    }
    for (sleeping, resting) in s.sleeping.iter_mut().zip(&mut s.resting) {
        if std::mem::take(sleeping) {
            *resting = 0;
        }
    }
}

/// Way of the clamp of a strand in the step: to where its keyframes are at the step's end, else a part of the way to
/// its target, all of it in the last substep. A jump of more than the strand's length is a teleport, unless the tip is
/// held too; a strand whose clamp rests may sleep. Free roots go where they will. A held tip goes along by the
/// keyframes.
#[must_use]
pub fn roots(p: &Parameters, s: &State, strand: usize) -> StrandMotion {
    let (held, mut goal) = (s.clamps[strand], s.root_targets[strand]);
    let bound = bonds(p, s, strand);
    let (mut tip_goal, mut tip_frame) = (s.tip_targets[strand], s.hair.ends(strand).tip_frame);
    let mut left = u64::from(p.substeps) - s.steps % u64::from(p.substeps);
    let group = s.hair.group.get(strand).and_then(|group| p.hair_motions.get(*group as usize));
    if let Some((motion, center)) = group.filter(|(motion, _)| !motion.keyframes.is_empty()) {
        // The target is as drawn, and is carried from where keyframes start to where they are at the step's end.
        let (start, end) = (motion.at(0.0), motion.at((s.steps + 1) as f64 * p.step));
        let turn = end.rotation * start.rotation.conjugate();
        let carried = |x: DVec3| *center + end.translation + turn * (x - *center - start.translation);
        goal = match bound {
            // Bonds are in the body's own place.
            Some((x, frame)) => {
                (*center + end.translation + end.rotation * (x - *center), (end.rotation * frame).normalize())
            }
            None => (carried(goal.0), (turn * goal.1).normalize()),
        };
        (tip_goal, tip_frame) = (carried(tip_goal), (turn * tip_frame).normalize());
        left = 1;
    }
    let (points, free) = (s.hair.points(strand), |i: usize| s.inverse_mass[i] > 0.0);
    if free(points.start) {
        goal = held;
    }
    let way = goal.0 - held.0;
    let length: f64 = s.hair.rest_length[s.hair.segments(strand)].iter().sum();
    let jumps = free(points.end - 1) && way.length() > length;
    let part = if jumps { 1.0 } else { 1.0 / left as f64 };
    let tip_way = if free(points.end - 1) { DVec3::ZERO } else { tip_goal - s.position[points.end - 1] };
    let (tip_force, tip_displacement) = (s.tip_force[strand], part * tip_way);
    // The first step has no change of velocity to carry on.
    let step = if p.bdf2() && s.bdf2_ready[strand] { p.step * 2.0 / 3.0 } else { p.step };
    if held == goal && tip_way == DVec3::ZERO {
        let state = if p.rods.sleep { rods::State::Sleeping } else { rods::State::Free };
        return StrandMotion {
            root_displacement: DVec3::ZERO,
            root_frame: held.1,
            root_turn: DQuat::IDENTITY,
            state,
            step,
            tip_force,
            tip_frame,
            ..StrandMotion::default()
        };
    }
    let root_turn = rotation(part * rotation_vector(goal.1 * held.1.conjugate()));
    StrandMotion {
        root_displacement: part * way,
        root_turn,
        // The frame is the target's to the bit where the clamp arrives: a clamp that was off by rounding would never
        // rest.
        root_frame: if part == 1.0 { goal.1 } else { (root_turn * held.1).normalize() },
        state: if jumps { rods::State::Teleported } else { rods::State::Free },
        step,
        tip_force,
        tip_displacement,
        tip_frame,
        ..StrandMotion::default()
    }
}

/// Place of hair point `i` if no rod holds it: x + Δt (v + w g Δt)/(1 + c Δt), w the point's weight.
/// A point of infinite mass goes on with its velocity.
#[must_use]
pub fn hair_drift(p: &Parameters, s: &State, i: usize) -> DVec3 {
    if s.inverse_mass[i] == 0.0 {
        return s.position[i] + p.step * s.velocity[i];
    }
    let falls = s.velocity[i] + p.step * s.hair.weight(i) * p.gravity;
    s.position[i] + p.step * falls / (1.0 + p.rods.damping * p.step)
}

/// Velocity v* by which hair point `i` counts where pressure acts on it, that of the step's end if all went on as
/// before \[m/s\]: v + ⅓(v − v_{n−1}) where BDF2 is to take the strand, else v. Gravity has no part in it: rods bear
/// most of it, and hair that hangs at rest must not press on the air below it.
#[must_use]
pub fn extrapolate(p: &Parameters, s: &State, i: usize) -> DVec3 {
    let strand = p.strand_of[i];
    let carries = p.bdf2() && !s.sleeping[strand] && s.bdf2_ready[strand] && s.inverse_mass[i] > 0.0;
    let change = if carries { s.velocity[i] - s.velocity_before[i] } else { DVec3::ZERO };
    s.velocity[i] + change / 3.0
}

/// Change of the velocity of air particle `i` by the acceleration that was set \[m/s\].
#[must_use]
pub fn push_air(p: &Parameters, s: &State, i: usize) -> DVec3 {
    s.pushed.get(i).map_or(DVec3::ZERO, |a| p.step * *a)
}

/// Place wrap(x + Δt (v + ½ c)) of an air particle \[m\], and its velocity v + ⅓ c \[m/s\], by BDF2: v with the change
/// by external forces, c the change by pressure in the last step.
#[must_use]
pub fn advance(p: &Parameters, position: DVec3, velocity: DVec3, change: DVec3) -> (DVec3, DVec3) {
    (wrap(p, position + p.step * (velocity + 0.5 * change)), velocity + change / 3.0)
}

/// Place of an air particle x* = wrap(x + Δt v) \[m\]: air leaves the box through one face and enters through the
/// other.
#[must_use]
pub fn predict(p: &Parameters, position: DVec3, velocity: DVec3) -> DVec3 {
    wrap(p, position + p.step * velocity)
}

/// Position within \[0, box) that is `position` but for whole boxes \[m\].
#[must_use]
pub fn wrap(p: &Parameters, position: DVec3) -> DVec3 {
    position - p.box_size * (position / p.box_size).floor()
}

/// Part of the mean wind that has risen after `steps` steps, by the ramp.
#[must_use]
pub fn risen(p: &Parameters, steps: u64) -> f64 {
    if p.ramp > 0.0 { (steps as f64 * p.step / p.ramp).min(1.0) } else { 1.0 }
}

/// Mean wind after `steps` steps \[m/s\]: the part of U that has risen, and the gusts, linear between keyframes.
#[must_use]
pub fn mean_wind(p: &Parameters, steps: u64) -> DVec3 {
    let time = steps as f64 * p.step;
    let gust = match p.gust.iter().position(|(at, _)| *at > time) {
        Some(0) => p.gust[0].1,
        Some(next) => {
            let ((a, from), (b, to)) = (p.gust[next - 1], p.gust[next]);
            from.lerp(to, (time - a) / (b - a))
        }
        None => p.gust.last().map_or(DVec3::ZERO, |(_, last)| *last),
    };
    p.wind * risen(p, steps) + gust
}

/// Velocity that the wind brings in at `position` after `steps` steps \[m/s\]: the mean wind, and waves that it has
/// carried along.
fn brought(p: &Parameters, steps: u64, position: DVec3) -> DVec3 {
    let wind = mean_wind(p, steps + 1);
    let ends = |step| 0.5 * p.step * (mean_wind(p, step) + mean_wind(p, step + 1));
    let way: DVec3 = if p.inflow.is_empty() { DVec3::ZERO } else { (0..steps).map(ends).sum() };
    let eddy = |wave: &InflowWave| wave.amplitude * (wave.number.dot(position - way) + wave.phase).sin();
    wind + wind.length() * p.inflow.iter().map(eddy).sum::<DVec3>()
}

/// Depth of `position` behind the face that the wind enters through on an axis \[m\].
#[must_use]
pub fn depth(p: &Parameters, wind: DVec3, axis: usize, position: DVec3) -> f64 {
    if wind[axis] >= 0.0 { position[axis] } else { p.box_size[axis] - position[axis] }
}

/// Rate at which the fringe draws air at `position` to the wind U of step number `steps` \[1/s\]: 10 max(|U|, 0.3
/// m/s)/ℓ sin²(π x/ℓ) within the thickness ℓ of the face that U enters through; several faces count with the cosines of
/// U.
fn rate(p: &Parameters, steps: u64, position: DVec3) -> f64 {
    let wind = mean_wind(p, steps + 1);
    let speed = wind.length();
    let face = |axis: usize| {
        let depth = depth(p, wind, axis, position);
        let bump = if depth < p.fringe { (PI * depth / p.fringe).sin().powi(2) } else { 0.0 };
        wind[axis].abs() / speed * 10.0 * speed.max(0.3) / p.fringe * bump
    };
    if speed > 0.0 && p.fringe > 0.0 { (0..3).map(face).sum() } else { 0.0 }
}

/// Deficit of the air in the fringe to the wind \[m/s\]: the mean of U + u' less the air's velocity, weighted by the
/// rates, once the mean wind's change in step number `steps` is added to all air.
#[must_use]
pub fn fringe_deficit(p: &Parameters, steps: u64, positions: &[DVec3], velocities: &[DVec3]) -> DVec3 {
    let change = mean_wind(p, steps + 1) - mean_wind(p, steps);
    let (mut sum, mut all) = (DVec3::ZERO, 0.0);
    for (x, v) in positions.iter().zip(velocities) {
        let rate = rate(p, steps, *x);
        if rate > 0.0 && v.is_finite() {
            sum += rate * (brought(p, steps, *x) - *v - change);
            all += rate;
        }
    }
    if all > 0.0 { sum / all } else { DVec3::ZERO }
}

/// Deficit of all air to the wind of step number `steps` \[m/s\]: the fringe's deficit, along the wind.
#[must_use]
pub fn hold(p: &Parameters, steps: u64, fringe_deficit: DVec3) -> DVec3 {
    let wind = mean_wind(p, steps + 1);
    if wind.length() > 0.0 { fringe_deficit.project_onto(wind) } else { DVec3::ZERO }
}

/// Change that the wind makes in step number `steps` to air at `position` that moves with `velocity` \[m/s\].
///
/// The mean wind's change and the deficit are added first, then v += (1 − e^{−σΔt})(U + u' − v), with u' the turbulence
/// that the wind brings in and σ the rate of the fringe.
#[must_use]
pub fn fringe(p: &Parameters, steps: u64, wind_deficit: DVec3, position: DVec3, velocity: DVec3) -> DVec3 {
    let change = mean_wind(p, steps + 1) - mean_wind(p, steps) + wind_deficit;
    let left = (-rate(p, steps, position) * p.step).exp();
    if left < 1.0 { change + (1.0 - left) * (brought(p, steps, position) - velocity - change) } else { change }
}
