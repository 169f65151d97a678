//! Masses far apart: neighbours on a strand, hair and air, strands of one fibre and of a thousand.

use std::f64::consts::TAU;

use glam::DVec3;
use windswept_engine::{Gpu, Simulation};
use windswept_scene::{End, Fibre, InitialState, Model, Scene};

use super::{
    COUPLINGS, Coupling, Extent, Felt, LENGTH, POINTS, WIND, roots, strands, sweep_of_unsolved, undriven, watch,
};
use crate::{
    Error, Sweep,
    momentum::{exchanged, received},
};

pub(super) const SWEPT: &str = "neighbouring points of masses 1 : 1e4; hair of 1e-4 to 1e3 times its mass, of which with particles none \
    moves with less than a tenth of that of its air; 1 to 1000 fibres; \
    each model and fluid solver: loose strands in swirling air without wind, clamped ones in 10 m/s, and without air level ones that fall";

/// A scene, and its drive in words.
type Drive = (&'static str, fn(Coupling) -> Scene);

/// Loose strands in still air.
const CLOSED: Drive = ("closed box", |coupling| {
    let mut scene = coupling.tuft(0.0);
    scene.gravity = [0.0; 3];
    scene.hair[0].root = End::Free;
    scene.rods.sleep = false;
    scene
});
const BLOWN: Drive = ("10 m/s", |coupling| coupling.tuft(10.0));
/// Strands that start level.
const FALLING: Drive = ("falling", |coupling| {
    let hair = vec![strands(6, POINTS, LENGTH, roots().toward([1.0, 0.0, 0.0]))];
    Scene { hair, ..coupling.tuft(WIND) }
});
/// Density of a hair \[kg/m³\].
const DENSITY: f64 = 1320.0;
/// Hair's mass over its own, mass of a point over that of its neighbours, fibres of a strand; the last setting is two
/// at once.
const MASSES: &[(f64, f64, f64)] = &[
    (1.0, 1e4, 1.0),
    (1.0, 1e4, 30.0),
    (1.0, 1e4, 1000.0),
    (1e-2, 1.0, 30.0),
    (1e-4, 1.0, 1.0),
    (1e-4, 1.0, 30.0),
    (1e-4, 1.0, 1000.0),
    (1.0, 1.0, 1.0),
    (1.0, 1.0, 1000.0),
    (1e3, 1.0, 1.0),
    (1e3, 1.0, 1000.0),
    (1e-4, 1e4, 30.0),
];
/// Steps of a run, of 1.38 ms.
const STEPS: u64 = 100;
/// Speed of the swirls \[m/s\].
const SWIRL: f64 = 0.3;

pub(super) fn sweeps(gpu: &Gpu, extent: Extent) -> Result<Vec<Sweep>, Error> {
    let axis = "mass of hair of one fibre a strand, over its own";
    let mut all = [
        Sweep::new("largest stretch", 0.01, "").over(axis),
        Sweep::new("strands reset", 0.0, ""),
        Sweep::new("change of momentum in a closed box, of the impulses exchanged", 1e-4, "").over(axis),
        sweep_of_unsolved().over(axis),
    ];
    for coupling in COUPLINGS {
        let drives: &[Drive] = match coupling.model {
            Model::None => &[FALLING],
            Model::Drag => &[BLOWN],
            Model::TwoWay | Model::Particles => &[CLOSED, BLOWN],
        };
        for &(heavier, alternating, fibres) in extent.of(MASSES, &MASSES[3..4]) {
            let fibre = Fibre { density: DENSITY * heavier, fibres_per_strand: fibres, ..Fibre::default() };
            let setting = format!("mass × {heavier:e}, neighbours 1 : {alternating:e}, {fibres} fibres");
            let at = if (alternating, fibres) == (1.0, 1.0) { heavier } else { f64::NAN };
            for (name, drive) in drives {
                let mut scene = drive(coupling);
                scene.hair[0].fibre = fibre;
                let (felt, drift) = run(gpu, &scene, alternating)?;
                let series = format!("{}, {name}", coupling.name);
                all[0].add(&series, felt.at(&setting), at, felt.stretch);
                all[1].add(&series, felt.at(&setting), f64::NAN, felt.resets);
                all[3].add(&series, felt.at(&setting), at, felt.unsolved);
                if let Some(drift) = drift {
                    all[2].add(&series, felt.at(&setting), at, drift);
                }
            }
        }
    }
    Ok(all.into())
}

/// Run of strands of which every second point is so much lighter, and the change of momentum where nothing is held.
fn run(gpu: &Gpu, scene: &Scene, lighter: f64) -> Result<(Felt, Option<f64>), Error> {
    let mut initial = InitialState::new(scene)?;
    initial.hair.inverse_mass.iter_mut().step_by(2).for_each(|w| *w *= lighter);
    let closed = initial.hair.inverse_mass.iter().all(|w| *w > 0.0);
    if closed {
        let k = TAU / initial.air.size;
        for (v, x) in initial.air.velocities.iter_mut().zip(&initial.air.positions) {
            let at = *x * k;
            *v = SWIRL * DVec3::new(at.y.sin(), at.z.sin(), at.x.sin());
        }
    }
    let mut simulation = Simulation::with_state(gpu, scene, initial)?;
    let mut left = STEPS;
    let mut drift = f64::NAN;
    if closed && simulation.scene().interaction.model == Model::Particles {
        if let Ok((change, received, taken)) = received(&mut simulation, STEPS) {
            (drift, left) = (change.length() / received, STEPS - taken);
        }
    } else if closed {
        drift = exchanged(&mut simulation, STEPS).map_or(f64::NAN, |(change, exchanged)| change.length() / exchanged);
        left = 0;
    }
    let felt = watch(&mut simulation, 1, left.max(1), undriven);
    Ok((felt, closed.then_some(drift)))
}
