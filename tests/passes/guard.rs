//! hold, check, commit, commit_frames.

use glam::DVec3;
use windswept::step;
use windswept_reference::fluid;

use crate::{stage::Stage, support};

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
        let health: Vec<[[u32; 4]; 2]> = stage.engine.read(&s.health).unwrap();
        for (strand, [[committed, ..], _]) in health.iter().enumerate() {
            assert_eq!(*committed, u32::from(strand == victim), "{n} particles: strand {strand}");
        }
        let status = stage.engine.status().unwrap();
        assert_eq!((status.step, status.counted[0]), (1, 1), "{n} particles");
    }
}
