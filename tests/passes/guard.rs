//! hold, check, commit, commit_frames: ten whole steps against ten of the twin, heading by heading.

use glam::DVec3;
use windswept::step;
use windswept_reference::fluid;

use crate::{stage::Stage, support};

/// Ten steps of hair and air: engine and twin agree. If they do not, the first step and quantity that differ are named.
#[test]
fn ten_steps_are_those_of_the_twin() {
    let text = include_str!("../../examples/scenes/quick.toml");
    let sets = [
        "air.box.max=[0.12,0.06,0.06]",
        "hair.strands=12",
        "hair.length=0.06",
        "hair.points=7",
        "hair.roots.center=[0.04,0.03,0.03]",
        "hair.roots.radius=0.01",
        "air.fringe=0.03",
    ];
    let scene = windswept_scene::Scene::parse_with("quick.toml", text, &sets.map(str::to_owned)).unwrap();
    let initial = windswept_scene::InitialState::new(&scene).unwrap();
    let mut stage = Stage::new(&scene, &initial);
    println!("{} particles, {} of hair", stage.twin.position.len(), stage.parameters.hair_points);
    for number in 1..=10 {
        stage.run(step::record);
        windswept_reference::step::step(&mut stage.twin, &stage.parameters).unwrap();
        let (s, size) = (stage.engine.state(), stage.parameters.box_size);
        let positions = stage.vectors(&s.position);
        let gaps = positions.iter().zip(&stage.twin.position).enumerate().map(|(i, (a, b))| {
            let gap = *a - *b;
            if stage.parameters.is_air(i) { (gap - size * (gap / size).round()).length() } else { gap.length() }
        });
        let position = gaps.fold(0.0, f64::max);
        let difference = |a: Vec<glam::DVec3>, b: &[glam::DVec3]| {
            a.iter().zip(b).map(|(a, b)| (*a - *b).length()).fold(0.0, f64::max)
        };
        let velocity = difference(stage.vectors(&s.velocity), &stage.twin.velocity);
        let spin = difference(stage.vectors(&s.angular_velocity), &stage.twin.angular_velocity);
        let frames = stage
            .quaternions(&s.orientation)
            .iter()
            .zip(&stage.twin.orientation)
            .map(|(a, b)| (*a - *b).length())
            .fold(0.0, f64::max);
        println!(
            "step {number}: position {position:.1e} m, velocity {velocity:.1e} m/s, frames {frames:.1e}, spin {spin:.1e} 1/s"
        );
        let status = stage.engine.status().unwrap();
        assert_eq!(u64::from(status.step), stage.twin.steps);
        assert!((f64::from(status.max_stretch()) - stage.twin.max_stretch).abs() < 1e-4, "step {number}: stretch");
        // Measured at most 1.3e-7 m, 3.2e-5 m/s, 2e-6 and 1.1e-3 1/s; margin 5.
        for (what, error, bound) in [
            ("position", position, 6e-7),
            ("velocity", velocity, 1.6e-4),
            ("frames", frames, 1e-5),
            ("spin", spin, 6e-3),
        ] {
            assert!(error < bound, "step {number}: {what} differs by {error} (bound {bound})");
        }
    }
    let speed = stage.twin.velocity.iter().map(|v| v.x).sum::<f64>() / stage.twin.velocity.len() as f64;
    assert!(speed > 0.5, "the wind did not rise: {speed}");
}

/// Commit wraps air, leaves hair where it is, takes the velocities and counts the step.
#[test]
fn commit_wraps_air_and_counts_the_step() {
    for n in support::SIZES {
        let initial = support::particles(n, n / 3, support::Layout::Random, 8);
        let stage = Stage::new(&support::scene(), &initial);
        let (s, p) = (stage.engine.state(), &stage.parameters);
        let moved: Vec<DVec3> =
            stage.twin.position.iter().map(|x| (*x * 1.5 - 0.2 * p.box_size).as_vec3().as_dvec3()).collect();
        stage.write_vectors(&s.predicted, &moved);
        stage.write_vectors(&s.viscous_velocity, &stage.twin.position);
        stage.run(step::guard::record);
        for (i, (got, x)) in stage.vectors(&s.position).iter().zip(&moved).enumerate() {
            let wanted = if p.is_air(i) { fluid::wrap(p, *x) } else { *x };
            assert!((*got - wanted).length() < 1e-7, "{n} particles: {i} at {got}, expected {wanted}");
        }
        let velocity = stage.vectors(&s.velocity);
        assert!(velocity.iter().zip(&stage.twin.position).all(|(v, x)| *v == *x), "{n} particles: velocities");
        assert_eq!(stage.engine.status().unwrap().step, 1);
    }
}

/// A strand that got a velocity that is not finite ends the step at rest, is counted once and is flagged for its reset.
#[test]
fn hold_stills_strands_that_are_not_finite() {
    for n in support::SIZES.into_iter().filter(|n| *n >= 9) {
        let initial = support::particles(n, n / 3, support::Layout::Random, 9);
        let stage = Stage::new(&support::scene(), &initial);
        let (s, hair) = (stage.engine.state(), &stage.twin.hair);
        let victim = hair.len() / 2;
        let mut velocity = stage.twin.position.clone();
        velocity[hair.points(victim).end - 1].z = f64::INFINITY;
        stage.write_vectors(&s.predicted, &stage.twin.position);
        stage.write_vectors(&s.viscous_velocity, &velocity);
        stage.run(step::guard::record);
        for (i, (got, given)) in stage.vectors(&s.velocity).iter().zip(&velocity).enumerate() {
            let wanted = if hair.points(victim).contains(&i) { DVec3::ZERO } else { *given };
            assert_eq!(*got, wanted, "{n} particles: velocity of {i}");
        }
        let health: Vec<[u32; 2]> = stage.engine.read(&s.health).unwrap();
        for (strand, [committed, _]) in health.iter().enumerate() {
            assert_eq!(committed & 1, u32::from(strand == victim), "{n} particles: strand {strand}");
        }
        let status = stage.engine.status().unwrap();
        assert_eq!((status.step, status.counted[0]), (1, 1), "{n} particles");
    }
}
