//! Thresholds at which theory says that a strand gives way.

use std::f64::consts::TAU;

use glam::{DMat3, DQuat, DVec3};
use windswept::Simulation;
use windswept_scene::{End, Ends};
use windswept_validate::internals::{LENGTH, Rod, vectors};

use super::{awake, build, support};

/// A strand upright from its clamp.
const UP: [DVec3; 3] = [DVec3::X, DVec3::NEG_Z, DVec3::Y];
/// A strand that hangs from its clamp.
const DOWN: [DVec3; 3] = [DVec3::X, DVec3::Z, DVec3::NEG_Y];

/// Strands without rest curvature, one for each γ.
fn rods(gammas: [f64; 2], segments: usize, [d1, d2, d3]: [DVec3; 3]) -> [Rod; 2] {
    let root_frame = DQuat::from_mat3(&DMat3::from_cols(d1, d2, d3));
    gammas.map(|gamma| Rod { gamma, darboux: DVec3::ZERO, root_frame, segments })
}

/// Factor by which a measure of each of two strands changes from one look at them to another, so many steps later.
fn grows(simulation: &mut Simulation, steps: u64, measure: impl Fn(&[DVec3]) -> f64) -> [f64; 2] {
    let look = |simulation: &Simulation| {
        let hair = simulation.frame().unwrap().hair;
        let ends = |s: usize| hair.offsets[s] as usize..hair.offsets[s + 1] as usize;
        [0, 1].map(|s| measure(&vectors(&hair.positions[ends(s)])))
    };
    let before = look(simulation);
    simulation.step(steps).unwrap();
    let after = look(simulation);
    [after[0] / before[0], after[1] / before[1]]
}

/// An upright strand buckles under its weight at γ = 7.837 (64 segments).
#[test]
fn an_upright_strand_buckles_where_it_should() {
    let (scene, mut initial) = build(&rods([7.837 * 0.98, 7.837 * 1.02], 64, UP), 4e-3, awake(4.0));
    // A nudge of the first mode's kind.
    for (k, v) in initial.hair.velocities.iter_mut().enumerate() {
        v.x = 2e-4 * ((k % 65) as f64 / 64.0).powi(2);
    }
    let mut simulation = Simulation::with_state(&support::gpu(), &scene, initial).unwrap();
    simulation.step(1500).unwrap();
    let [below, above] = grows(&mut simulation, 1500, |x| (x[64].x - x[0].x).abs());
    println!("tip over 6 s: times {below:.3} at 0.98, times {above:.3} at 1.02 of the threshold");
    assert!(below < 1.0 && above > 1.0, "{below} {above}");
}

/// A hanging strand of natural curvature κL = 8 is planar above γ = 105.71 and three-dimensional below (EI/GJ = 1.38,
/// 100 segments).
#[test]
fn a_curved_strand_leaves_its_plane_where_it_should() {
    let segments = 100;
    let (scene, mut initial) = build(&rods([0.93 * 105.71, 1.02 * 105.71], segments, DOWN), 4e-3, awake(8.0));
    let turn = 8.0 / segments as f64;
    for (k, rest) in initial.hair.rest_rotation.iter_mut().enumerate() {
        *rest = DQuat::from_rotation_y(if k % segments == 0 { 0.5 * turn } else { turn });
    }
    let mut simulation = Simulation::with_state(&support::gpu(), &scene, initial).unwrap();
    simulation.step(1000).unwrap();
    let n = segments + 1;
    let nudge: Vec<DVec3> = (0..2 * n).map(|k| DVec3::Z * 1e-3 * ((k % n) as f64 / n as f64).powi(2)).collect();
    simulation.set_hair(None, Some(&nudge), None).unwrap();
    simulation.step(1500).unwrap();
    let far = |x: &[DVec3]| x.iter().map(|point| (point.z - x[0].z).abs()).fold(0.0, f64::max);
    let [below, above] = grows(&mut simulation, 1500, far);
    println!("out of plane over 6 s: times {below:.3} at 0.93, times {above:.3} at 1.02 of the threshold");
    assert!(below > 1.0 && above < 1.0, "{below} {above}");
}

/// A ring of a straight strand, clamped at both ends, leaves its plane at a twist of 2π√3 B/C.
#[test]
fn a_twisted_ring_leaves_its_plane_where_it_should() {
    let segments = 64;
    let ring = |twist: f64| {
        let rod = Rod::level(10.0, segments);
        let (mut scene, mut initial) = build(&[rod], 4e-3, awake(4.0));
        scene.gravity = [0.0; 3];
        let hair = &mut initial.hair;
        let (l, turn) = (LENGTH / segments as f64, TAU / segments as f64);
        // The ring lies in the plane of x and y, about z: at s the tangent has turned by 2 pi s, and the frame about it
        // by twist s.
        let frame = |s: f64| DQuat::from_rotation_z(TAU * s) * hair.root_frame[0] * DQuat::from_rotation_z(twist * s);
        let frames: Vec<DQuat> = (0..segments).map(|k| frame((k as f64 + 0.5) / segments as f64)).collect();
        let (end, root) = (frame(1.0), hair.positions[0]);
        let mut x = root;
        for k in 0..segments {
            hair.orientations[k] = frames[k];
            x += l * (frames[k] * DVec3::Z);
            hair.positions[k + 1] = x;
            hair.velocities[k].z = 2e-4 * (2.0 * turn * k as f64).sin();
            hair.rest_rotation[k] = DQuat::IDENTITY;
        }
        assert!((x - root).length() < 1e-9, "the ring is open: {}", x - root);
        hair.inverse_mass[segments] = 0.0;
        hair.velocities[0] = DVec3::ZERO;
        hair.ends = vec![Ends {
            root: End::Clamped,
            tip: End::Clamped,
            tip_frame: end,
            tip_rest_rotation: DQuat::IDENTITY,
            tip_compliance: hair.bend_compliance[0],
        }];
        // Past the threshold the ring leaves its plane, and comes to rest elsewhere (it may pass through itself).
        let mut simulation = Simulation::with_state(&support::gpu(), &scene, initial).unwrap();
        let mut farthest: f64 = 0.0;
        for _ in 0..100 {
            simulation.step(10).unwrap();
            let hair = simulation.frame().unwrap().hair;
            let out = hair.positions.iter().map(|x| f64::from(x[2] - hair.positions[0][2]).abs());
            farthest = out.fold(farthest, f64::max);
        }
        farthest
    };
    let threshold = TAU * 3.0_f64.sqrt() * 1.38;
    let (below, above) = (ring(0.95 * threshold), ring(1.05 * threshold));
    println!("out of plane: {below:.1e} m at 0.95, {above:.1e} m at 1.05 of the threshold");
    assert!(below < 1e-3 && above > 2e-2, "{below} {above}");
}
