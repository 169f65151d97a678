//! Taylor-Green vortices in three dimensions that viscosity slows, beside a solver of the Navier-Stokes equations on a
//! grid.

use std::f64::consts::TAU;

use glam::DVec3;
use windswept_engine::{Gpu, Simulation};

use crate::{
    Error, Row,
    air::{self, Cloud, SIMPLE, STEP, mean, vectors},
};

const REFERENCE: &str = "JAX-Fluids, 64³ cells (energies as kept by jax-sph)";
const HALVED: &str = "the limit of short steps: half of them change it by less";
const FINER: &str = "half the spacing at as many spacings a step at least halves the error";

/// A flow u = U sin kx cos ky cos kz, v = −U cos kx sin ky cos kz.
struct Flow {
    /// U/(kν).
    reynolds: f64,
    /// Times \[1/(kU)\] and the reference's energies at them \[U²\].
    energies: &'static [(f64, f64)],
}

const FIFTY: Flow =
    Flow { reynolds: 50.0, energies: &[(1.0, 0.110_575), (2.0, 0.095_707), (4.0, 0.064_968), (6.0, 0.040_215)] };
const TEN: Flow = Flow { reynolds: 10.0, energies: &[(1.0, 0.068_261), (2.0, 0.035_972), (4.0, 0.009_871)] };

/// Particles along a period.
const ACROSS: usize = 40;
/// Way of the fastest air in a step of 1.38 ms, in periods of so many particles over 2π: 0.32 spacings.
const WAY: f64 = 0.05;
/// Jitter of the start \[spacings\].
const JITTER: f64 = 0.05;

impl Flow {
    /// Energies at the reference's times over the reference's, with so many particles along a period.
    fn energies(&self, gpu: &Gpu, across: usize, substeps: u32) -> Result<Vec<f64>, Error> {
        // As many spacings a step, however many particles a period has.
        let speed = WAY * ACROSS as f64 * air::spacing() / TAU / STEP;
        let lattice = Cloud::lattice([across; 3], SIMPLE).jittered(JITTER, 7);
        let k = TAU / lattice.size.x;
        let cloud = lattice.moving(|x| {
            let at = k * x;
            speed * at.z.cos() * DVec3::new(at.x.sin() * at.y.cos(), -at.x.cos() * at.y.sin(), 0.0)
        });
        let viscosity = speed / (k * self.reynolds);
        let mut scene = air::scene();
        scene.time.substeps = substeps;
        (scene.viscosity.hair, scene.viscosity.kinematic_air) = (Some(0.0), Some(viscosity));
        let mut simulation = Simulation::with_state(gpu, &scene, cloud.initial())?;
        let mut done = 0;
        let mut at = |&(time, energy): &(f64, f64)| {
            let steps = (time / (k * speed * STEP)).round() as u64;
            simulation.step(steps - done)?;
            done = steps;
            let velocities = vectors(&simulation.frame()?.air.velocities);
            Ok(0.5 * mean(velocities.iter().map(|v| v.length_squared())) / (energy * speed.powi(2)))
        };
        self.energies.iter().map(&mut at).collect()
    }

    /// Rows of the energies over the reference's.
    fn rows(&self, energies: &[f64]) -> Vec<Row> {
        let row = |(&(time, _), energy): (&(f64, f64), &f64)| {
            let name =
                format!("Taylor-Green, Re {}, {ACROSS}³: energy at t = {time} over the reference's", self.reynolds);
            Row::new(name, 1.0, *energy, 0.05, REFERENCE)
        };
        self.energies.iter().zip(energies).map(row).collect()
    }
}

/// Largest difference of two runs at the same times.
fn apart(a: &[f64], b: impl IntoIterator<Item = f64>) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Vortices at two Reynolds numbers, at half the step, and of half as many particles.
pub(crate) fn rows(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let fine = FIFTY.energies(gpu, ACROSS, 1)?;
    let halved = FIFTY.energies(gpu, ACROSS, 2)?;
    let coarse = FIFTY.energies(gpu, ACROSS / 2, 1)?;
    let mut rows = FIFTY.rows(&fine);
    let name = format!("Taylor-Green, Re {}, {ACROSS}³: energy at half the step off that at 1.38 ms", FIFTY.reynolds);
    rows.push(Row::new(name, 0.0, apart(&fine, halved), 0.01, HALVED));
    let errors = [fine, coarse].map(|energies| apart(&energies, energies.iter().map(|_| 1.0)));
    let name = format!("Taylor-Green, Re {}: error of {ACROSS}³ over that of {}³", FIFTY.reynolds, ACROSS / 2);
    rows.push(Row::new(name, 0.25, errors[0] / errors[1], 0.25, FINER));
    rows.extend(TEN.rows(&TEN.energies(gpu, ACROSS, 1)?));
    Ok(rows)
}
