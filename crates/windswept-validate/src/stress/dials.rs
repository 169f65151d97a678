//! Dials turned far beyond their range: viscosity, confinement, bands, bodies.

use windswept_engine::{Gpu, Simulation};

use super::{COUPLINGS, Extent, TUFT, has_air, scene, watch};
use crate::{
    Error, Sweep,
    air::{farthest, mean, vectors},
};

pub(super) const SWEPT: &str = "viscosity.hair 0 to 100; strength of a band of three particle spacings 0 to 1000, and 1 to 8 bands, of intensity 0.3 and 10; \
    16 bodies; each model and fluid solver, those without particles of air with bodies only; wind of 3 m/s, bands without a fringe";

/// Kinetic energy of the air, over that of its wind, which is beyond all bounds without bands. Bands of intensity I may
/// add (n I)²: each is strengthened up to I times the wind's speed at most, and these are of neighbouring scales, so
/// that their speeds add up.
const WILD: f64 = 2.0;
const LOOKS: u64 = 30;
const STRIDE: u64 = 5;
const WIND: f64 = 3.0;
/// Intensity of a band, up to which it is strengthened: at the usual one the strength soon changes nothing more, at the
/// other the limit is what a step resolves, 2.2 times the wind.
const USUAL: f64 = 0.3;
const INTENSE: f64 = 10.0;
/// Scale of a single band, three particle spacings, and of the first of several \[m\].
const SCALE: f64 = 0.015;
const SMALLEST: f64 = 0.005;

pub(super) fn sweeps(gpu: &Gpu, extent: Extent) -> Result<Vec<Sweep>, Error> {
    let mut energy =
        Sweep::new("largest kinetic energy of the air, over the wind's", WILD, "").over("strength of a single band");
    let mut stretched = Sweep::new("largest stretch", 0.02, "");
    let mut resets = Sweep::new("strands reset", 0.0, "");
    for &(coupling, keys) in extent.of(&COUPLINGS[..], &[COUPLINGS[1], COUPLINGS[2], COUPLINGS[5]]) {
        let asked =
            extent.of(dials(), vec![band(1000.0, USUAL), bands("2 bands", 2, SMALLEST, 30.0, INTENSE), bodies()]);
        for Dial { name, keys: turned, bands, strength } in asked {
            // Viscosity and bands are those of particles of air.
            if !has_air(coupling) && name != bodies().name {
                continue;
            }
            let turned: Vec<&str> = turned.iter().map(String::as_str).collect();
            let mut simulation = Simulation::new(gpu, &scene(TUFT, &[keys, &turned])?)?;
            let mut energies = Vec::new();
            let felt = watch(&mut simulation, LOOKS, STRIDE, |simulation, _| {
                let v = vectors(&simulation.frame()?.air.velocities);
                energies.push(mean(v.iter().map(|v| v.length_squared())) / WIND.powi(2));
                Ok(())
            });
            if has_air(coupling) {
                let (count, intensity) = bands;
                let bound = WILD + (f64::from(count) * intensity).powi(2);
                let series = format!("{coupling}, intensity {intensity}");
                energy.add(series, felt.at(&name), strength, farthest(energies, 0.0)).tolerance = bound;
            }
            stretched.add(coupling, felt.at(&name), f64::NAN, felt.stretch);
            resets.add(coupling, felt.at(&name), f64::NAN, felt.resets);
        }
    }
    Ok(vec![energy, stretched, resets])
}

/// A dial that is turned.
struct Dial {
    name: String,
    /// The keys of the scene that turn it.
    keys: Vec<String>,
    /// Number of bands, and their intensity.
    bands: (u32, f64),
    /// Strength of a single band; else NaN.
    strength: f64,
}

impl Dial {
    /// A dial that is not about bands.
    fn new(name: impl Into<String>, key: String) -> Self {
        Self { name: name.into(), keys: vec![key], bands: (0, USUAL), strength: f64::NAN }
    }
}

fn dials() -> Vec<Dial> {
    let viscosities =
        [0.0, 1.4, 30.0, 100.0].map(|c| Dial::new(format!("viscosity.hair {c}"), format!("viscosity.hair={c}")));
    let strengths = [0.0, 3.0, 100.0, 1000.0].map(|strength| band(strength, USUAL));
    let intense = [3.0, 30.0, 100.0, 1000.0].map(|strength| band(strength, INTENSE));
    let many =
        [USUAL, INTENSE].map(|intensity| [2, 4, 8].map(|n| bands(&format!("{n} bands"), n, SMALLEST, 30.0, intensity)));
    let many = many.into_iter().flatten();
    viscosities.into_iter().chain(strengths).chain(intense).chain(many).chain([bodies()]).collect()
}

/// A single band.
fn band(strength: f64, intensity: f64) -> Dial {
    Dial { strength, ..bands("a band", 1, SCALE, strength, intensity) }
}

/// Bands whose eddies live on: a fringe would still them where the wind enters.
fn bands(what: &str, count: u32, scale: f64, strength: f64, intensity: f64) -> Dial {
    let band = |k: u32| {
        format!("{{ scale = {}, strength = {strength}, intensity = {intensity} }}", scale + 0.001 * f64::from(k))
    };
    let key = format!("turbulence={{bands=[{}]}}", (0..count).map(band).collect::<Vec<_>>().join(", "));
    Dial {
        name: format!("{what} of strength {strength} and intensity {intensity}"),
        keys: vec![key, "air.fringe=0".to_owned()],
        bands: (count, intensity),
        strength: f64::NAN,
    }
}

/// Sixteen balls that stand in the hair.
fn bodies() -> Dial {
    let ball = |k: usize| {
        let (x, y) = (0.005 + 0.01 * (k % 4) as f64, 0.01 + 0.012 * (k / 4) as f64);
        format!("{{ name = \"{k}\", center = [{x}, {y}, 0.014], radius = 0.003 }}")
    };
    let key = format!("body=[{}]", (0..16).map(ball).collect::<Vec<_>>().join(", "));
    Dial::new("16 bodies", key)
}
