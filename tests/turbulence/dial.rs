//! Scale and intensity are dials: how large eddies grow, and at which speed they stop; and with the wind enter such
//! eddies.

use std::f64::consts::{E, TAU};

use glam::{DMat3, DVec3};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use windswept::Simulation;
use windswept_scene::{Air, Band, Filter, InitialState, Scene, Time, Turbulence};
use windswept_validate::internals::SIMPLE;

use super::{
    air_scene,
    support::{self, VOLUME, lattice},
};

/// Bands: scale \[m\] and strength.
const BANDS: [(f64, f64); 3] = [(0.006, 5.0), (0.009, 5.0), (0.018, 7.0)];
/// Steps after which the bands are looked at: all of them have stopped growing.
const STEPS: u64 = 300;
/// Speed U of the law \[m/s\].
const SPEED: f64 = 3.0;
/// Intensity I of the law.
const INTENSITY: f64 = 0.1;
/// Energy of each band at the start \[m²/s²\].
const ENERGY: f64 = 1e-4;

/// Still air in a box of 17 particle spacings, 82 mm, which holds 1, 2 and 3 waves of the bands' centres along an axis:
/// for each band six such waves across one another, as strong as gives each band the same energy.
fn stirred() -> InitialState {
    let mut rng = Pcg64::seed_from_u64(11);
    let mut air = lattice([17; 3], SIMPLE);
    let (size, jitter) = (air.air.size.x, 0.1 * VOLUME.cbrt());
    for x in &mut air.air.positions {
        *x = (*x + jitter * (2.0 * DVec3::from_array(rng.random()) - 1.0)).rem_euclid(DVec3::splat(size));
    }
    // A band sees its neighbours' waves with the square of its gain for them.
    let numbers = [3.0, 2.0, 1.0].map(|periods| TAU * periods / size);
    let seen = |k: f64| {
        DVec3::from_array(BANDS.map(|(s, _)| (0.5 * E * (k * s).powi(2) * (-0.5 * (k * s).powi(2)).exp()).powi(2)))
    };
    let energies =
        DMat3::from_cols(seen(numbers[0]), seen(numbers[1]), seen(numbers[2])).inverse() * DVec3::splat(ENERGY);
    let mut waves = Vec::new();
    for (number, energy) in numbers.into_iter().zip(energies.to_array()) {
        // Waves of amplitude a have energy a²/4 each.
        let amplitude = (4.0 * energy / 6.0).sqrt();
        for (along, across) in [(0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1)] {
            waves.push((number * DVec3::AXES[along], amplitude * DVec3::AXES[across], rng.random_range(0.0..TAU)));
        }
    }
    let velocity = |x: &DVec3| waves.iter().map(|(k, a, phase)| *a * (k.dot(*x) + phase).sin()).sum();
    air.air.velocities = air.air.positions.iter().map(velocity).collect();
    air
}

/// Air after a run in which one band is strengthened: energies of all three \[m²/s²\].
fn strengthened(scale: f64, strength: f64) -> [f64; 3] {
    let mut scene = air_scene();
    scene.turbulence.filter = Some(Filter::default());
    scene.turbulence.speed = Some(SPEED);
    scene.turbulence.bands = vec![Band { scale, strength, intensity: INTENSITY }];
    let mut simulation = Simulation::with_state(&support::gpu(), &scene, stirred()).unwrap();
    let energies = |simulation: &Simulation| -> [f64; 3] {
        simulation.spectrum(&BANDS.map(|(scale, _)| scale)).unwrap().try_into().unwrap()
    };
    let start = energies(&simulation);
    assert!(start.iter().all(|e| (e / ENERGY - 1.0).abs() < 0.03), "{start:?}");
    simulation.step(STEPS).unwrap();
    energies(&simulation)
}

/// Each band, strengthened alone, ends within a third of ½ (I U)²; eddies of twice its scale or more have at most a
/// quarter of its energy, so that large eddies grow only where a large scale asks for them.
#[test]
#[ignore = "long: more than 60 s of CPU time"]
fn the_scale_says_how_large_eddies_grow() {
    let limit = 0.5 * (INTENSITY * SPEED).powi(2);
    let ends = BANDS.map(|(scale, strength)| strengthened(scale, strength));
    for (b, ((scale, _), end)) in BANDS.into_iter().zip(ends).enumerate() {
        println!("s = {} mm: {end:.4?} m²/s², {:.2} of the limit", 1e3 * scale, end[b] / limit);
        // Measured 0.94, 0.87 and 1.05 of the limit.
        assert!((2.0 / 3.0..4.0 / 3.0).contains(&(end[b] / limit)), "s = {scale}: {} of {limit}", end[b]);
        for (k, (larger, _)) in BANDS.into_iter().enumerate().filter(|(_, (other, _))| *other >= 2.0 * scale) {
            // Measured 0.16 (6 mm) and 0.19 (9 mm) of its own; 0.14 and 0.16 of the 18 mm that are strengthened
            // themselves.
            assert!(end[k] < 0.25 * end[b] && end[k] < 0.25 * ends[k][k], "s = {scale}, {larger}: {end:?}");
        }
    }
}

/// Rms speed of the band over I U in a box of eddies, mean of the second half of 200 steps that begin with a tenth of
/// it.
fn held(scale: f64, intensity: f64, substeps: u32) -> f64 {
    let mut scene = air_scene();
    scene.turbulence.filter = Some(Filter::default());
    scene.turbulence.speed = Some(SPEED);
    scene.time.substeps = substeps;
    scene.turbulence.bands = vec![Band { scale, strength: Band::STRENGTH, intensity }];
    let mut initial = stirred();
    let size = initial.air.size.x;
    let mut rng = Pcg64::seed_from_u64(1);
    let mut waves = Vec::new();
    while waves.len() < 40 {
        let number = TAU / size * DVec3::from_array(std::array::from_fn(|_| f64::from(rng.random_range(-3..=3))));
        let across = number.cross(DVec3::from_array(rng.random()) - 0.5).normalize_or_zero();
        if across != DVec3::ZERO {
            waves.push((number, across, rng.random_range(0.0..TAU)));
        }
    }
    let amplitude = 0.1 * intensity * SPEED * (2.0 / waves.len() as f64).sqrt();
    let velocity = |x: &DVec3| waves.iter().map(|(k, a, phase)| amplitude * *a * (k.dot(*x) + phase).sin()).sum();
    initial.air.velocities = initial.air.positions.iter().map(velocity).collect();
    let mut simulation = Simulation::with_state(&support::gpu(), &scene, initial).unwrap();
    simulation.step(100).unwrap();
    let speeds = (0..4).map(|_| {
        simulation.step(25).unwrap();
        (2.0 * simulation.spectrum(&[scale]).unwrap()[0]).sqrt() / (intensity * SPEED)
    });
    speeds.sum::<f64>() / 4.0
}

/// Eddies come to the speed I U where a substep takes them less than a tenth of their wavelength: within 10 % at 6, 9
/// and 12 mm. The box holds one wave of 18 mm, whose energy comes and goes by a fifth.
#[test]
#[ignore = "long: five minutes of CPU time"]
fn eddies_have_the_intensity_asked_for() {
    for (scale, bound) in [(0.006, 0.11), (0.009, 0.11), (0.012, 0.11), (0.018, 0.2)] {
        for (intensity, substeps) in [(0.2, 1), (0.2, 2), (0.2, 4), (0.6, 2), (0.6, 4)] {
            let held = held(scale, intensity, substeps);
            println!("s = {scale} m, I = {intensity}, {substeps} substeps: {held:.3}");
            assert!((held - 1.0).abs() < bound, "s = {scale}, I = {intensity}, {substeps} substeps: {held}");
        }
    }
}

/// With the dials alone eddies of their scale and intensity go through an empty wind tunnel of 0.5 m: in its second
/// half they neither have died nor grown, by 20 %.
#[test]
#[ignore = "long: three minutes of CPU time"]
fn eddies_that_enter_keep_their_intensity() {
    for (scale, intensity, substeps) in [(0.006, 0.3, 2), (0.012, 0.3, 2), (0.018, 0.3, 2), (0.012, 0.6, 4)] {
        let mut scene = Scene::new(Time { substeps, ..Time::new(1.38e-3, 1.0) });
        scene.air = Some(Air { ramp: 0.0, ..Air::filling([0.5, 0.09, 0.09]).wind([SPEED, 0.0, 0.0]) });
        scene.turbulence = Turbulence { intensity: Some(intensity), ..Turbulence::scale(scale) };
        let mut simulation = Simulation::new(&support::gpu(), &scene).unwrap();
        simulation.step(140).unwrap();
        let (mut sum, mut count) = (0.0, 0.0);
        for _ in 0..5 {
            simulation.step(20).unwrap();
            let energy = simulation.band_energy().unwrap();
            let frame = simulation.frame().unwrap();
            let behind = frame.air.positions.iter().zip(&energy).filter(|(x, _)| x[0] > 0.25);
            behind.for_each(|(_, energy)| (sum, count) = (sum + f64::from(*energy), count + 1.0));
        }
        let held = (2.0_f64 * sum / count).sqrt() / (intensity * SPEED);
        println!("s = {scale} m, I = {intensity}, {substeps} substeps: {held:.3}");
        assert!((held - 1.0).abs() < 0.2, "s = {scale}, I = {intensity}: {held}");
    }
}
