//! Dials turned far beyond their range: viscosity, confinement, bands, bodies.

use windswept_engine::{Gpu, Simulation};
use windswept_scene::{Air, Band, Body, Scene};

use super::{COUPLINGS, Extent, WIND, watch};
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
    for &coupling in extent.of(&COUPLINGS[..], &[COUPLINGS[1], COUPLINGS[2], COUPLINGS[5]]) {
        let cut = [bands(1, SCALE, 1000.0, USUAL), bands(2, SMALLEST, 30.0, INTENSE), Dial::Bodies];
        for dial in extent.of(dials(), cut.into()) {
            // Viscosity and bands are those of particles of air.
            if !coupling.has_air() && !matches!(dial, Dial::Bodies) {
                continue;
            }
            let mut scene = coupling.tuft(WIND);
            dial.turn(&mut scene);
            let mut simulation = Simulation::new(gpu, &scene)?;
            let mut energies = Vec::new();
            let felt = watch(&mut simulation, LOOKS, STRIDE, |simulation, _| {
                let v = vectors(&simulation.frame()?.air.velocities);
                energies.push(mean(v.iter().map(|v| v.length_squared())) / WIND.powi(2));
                Ok(())
            });
            let setting = felt.at(dial.name());
            if coupling.has_air() {
                let bands = dial.bands();
                let intensity = bands.first().map_or(USUAL, |band| band.intensity);
                let bound = WILD + (bands.len() as f64 * intensity).powi(2);
                let strength = if let [single] = bands { single.strength } else { f64::NAN };
                let series = format!("{}, intensity {intensity}", coupling.name);
                energy.add(series, &setting, strength, farthest(energies, 0.0)).tolerance = bound;
            }
            stretched.add(coupling.name, &setting, f64::NAN, felt.stretch);
            resets.add(coupling.name, &setting, f64::NAN, felt.resets);
        }
    }
    Ok(vec![energy, stretched, resets])
}

/// A dial that is turned.
enum Dial {
    /// `viscosity.hair`.
    Viscosity(f64),
    /// Bands of one strength and intensity.
    Bands(Vec<Band>),
    /// Sixteen balls that stand in the hair.
    Bodies,
}

impl Dial {
    fn name(&self) -> String {
        match self {
            Self::Viscosity(c) => format!("viscosity.hair {c}"),
            Self::Bands(bands) => {
                let Band { strength, intensity, .. } = bands[0];
                let count = if bands.len() == 1 { "a band" } else { &format!("{} bands", bands.len()) };
                format!("{count} of strength {strength} and intensity {intensity}")
            }
            Self::Bodies => "16 bodies".to_owned(),
        }
    }

    fn turn(&self, scene: &mut Scene) {
        match self {
            Self::Viscosity(c) => scene.viscosity.hair = Some(*c),
            Self::Bands(bands) => {
                scene.turbulence.bands.clone_from(bands);
                // Eddies live on: a fringe would still them where the wind enters.
                scene.air = scene.air.take().map(|air| Air { fringe: Some(0.0), ..air });
            }
            Self::Bodies => {
                let ball = |k: usize| {
                    let (x, y) = (0.005 + 0.01 * (k % 4) as f64, 0.01 + 0.012 * (k / 4) as f64);
                    Body::sphere([x, y, 0.014], 0.003).named(k.to_string())
                };
                scene.bodies = (0..16).map(ball).collect();
            }
        }
    }

    /// Bands that are strengthened; none where the dial is another.
    fn bands(&self) -> &[Band] {
        if let Self::Bands(bands) = self { bands } else { &[] }
    }
}

fn dials() -> Vec<Dial> {
    let viscosities = [0.0, 1.4, 30.0, 100.0].map(Dial::Viscosity);
    let strengths = [0.0, 3.0, 100.0, 1000.0].map(|strength| bands(1, SCALE, strength, USUAL));
    let intense = [3.0, 30.0, 100.0, 1000.0].map(|strength| bands(1, SCALE, strength, INTENSE));
    let many = [USUAL, INTENSE].map(|intensity| [2, 4, 8].map(|n| bands(n, SMALLEST, 30.0, intensity)));
    let many = many.into_iter().flatten();
    viscosities.into_iter().chain(strengths).chain(intense).chain(many).chain([Dial::Bodies]).collect()
}

/// Bands of neighbouring scales, `count` of them from `scale` \[m\] on.
fn bands(count: u32, scale: f64, strength: f64, intensity: f64) -> Dial {
    let band = |k: u32| Band { scale: scale + 0.001 * f64::from(k), strength, intensity };
    Dial::Bands((0..count).map(band).collect())
}
