//! Bodies that are dragged.

use std::collections::BTreeMap;

use glam::{DQuat, DVec3};
use windswept::{Pose, RunError, Simulation};

/// Time in which most of the way to the pointer is made \[s\].
const LAG: f64 = 0.03;
/// Fastest that a body is dragged \[m/s\] and turned \[rad/s\]: as a person moves a head. A pointer may jump.
const FASTEST: [f64; 2] = [2.0, 12.0];
/// Distances to a pose that are arrivals \[m\], \[rad\].
const THERE: [f64; 2] = [1e-6, 1e-5];

/// Moves bodies through the next step toward the poses that they are dragged to, and forgets those that are there.
///
/// # Errors
/// [`RunError`] as [`Simulation::set_body`].
pub(crate) fn toward(simulation: &mut Simulation, drags: &mut BTreeMap<String, Pose>) -> Result<(), RunError> {
    let (time, step) = (simulation.time(), simulation.dt());
    let mut arrived = Vec::new();
    for (name, goal) in drags.iter() {
        let Some(body) = simulation.scene().bodies.iter().find(|body| body.name == *name) else {
            arrived.push(name.clone());
            continue;
        };
        let (pose, there) = after(&body.motion.at(time), goal, step);
        simulation.set_body(name, pose, None)?;
        if there {
            arrived.push(name.clone());
        }
    }
    drags.retain(|name, _| !arrived.contains(name));
    Ok(())
}

/// The pose after a step of `step` \[s\] toward another, and whether it is that one.
fn after(now: &Pose, goal: &Pose, step: f64) -> (Pose, bool) {
    let way = goal.translation - now.translation;
    let goal_rotation = if now.rotation.dot(goal.rotation) < 0.0 { -goal.rotation } else { goal.rotation };
    let turn = (goal_rotation * now.rotation.conjugate()).to_scaled_axis();
    let there = way.length() < THERE[0] && turn.length() < THERE[1];
    if there {
        return (*goal, true);
    }
    let moved = now.translation + limited(way, FASTEST[0], step);
    let turned = DQuat::from_scaled_axis(limited(turn, FASTEST[1], step)) * now.rotation;
    (Pose { translation: moved, rotation: turned.normalize() }, false)
}

/// The part of a way that is made in a step: evenly less the nearer its end, and never faster than `fastest`.
fn limited(way: DVec3, fastest: f64, step: f64) -> DVec3 {
    ((step / LAG).min(1.0) * way).clamp_length_max(fastest * step)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// However far the pointer jumps, a body comes to it no faster than a person moves it, and arrives exactly.
    #[test]
    fn a_drag_is_slow_and_arrives() {
        let step = 1.38e-3;
        let goal = Pose { translation: DVec3::new(0.3, -0.1, 0.2), rotation: DQuat::from_rotation_y(2.0) };
        let mut now = Pose { translation: DVec3::ZERO, rotation: DQuat::from_rotation_x(0.4) };
        for steps in 1..2000 {
            let (next, there) = after(&now, &goal, step);
            let speed = next.translation.distance(now.translation) / step;
            let turn = next.rotation.angle_between(now.rotation) / step;
            assert!(speed < 1.001 * FASTEST[0] && turn < 1.001 * FASTEST[1], "{speed} m/s, {turn} rad/s");
            now = next;
            if there {
                assert_eq!((now, steps > 100), (goal, true));
                return;
            }
        }
        panic!("it is at {now:?}");
    }
}
