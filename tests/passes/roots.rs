//! roots: the host or keyframes move clamps.

use glam::{DQuat, DVec3, Quat, Vec3};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use windswept::internals::step;
use windswept_reference::{
    State as Twin, rods,
    step::{self as twin, Scratch},
};
use windswept_scene::{InitialState, Keyframe, Motion};
use windswept_shaders::common::rod::Root;

use crate::{
    rods::{ends, scene_of, strands},
    stage::{Stage, quaternion, xyz},
    support,
};

/// A vector of up to `size` on each axis, rounded to f32.
pub fn any(rng: &mut Pcg64, size: f64) -> DVec3 {
    (size * (2.0 * DVec3::from_array(rng.random()) - 1.0)).as_vec3().as_dvec3()
}

/// Where clamps go, on both; rounded to f32.
pub fn set_roots(stage: &Stage, s: &mut Twin, target: impl Fn(usize, DVec3, DQuat) -> (DVec3, DQuat)) {
    let targets = s.clamps.iter().enumerate().map(|(strand, (x, q))| {
        let (x, q) = target(strand, *x, *q);
        (x.as_vec3(), q.as_quat())
    });
    let targets: Vec<_> = targets.collect();
    let root = |(x, q): &(Vec3, Quat)| Root { position: x.to_array(), frame: q.to_array(), ..Root::default() };
    let rows: Vec<Root> = targets.iter().map(root).collect();
    stage.engine.write(&stage.engine.state().root_targets, &rows).unwrap();
    s.root_targets = targets.iter().map(|(x, q)| (x.as_dvec3(), q.as_dquat())).collect();
}

/// Largest differences of what clamps do: moves \[m\], frames; and how many strands go in another way.
pub fn drives_apart(stage: &Stage, w: &Scratch) -> (f64, f64, usize) {
    let got = stage.rod_strands();
    assert_eq!(got.len(), w.drives.len());
    let most = |gap: &dyn Fn(usize) -> f64| (0..got.len()).map(gap).fold(0.0, f64::max);
    let moves = most(&|k| (xyz(&got[k].root_travel) - w.drives[k].root_travel).length());
    let frames = most(&|k| (quaternion(got[k].root_frame) - w.drives[k].root_frame).length());
    let turns = most(&|k| (quaternion(got[k].root_turn) - w.drives[k].root_turn).length());
    let states = got.iter().zip(&w.drives).filter(|(a, b)| a.state != b.state as u32).count();
    (moves, frames.max(turns), states)
}

/// The host moves roots: some stay, some move and turn in this step or over three substeps, some only turn, some jump; free roots go
/// where they will, and strands that are held at both ends do not jump.
#[test]
fn roots_are_those_of_the_twin() {
    for n in support::SIZES {
        for (keys, substeps, steps) in [("", 1, 0), ("sleep = false", 1, 7), ("", 3, 0), ("", 3, 1), ("", 3, 3_000_002)]
        {
            let (mut scene, mut initial) = strands(n, keys);
            ends(&mut initial.hair, true);
            scene.time.substeps = substeps;
            let stage = Stage::new(&scene, &initial);
            let (p, mut s) = (&stage.parameters, stage.twin.clone());
            stage.adopt(&mut s);
            let mut rng = Pcg64::seed_from_u64(n as u64);
            let drawn: Vec<[DVec3; 2]> = (0..n).map(|_| [any(&mut rng, 1.0), any(&mut rng, 2.5)]).collect();
            set_roots(&stage, &mut s, |strand, x, q| {
                // Strands are 0.1 m long.
                let by = [0.0, 1e-6, 0.02, 0.0, 0.0999, 0.1001, 0.7][(strand + n) % 7];
                let turn = if (strand + n) % 7 == 0 { DVec3::ZERO } else { drawn[strand][1] };
                (x + by * drawn[strand][0].normalize(), DQuat::from_scaled_axis(turn) * q)
            });
            let mut status = stage.engine.status().unwrap();
            status.step = steps;
            stage.engine.set_status(&status).unwrap();
            s.steps = steps.into();
            stage.run_only(&["rods/roots"], step::drive::record);
            let w = twin::drive(&s, p);
            let (moves, frames, states) = drives_apart(&stage, &w);
            let count = |state| w.drives.iter().filter(|drive| drive.state == state).count();
            let counts = [rods::State::Free, rods::State::Asleep, rods::State::Teleported].map(count);
            println!("{n} strands, {keys:?}, substep {steps} of {substeps}: {moves:.1e} m, {frames:.1e}, {counts:?}");
            assert_eq!(states, 0, "{n}, {keys}: strands go another way");
            // Measured 3.6e-8 m and 4.7e-7; margin 4.
            assert!(moves < 1.5e-7 && frames < 2e-6, "{n}, {keys}: {moves} m, {frames}");
            assert!(n < 63 || counts.iter().filter(|count| **count > 0).count() == 2 + usize::from(p.sleep));
        }
    }
}

/// Keyframes move roots: before, between and after them, hours into a run, and from far away.
#[test]
fn roots_by_keyframes_are_those_of_the_twin() {
    for n in support::SIZES {
        let mut scene = scene_of(n, "");
        for (group, hair) in scene.hair.iter_mut().enumerate() {
            let start = [0.0, 0.004, 1.0, 3_600.0][group];
            let keyframe = |time, translation, rotation| Keyframe { time, translation, rotation };
            let keyframes = vec![
                keyframe(start, [0.0, 0.01, 0.0], [0.0, 0.3, 0.0]),
                keyframe(start + 0.004, [0.02, 0.01, 0.0], [1.0, 0.3, 0.2]),
                keyframe(start + 3.0, [0.0, -0.01, 0.0], [1.0, -0.3, 0.2]),
            ];
            hair.motion = Motion { keyframes };
        }
        let initial = InitialState::new(&scene).unwrap();
        let stage = Stage::new(&scene, &initial);
        let mut s = stage.twin.clone();
        stage.adopt(&mut s);
        // The engine's have the motion at the start taken out.
        s.root_targets.clone_from(&stage.twin.root_targets);
        for steps in [1, 3, 5, 500, 2_000_000, 2_608_696, 2_609_500] {
            let mut status = stage.engine.status().unwrap();
            status.step = steps;
            stage.engine.set_status(&status).unwrap();
            s.steps = steps.into();
            stage.run_only(&["rods/roots"], step::drive::record);
            let (moves, frames, states) = drives_apart(&stage, &twin::drive(&s, &stage.parameters));
            println!("{n} strands, step {steps}: {moves:.1e} m, {frames:.1e}, {states}");
            // Measured 1.2e-7 m and 1.9e-7; margin 4.
            assert!(moves < 5e-7 && frames < 8e-7, "{n}, step {steps}: {moves} m, {frames}");
            // Where the motion has come to rest rounding says whether the clamp still moves.
            let rests = |drive: &rods::Drive| drive.root_travel.length() < 1e-6;
            let w = twin::drive(&s, &stage.parameters);
            let got = stage.rod_strands();
            let strict = got.iter().zip(&w.drives).filter(|(_, drive)| !rests(drive));
            let (mut moving, mut other) = (0, 0);
            for (a, b) in strict {
                moving += 1;
                other += usize::from(a.state != b.state as u32);
            }
            assert_eq!(other, 0, "{n}, step {steps}: strands go another way");
            assert!(n < 63 || moving >= n / 4, "{n}, step {steps}: {moving} move");
        }
    }
}
