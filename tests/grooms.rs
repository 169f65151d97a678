//! Strands of the caller's own on an adapter: flat fibres, and ends that are held in every way.

use std::f64::consts::PI;

use glam::{DQuat, DVec3};
use windswept::Simulation;
use windswept_scene::{End, Fibre, Groom, Integrator, Moduli, RestShape, Rods, Scene, Stiffness};
use windswept_validate::internals::GRAVITY;

use crate::support;

fn scene(step: f64, rods: Rods) -> Scene {
    Scene { gravity: [0.0, -GRAVITY, 0.0], rods, ..support::alone(step, []) }
}

/// Strands that are damped by 8/s.
fn damped() -> Rods {
    Rods { damping: 8.0, ..Rods::default() }
}

/// Groom of `strands` level strands of 17 points along +x, a metre apart.
fn level(strands: u32, length: f64) -> Groom {
    let point = |i: u32| [length * f64::from(i % 17) / 16.0, 0.0, f64::from(i / 17)];
    Groom::new((0..17 * strands).map(point).collect(), (0..=strands).map(|s| 17 * s).collect())
}

/// Position of every point after `seconds` in steps of `step` \[m\].
fn after(step: f64, rods: Rods, groom: &Groom, seconds: f64) -> Vec<DVec3> {
    let mut simulation = Simulation::with_groom(&support::gpu(), &scene(step, rods), groom).unwrap();
    simulation.step((seconds / simulation.dt()) as u64).unwrap();
    let frame = simulation.frame().unwrap();
    frame.hair.positions.iter().map(|x| DVec3::from_array(x.map(f64::from))).collect()
}

/// A flat fibre sags by q L⁴/(8 EI) about either axis (Euler and Bernoulli), 1/aspect² as far about d2.
#[test]
fn flat_fibres_sag_by_their_stiffness_about_either_axis() {
    let (length, a, aspect) = (0.02_f64, 4e-5_f64, 0.5);
    // Default: d1 along +z, so that weight turns the strand about d1; a quarter turn about d3 puts d2 there.
    let upright = DQuat::from_mat3(&glam::DMat3::from_cols(DVec3::Z, DVec3::NEG_Y, DVec3::X));
    let flat = upright * DQuat::from_rotation_z(0.5 * PI);
    let groom = Groom {
        fibre: Fibre { aspect, ..Fibre::default() }.into(),
        root_frame: Some(vec![upright.to_array(), flat.to_array()].into()),
        ..level(2, length)
    };
    let tips = after(4e-3, damped(), &groom, 4.0);
    let sag = [-tips[16].y, -tips[33].y];
    let weight = 1320.0 * PI * a * a * aspect * GRAVITY;
    let moments = [PI * a.powi(4) * aspect / 4.0, PI * a.powi(4) * aspect.powi(3) / 4.0];
    for (sag, moment) in sag.iter().zip(moments) {
        let expected = weight * length.powi(4) / (8.0 * 4e9 * moment);
        println!("sag {sag:.4e} m, expected {expected:.4e}");
        // Measured 0.36 % and 0.31 %, the discretisation itself; margin 3.
        assert!((sag / expected - 1.0).abs() < 0.01, "{sag}, expected {expected}");
    }
    // Measured 5e-4, f32.
    assert!((sag[1] / sag[0] * aspect * aspect - 1.0).abs() < 0.005, "{sag:?}");
}

/// Clamped and pinned ends stay; a strand pinned at one end hangs from it; one clamped at its tip sags as one clamped
/// at its root; a free one falls, and keeps its shape.
#[test]
fn ends_are_held_as_they_say() {
    let length = 0.02;
    let (clamped, pinned, free) = (End::Clamped, End::Pinned, End::Free);
    let ends = [(clamped, free), (free, clamped), (pinned, free), (free, pinned), (pinned, pinned), (clamped, clamped)];
    let groom = Groom {
        root: ends.iter().map(|ends| ends.0).collect::<Vec<_>>().into(),
        tip: ends.iter().map(|ends| ends.1).collect::<Vec<_>>().into(),
        ..level(ends.len() as u32, length)
    };
    let rest = after(4e-3, damped(), &groom, 4.0);
    let strand = |s: usize| &rest[17 * s..17 * s + 17];
    let start = |s: usize, k: usize| DVec3::from_array(groom.points[17 * s + k]);
    for (s, (root, tip)) in ends.into_iter().enumerate() {
        for (end, k) in [(root, 0), (tip, 16)] {
            let moved = strand(s)[k].distance(start(s, k));
            // Held ends do not move at all; f32 of where it stands at most.
            assert!((end == free) == (moved > 1e-6), "strand {s}, point {k}, {end:?}: moved {moved} m");
        }
    }
    let sag = |s: usize, k: usize| (start(s, k) - strand(s)[k]).y;
    println!("clamped {:.3e}, at the tip {:.3e}", sag(0, 16), sag(1, 0));
    // Measured 6e-4 to 1.1e-3 of 0.16 mm, by the order in which the solver adds: each joint turns by 5e-4 rad, of which
    // f32 frames round 1e-4 off. The margin is 3.
    assert!((sag(1, 0) / sag(0, 16) - 1.0).abs() < 3e-3);
    for (s, held, hanging) in [(2, 0, 16), (3, 16, 0)] {
        let below = start(s, held) - DVec3::Y * length;
        // Measured 7e-8 m.
        println!("hangs {:.1e} m off", strand(s)[hanging].distance(below));
        assert!(strand(s)[hanging].distance(below) < 1e-3 * length, "strand {s}: {}", strand(s)[hanging]);
    }
    // A strand sags by q L⁴/(384 EI) between clamps and by five times that between pins, less the pull of its ends,
    // which cannot come closer.
    let expected = sag(0, 16) * 8.0 / 384.0;
    println!("between clamps {:.3e}, expected {expected:.3e}; between pins {:.3e}", sag(5, 8), sag(4, 8));
    // Measured 2.7 %, the discretisation of 16 segments; 4.29 times.
    assert!((sag(5, 8) / expected - 1.0).abs() < 0.05);
    assert!((4.0..5.0).contains(&(sag(4, 8) / sag(5, 8))));
}

/// Strands of few points, whose segments are long, hang as they are given for 10 s, awake or not, at any stiffness at
/// which they can.
#[test]
fn strands_of_few_points_hang_still() {
    let length = 0.1;
    let (mut points, mut offsets, mut fibres) = (Vec::new(), vec![0], Vec::new());
    for (n, youngs_modulus) in [(3, 4e9), (3, 6e9), (3, 1e11), (4, 4e9), (4, 1e11), (2, 1e11), (6, 4e9)] {
        let mut x = DVec3::new(0.0, 0.0, 0.02 * fibres.len() as f64);
        points.push(x.to_array());
        for k in 1..n {
            let angle = 0.45 * PI * f64::from(k) / f64::from(n);
            x += length / f64::from(n - 1) * DVec3::new(angle.cos(), -angle.sin(), 0.0);
            points.push(x.to_array());
        }
        offsets.push(points.len() as u32);
        let stiffness = Stiffness::Moduli(Moduli { youngs_modulus, ..Moduli::default() });
        fibres.push(Fibre { stiffness, ..Fibre::default() });
    }
    let groom = Groom { fibre: fibres.into(), rest: RestShape::Hanging, ..Groom::new(points, offsets) };
    for sleep in [true, false] {
        let scene = scene(1.38e-3, Rods { sleep, ..Rods::default() });
        let mut simulation = Simulation::with_groom(&support::gpu(), &scene, &groom).unwrap();
        assert!(simulation.initial().warnings.is_empty(), "{:?}", simulation.initial().warnings);
        let mut farthest = vec![0.0_f64; groom.len()];
        for _ in 0..73 {
            simulation.step(100).unwrap();
            let now = simulation.frame().unwrap().hair.positions;
            for (s, ends) in groom.offsets.windows(2).enumerate() {
                let range = ends[0] as usize..ends[1] as usize;
                for (x, start) in now[range.clone()].iter().zip(&groom.points[range]) {
                    let way = DVec3::from_array(x.map(f64::from)).distance(DVec3::from_array(*start));
                    farthest[s] = farthest[s].max(way / length);
                }
            }
        }
        println!("sleep {sleep}: {farthest:?} L");
        // Measured 1.5e-7 and, awake, 4.1e-6; it was 1.9e-4 with sleep when spins were those between rounded frames.
        assert!(farthest.iter().all(|way| *way < 2e-5), "sleep {sleep}: {farthest:?} L");
    }
}

/// A strand that is held at its tip as well hangs as it is given, whatever the angles of its joints.
#[test]
fn strands_that_are_held_at_both_ends_hang_still() {
    let length = 0.1;
    let tips = [End::Free, End::Pinned, End::Clamped];
    let arc = |k: u32| 0.3 * PI * f64::from(k % 17) / 16.0;
    let point = |k: u32| [length * arc(k).sin(), length * (arc(k).cos() - 1.0), 0.02 * f64::from(k / 17)];
    let offsets: Vec<u32> = (0..=tips.len() as u32).map(|s| 17 * s).collect();
    let points: Vec<_> = (0..17 * tips.len() as u32).map(point).collect();
    let groom =
        Groom { tip: tips.to_vec().into(), rest: RestShape::Hanging, ..Groom::new(points.clone(), offsets.clone()) };
    let farthest = |groom: &Groom| {
        let moved = after(1.38e-3, Rods { sleep: false, ..Rods::default() }, groom, 3.0);
        let ways = moved.iter().zip(&points).map(|(x, start)| x.distance(DVec3::from_array(*start)) / length);
        ways.collect::<Vec<_>>().chunks(17).map(|ways| ways.iter().copied().fold(0.0, f64::max)).collect::<Vec<_>>()
    };
    let (hangs, sags) = (farthest(&groom), farthest(&Groom { rest: RestShape::Weightless, ..groom.clone() }));
    println!("as it hangs {hangs:?} L, from the shape at rest {sags:?} L");
    // Measured 1.6e-7; and 0.44, 7.4e-4 and 5.0e-4.
    assert!(hangs.iter().all(|way| *way < 1e-6), "{hangs:?} L");
    assert!(sags.iter().all(|way| *way > 3e-4), "{sags:?} L");
}

/// Asserts that a strand has fallen by ½ g t², and that the distances between its points have stayed.
#[test]
fn strands_that_nothing_holds_fall() {
    let groom = Groom { root: End::Free.into(), ..level(2, 0.05) };
    let step = 1.38e-3;
    for integrator in [Integrator::Bdf2, Integrator::Euler] {
        let fallen = after(step, Rods { integrator: Some(integrator), ..Rods::default() }, &groom, 0.2);
        let time = (0.2_f64 / step).floor() * step;
        let drop = 0.5 * GRAVITY * time * time;
        for (x, start) in fallen.iter().zip(&groom.points) {
            let way = *x - DVec3::from_array(*start);
            println!("{integrator:?}: {:.3e} of {drop:.3e}", way.y + drop);
            assert!(way.distance(DVec3::NEG_Y * drop) < 0.01 * drop, "{integrator:?}: {way}");
        }
    }
}
