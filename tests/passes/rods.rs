//! predict, turn, gauss_seidel, finish; reset is in `simulation.rs`.

use glam::{DQuat, DVec3};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use windswept::{status, step};
use windswept_reference::rods;
use windswept_scene::{InitialState, Model, Scene, Strands};

use crate::stage::{Stage, relative};

/// `n` strands of 2 to 40 points, some curled, in random places, alone.
fn strands(n: usize) -> (Scene, InitialState) {
    let mut text = String::from(
        "interaction = { model = \"none\" }\n[time]\nstep = 1.38e-3\nduration = 1.0\n[rods]\niterations = 10\ndamping = 2.0\n",
    );
    for (group, (points, curl)) in
        [(2, ""), (11, "curl = { radius = 0.003, pitch = 0.02 }"), (40, ""), (7, "taper = 0.5")].into_iter().enumerate()
    {
        let share = (n + 3 - group) / 4;
        if share > 0 {
            text += &format!(
                "[[hair]]\nname = \"g{group}\"\nstrands = {share}\npoints = {points}\nlength = 0.1\n{curl}\nroots = {{ center = [0.0, 0.1, {group}.0], radius = 0.05, direction = [1.0, 0.3, 0.2] }}\n"
            );
        }
    }
    let mut scene = Scene::parse(&text).unwrap();
    scene.model = Model::None;
    let initial = InitialState::new(&scene).unwrap();
    (scene, initial)
}

/// Moves points by up to a millimetre and turns frames by up to a twentieth of a radian.
fn shaken(hair: &Strands, positions: &[DVec3]) -> (Vec<DVec3>, Vec<DQuat>) {
    let mut rng = Pcg64::seed_from_u64(21);
    let mut shake = |size: f64| size * (2.0 * DVec3::from_array(rng.random()) - 1.0);
    let x = positions
        .iter()
        .zip(&hair.inverse_mass)
        .map(|(x, w)| if *w > 0.0 { (*x + shake(1e-3)).as_vec3().as_dvec3() } else { *x })
        .collect();
    let q = hair.orientations.iter().map(|q| rods::turned(*q, shake(0.05)).as_quat().as_dquat()).collect();
    (x, q)
}

const SIZES: [usize; 5] = [1, 63, 64, 65, 700];

#[test]
fn predict_and_turn_are_free_and_damped() {
    for n in SIZES {
        let (scene, initial) = strands(n);
        let stage = Stage::new(&scene, &initial);
        let (s, p) = (stage.engine.state(), &stage.parameters);
        let mut rng = Pcg64::seed_from_u64(3);
        // Fast enough that some moves are capped: 3 mm or a segment in 1.38 ms.
        let v: Vec<DVec3> =
            (0..p.hair_points).map(|_| (8.0 * DVec3::from_array(rng.random()) - 4.0).as_vec3().as_dvec3()).collect();
        let w: Vec<DVec3> = initial
            .hair
            .orientations
            .iter()
            .map(|_| (200.0 * DVec3::from_array(rng.random()) - 100.0).as_vec3().as_dvec3())
            .collect();
        stage.write_vectors(&s.velocity, &v);
        stage.write_vectors(&s.angular_velocity, &w);
        stage.run(step::drive::record);
        let largest = rods::largest_moves(&initial.hair);
        let moved = |i: usize| rods::predict(p, initial.hair.inverse_mass[i], stage.twin.position[i], v[i], largest[i]);
        let wanted: Vec<_> = (0..p.hair_points).map(moved).collect();
        let positions: Vec<DVec3> = wanted.iter().map(|(x, _)| *x).collect();
        let error = relative(&stage.vectors(&s.predicted), &positions, 1e-3);
        let capped = wanted.iter().filter(|(_, capped)| *capped).count() as u32;
        let counted = stage.engine.status().unwrap().counting[1];
        println!("{n} strands: positions {error:.1e}, {capped} capped");
        assert!(error < 2e-7, "{n} strands: {error}");
        assert_eq!(counted, capped, "{n} strands: capped");
        let frames: Vec<DQuat> = initial.hair.orientations.iter().zip(&w).map(|(q, w)| rods::turn(p, *q, *w)).collect();
        let worst = stage
            .quaternions(&s.predicted_orientation)
            .iter()
            .zip(&frames)
            .map(|(a, b)| (*a - *b).length())
            .fold(0.0, f64::max);
        assert!(worst < 5e-7, "{n} strands: frames {worst}");
    }
}

#[test]
fn gauss_seidel_is_that_of_the_twin() {
    for n in SIZES {
        for iterations in [1, 10] {
            let (mut scene, initial) = strands(n);
            scene.rods.iterations = iterations;
            let stage = Stage::new(&scene, &initial);
            let (s, p, hair) = (stage.engine.state(), &stage.parameters, &stage.twin.hair);
            let (mut x, mut q) = shaken(hair, &stage.twin.position);
            stage.write_vectors(&s.predicted, &x);
            let frames: Vec<[f32; 4]> = q.iter().map(|q| q.as_quat().to_array()).collect();
            stage.engine.write(&s.predicted_orientation, &frames).unwrap();
            stage.run(step::rods::record);
            rods::gauss_seidel(p, hair, &mut x, &mut q);
            let errors =
                stage.vectors(&s.predicted).iter().zip(&x).map(|(a, b)| (*a - *b).length()).fold(0.0, f64::max);
            let turns = stage
                .quaternions(&s.predicted_orientation)
                .iter()
                .zip(&q)
                .map(|(a, b)| (*a - *b).length())
                .fold(0.0, f64::max);
            println!("{n} strands, {iterations} sweeps: positions {errors:.1e} m, frames {turns:.1e}");
            // Measured at most 3.8e-7 m of moves of 1e-3 m, and 1.3e-5; margin 4.
            assert!(errors < 1.5e-6 && turns < 6e-5, "{n} strands: {errors} m, {turns}");
        }
    }
}

/// A strand at its rest shape stays there, straight or curled, whatever the sweeps.
#[test]
fn rods_at_rest_stay_at_rest() {
    let (mut scene, initial) = strands(65);
    scene.gravity = [0.0; 3];
    let stage = Stage::new(&scene, &initial);
    for _ in 0..20 {
        stage.run(step::record);
    }
    let moved = stage
        .vectors(&stage.engine.state().position)
        .iter()
        .zip(&stage.twin.position)
        .map(|(a, b)| (*a - *b).length())
        .fold(0.0, f64::max);
    println!("moved {moved:.1e} m in 20 steps");
    // Positions of up to 3 m are good to 2.4e-7 m in f32, and every step rounds them: measured 7e-7; margin 4.
    assert!(moved < 3e-6, "{moved}");
}

#[test]
fn finish_measures_stretch_and_finds_bad_strands() {
    for n in SIZES {
        let (scene, initial) = strands(n);
        let stage = Stage::new(&scene, &initial);
        let (s, hair) = (stage.engine.state(), &stage.twin.hair);
        let (mut x, q) = shaken(hair, &stage.twin.position);
        let victim = n / 2;
        x[hair.points(victim).end - 1].y = f64::NAN;
        stage.write_vectors(&s.predicted, &x);
        let frames: Vec<[f32; 4]> = q.iter().map(|q| q.as_quat().to_array()).collect();
        stage.engine.write(&s.predicted_orientation, &frames).unwrap();
        stage.run(|r, s, plan| {
            r.run(
                &windswept_shaders::rods::FINISH,
                "health",
                plan.sizes.strands,
                &[
                    &s.params,
                    &s.status,
                    &s.strands,
                    &s.segments,
                    &s.position,
                    &s.orientation,
                    &s.predicted,
                    &s.predicted_orientation,
                    &s.health,
                ],
            );
        });
        let stretches: Vec<Option<f64>> = (0..n).map(|strand| rods::finish(hair, strand, &x, &q)).collect();
        let wanted = stretches.iter().flatten().copied().fold(0.0, f64::max);
        let got = stage.engine.status().unwrap();
        assert_eq!(stretches.iter().filter(|stretch| stretch.is_none()).count(), 1);
        assert!((f64::from(got.max_stretch()) - wanted).abs() < 1e-4, "{n}: {} instead of {wanted}", got.max_stretch());
        assert_eq!((got.bad_strands, got.first_bad_strand, got.counting[0]), (1, victim as u32, 1));
        let health: Vec<[u32; 2]> = stage.engine.read(&s.health).unwrap();
        // Found in this step, not committed yet.
        for (strand, [committed, found]) in health.iter().enumerate() {
            assert_eq!((committed & 1, found & 1), (0, u32::from(strand == victim)), "{n}: strand {strand}");
        }
        let held = stage.vectors(&s.predicted)[hair.points(victim)].to_vec();
        assert!(relative(&held, &stage.twin.position[hair.points(victim)], 1e-3) < 1e-6, "{n}: not held");
        assert_eq!(status::COUNTERS[0], "strand_reset");
    }
}
