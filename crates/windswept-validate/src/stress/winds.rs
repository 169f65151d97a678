//! Winds up to three times the speed of sound, and winds that change all the time.

use glam::DVec3;
use windswept_engine::{Gpu, Simulation};

use super::{COUPLINGS, Extent, sweep_of_unsolved, watch};
use crate::{Error, Sweep};

pub(super) const SWEPT: &str = "winds of 0 to 1000 m/s: steady, on and off every frame, reversed every frame, gusting at 1 kHz; \
    each model that has wind and both fluid solvers";

/// Winds \[m/s\].
const WINDS: [f64; 6] = [0.0, 3.0, 30.0, 100.0, 300.0, 1000.0];
/// Frames of 12 steps that are run.
const FRAMES: u64 = 12;
const FRAME: u64 = 12;

/// A way in which the wind changes: the step \[s\], the steps between changes, and the part of the wind that blows
/// after `n` of them.
struct Change {
    name: &'static str,
    step: f64,
    every: u64,
    part: fn(u64) -> f64,
}

const CHANGES: &[Change] = &[
    Change { name: "steady", step: 1.38e-3, every: FRAME, part: |_| 1.0 },
    Change { name: "on and off", step: 1.38e-3, every: FRAME, part: |n| ((n + 1) % 2) as f64 },
    Change { name: "reversed", step: 1.38e-3, every: FRAME, part: |n| 1.0 - 2.0 * (n % 2) as f64 },
    // Four steps to a period.
    Change { name: "1 kHz", step: 0.25e-3, every: 1, part: |n| [0.5, 1.0, 0.5, 0.0][(n % 4) as usize] },
];

pub(super) fn sweeps(gpu: &Gpu, extent: Extent) -> Result<Vec<Sweep>, Error> {
    let mut stretched = Sweep::new("largest stretch", 0.0101, "").over("wind [m/s]");
    let mut resets = Sweep::new("strands reset", 0.0, "");
    let mut unsolved = sweep_of_unsolved().over("wind [m/s]");
    let mut hair = Sweep::new("fastest hair over the largest wind", 1.3, "").over("wind [m/s]");
    for coupling in extent.of(&COUPLINGS[1..], &[COUPLINGS[2], COUPLINGS[5]]) {
        for change in extent.of(CHANGES, &CHANGES[2..]) {
            for &wind in extent.of(&WINDS[..], &[30.0, 300.0]) {
                if wind == 0.0 && change.name != "steady" {
                    continue;
                }
                let mut scene = coupling.tuft(wind);
                scene.time.step = change.step;
                let mut simulation = Simulation::new(gpu, &scene)?;
                let felt = watch(&mut simulation, FRAMES * FRAME, 1, |simulation, step| {
                    let part = (change.part)(step / change.every);
                    if step % change.every == 0 { simulation.set_wind(DVec3::X * wind * part) } else { Ok(()) }
                });
                let series = format!("{}, {}", coupling.name, change.name);
                let setting = felt.at(format!("{wind} m/s"));
                stretched.add(&series, &setting, wind, felt.stretch);
                resets.add(&series, &setting, wind, felt.resets);
                unsolved.add(&series, &setting, wind, felt.unsolved);
                if wind > 0.0 {
                    hair.add(&series, &setting, wind, felt.hair / wind);
                }
            }
        }
    }
    Ok(vec![stretched, resets, unsolved, hair])
}
