//! Strands that sleep, wake and are reset, step after step.

use glam::{DQuat, DVec3};
use windswept::internals::step;
use windswept_reference::step::step as reference_step;
use windswept_scene::{InitialState, Keyframe, Motion, Rods, Shape};
use windswept_shaders::common::{
    rod::SLEEPS,
    status::{EULER_STEP, SLEEPING_STEP, STRAND_RESET, TELEPORT, UNSOLVED_STEP},
};

use crate::{
    fixture::{Fixture, condition},
    hair::{scene_of, set_roots},
};

/// Strands that are not finite when the fifth step begins.
const LOST: [usize; 3] = [1, 17, 40];

/// 26 steps of hair at rest without gravity: strands that are not finite are reset, most fall asleep, some are woken by
/// their root or a jump of it, some by a body that flies by. In the end those that jumped and turned sleep again, where
/// they were sent.
#[test]
fn strands_sleep_wake_and_are_reset_as_the_reference_s() {
    let mut scene = scene_of(65, &Rods::default());
    scene.gravity = [0.0; 3];
    scene.time.step = 8e-3;
    let initial = InitialState::new(&scene).unwrap();
    let tip = initial.hair.positions[initial.hair.points(30).end - 1].to_array();
    let leave = Keyframe { time: 18.5 * 8e-3, translation: [0.0; 3], rotation: [0.0; 3] };
    let left = Keyframe { time: 25.5 * 8e-3, translation: [0.0, -0.3, 0.0], ..leave };
    scene.bodies.push(windswept_scene::Body {
        name: "body".into(),
        shape: Shape::sphere([tip[0], tip[1] + 0.15, tip[2]], 0.02),
        friction: 0.4,
        motion: Motion::from(vec![leave, left]),
    });
    let fixture = Fixture::new(&scene, &initial);
    let mut s = fixture.reference.clone();
    // Clamps as the engine rounds them, so that they rest on both.
    let mut rounded = s.clone();
    fixture.adopt(&mut rounded);
    (s.clamps, s.root_targets) = (rounded.clamps, rounded.root_targets);
    let (mut met, mut furthest, mut slept) = ([0; 5], [[0.0_f64; 4]; 2], Vec::new());
    for number in 1..=26_u32 {
        if number == 5 {
            // Not finite from here on.
            for strand in LOST {
                s.velocity[s.hair.points(strand).end - 1].x = f64::NAN;
            }
            fixture.write_vectors(&fixture.engine.state().velocity, &s.velocity);
        }
        if number == 17 {
            set_roots(&fixture, &mut s, |strand, x, q| match strand % 8 {
                0 => (x + 2e-4 * DVec3::X, DQuat::from_rotation_y(0.03) * q),
                4 => (x + 0.5 * DVec3::Y, DQuat::from_rotation_z(0.7) * q),
                _ => (x, q),
            });
        }
        fixture.run(step::record);
        reference_step(&mut s, &fixture.parameters).unwrap();
        let status = fixture.engine.status().unwrap();
        let counters = [STRAND_RESET, EULER_STEP, SLEEPING_STEP, TELEPORT, UNSOLVED_STEP];
        let counted = counters.map(|counter| status.counted[counter as usize] as usize);
        let wanted = [s.resets, s.euler_steps, s.sleeping_steps, s.teleports, s.unsolved_steps];
        println!("step {number}: {wanted:?}");
        let health = fixture.health();
        for (strand, committed) in health.iter().enumerate() {
            let (mut got, mut wanted) = (*committed, condition(&s, strand));
            let anew = number >= 19 || number >= 17 && strand % 4 == 0 || number > 5 && LOST.contains(&strand);
            if anew && !s.sleeping[strand] {
                // Woken, or where positions were rounded anew, strands tremble by as much as one at rest may.
                (got.resting, wanted.resting) = (0, 0);
            }
            assert_eq!(got, wanted, "step {number}: strand {strand}");
        }
        // Rounding decides whether a strand that is thrown round settles in the last Newton step.
        let unsettled = counted[4].abs_diff(wanted[4]) <= usize::from(number >= 19);
        assert!(counted[..4] == wanted[..4] && unsettled, "step {number}: {counted:?} instead of {wanted:?}");
        let sleeping = s.sleeping.iter().filter(|sleeping| **sleeping).count();
        met[0] = s.resets;
        met[1] += usize::from(sleeping > 40);
        met[2] +=
            usize::from(number >= 19 && (0..65).any(|strand| strand % 4 > 0 && slept[strand] && !s.sleeping[strand]));
        if number == 16 {
            slept.clone_from(&s.sleeping);
        }
        met[3] += s.teleports;
        met[4] += usize::from(number > 17 && sleeping < 65);
        let hair = fixture.parameters.hair_points;
        let mut got = s.clone();
        fixture.adopt(&mut got);
        let most = |a: &[DVec3], b: &[DVec3]| a.iter().zip(b).map(|(a, b)| (*a - *b).length()).fold(0.0, f64::max);
        let lengths = most(&got.position[..hair], &s.position[..hair]).max(most(&got.displacement, &s.displacement));
        let speeds =
            most(&got.velocity[..hair], &s.velocity[..hair]).max(most(&got.velocity_before, &s.velocity_before));
        let turns = most(&got.turn, &s.turn);
        let spins = most(&got.angular_velocity, &s.angular_velocity);
        let spins = spins.max(most(&got.angular_velocity_before, &s.angular_velocity_before));
        println!("  {lengths:.1e} m, {speeds:.1e} m/s, {turns:.1e}, {spins:.1e} 1/s");
        for (most, apart) in furthest[usize::from(number >= 19)].iter_mut().zip([lengths, speeds, turns, spins]) {
            *most = most.max(apart);
        }
    }
    println!("{furthest:?} from the reference, before the body comes and from then on");
    // Measured 2.5e-7 m, 9.5e-6 m/s, 2.1e-6 and 4.0e-4 1/s, and, as strands are thrown round, 3.5e-7 m, 4.1e-5 m/s,
    // 3.3e-5 and 5.5e-3 1/s; margin 4.
    let bounds = [[1e-6, 4e-5, 8.5e-6, 1.6e-3], [1.4e-6, 1.7e-4, 1.4e-4, 2.2e-2]];
    let within = furthest.as_flattened().iter().zip(bounds.as_flattened()).all(|(apart, bound)| apart < bound);
    assert!(within, "{furthest:?}");
    for _ in 0..20 {
        fixture.run(step::record);
        reference_step(&mut s, &fixture.parameters).unwrap();
    }
    let sent = |strand: &usize| strand % 8 == 4 && slept[*strand];
    let sleeps = |strand: usize, resting: u32| resting == SLEEPS && s.sleeping[strand];
    let awake = fixture.health().iter().enumerate().filter(|(s, h)| sent(s) && !sleeps(*s, h.resting)).count();
    assert_eq!(awake, 0, "strands that were teleported do not sleep");
    assert!(met.iter().all(|times| *times > 0), "{met:?}");
}
