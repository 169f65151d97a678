//! Air whose velocity is freed of divergence: the energy that an ideal fluid keeps, and the solver's losses and gains
//! of it.

use std::f64::consts::TAU;

use glam::DVec3;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use windswept_engine::Gpu;
use windswept_scene::{Air, DirectFilter, Filter, Fluid, FluidSolver, InitialState, Scene};

use crate::{
    Error, Row,
    air::{self, Cloud, SIMPLE, STEP, mean, ran, spacing, vectors},
    momentum,
};

const IDEAL: &str = "an ideal fluid keeps it; no step may add to it";
const HALVED: &str = "the limit of short steps: half of them change it by less";
const NUMERICAL: &str =
    "an ideal fluid has none; 3e-6 was measured in f64 by another program of the same scheme; air has 1.5e-5";
const GALILEO: &str = "a wind that carries vortices does not change them";
const NOTHING: &str =
    "uniform air has no divergence at all; f32: a few times 2^-24 of the wind, times the square root of the steps";
const STIRRED: &str = "the limit of short steps; the flow is chaotic, so that a quarter is scatter";
const FILLED: &str =
    "no formula: air flows into a void no faster than it is spread; another program measured 0.83 after 70 ms";
const IMPULSE: &str = "Newton: no more and no less than what was given; f32";

/// A Taylor-Green flow of one period along x and y: u = U sin kx cos ky, v = −U cos kx sin ky.
pub(crate) struct Vortices {
    /// Particles along a period.
    across: usize,
    /// Particles along z.
    deep: usize,
    /// Largest speed U \[m/s\].
    speed: f64,
    /// Speed that it is carried with along x \[m/s\].
    carried: f64,
    /// Jitter of the start \[spacings\].
    jitter: f64,
    /// Steps of which still air settles before it moves.
    settling: u64,
}

/// A flow that is stirred after its particles have come to rest anywhere.
const MELTED: Vortices = Vortices { across: 16, deep: 6, speed: 0.3, carried: 0.0, jitter: 0.2, settling: 60 };
/// A flow that starts on a lattice but for a little.
const FRESH: Vortices = Vortices { across: 24, deep: 8, speed: 0.3, carried: 0.0, jitter: 0.05, settling: 0 };

/// A flow so slow that XSPH far outweighs what the solver itself takes, on a lattice that has come to rest.
pub(crate) const SLOW: Vortices =
    Vortices { across: 24, deep: 6, speed: 0.02, carried: 0.0, jitter: 0.0, settling: 80 };

/// The wind \[m/s\].
const WIND: DVec3 = DVec3::new(3.0, 0.0, 0.0);

/// Air without friction, at so many substeps. The wind of 3 m/s has no fringe to enter through: it says how much
/// particles are spread, and does nothing else.
fn scene(fluid: &Fluid, substeps: u32) -> Scene {
    let mut scene = air::scene();
    (scene.fluid, scene.time.substeps) = (fluid.clone(), substeps);
    (scene.viscosity.hair, scene.viscosity.air) = (Some(0.0), Some(0.0));
    scene.air = scene.air.map(|air| Air { fringe: Some(0.0), ..air.wind(WIND.to_array()) });
    scene
}

impl Vortices {
    /// Energy that is left in a scene after `time` \[s\], of that at the start.
    fn left(&self, gpu: &Gpu, scene: &Scene, time: f64) -> Result<f64, Error> {
        let cloud = Cloud::lattice([self.across, self.across, self.deep], SIMPLE).jittered(self.jitter, 7);
        let mut simulation = ran(gpu, scene, cloud.initial(), self.settling)?;
        let settled = cloud.of_frame(&simulation.frame()?.air);
        let k = TAU / cloud.size.x;
        let carried = DVec3::X * self.carried;
        let start = settled.moving(|x| {
            let (x, y) = (k * x.x, k * x.y);
            self.speed * DVec3::new(x.sin() * y.cos(), -x.cos() * y.sin(), 0.0) + carried
        });
        let velocities: Vec<DVec3> = start.velocities.iter().map(|v| DVec3::from_array(*v)).collect();
        simulation.set_air(None, Some(&velocities))?;
        simulation.step((time / STEP).round() as u64)?;
        let energy = |v: &[DVec3]| v.iter().map(|v| (*v - carried).length_squared()).sum::<f64>();
        Ok(energy(&vectors(&simulation.frame()?.air.velocities)) / energy(&velocities))
    }

    /// Viscosity by which the energy decays in a scene, e^(−4νk²t) \[m²/s\].
    pub(crate) fn viscosity(&self, gpu: &Gpu, scene: &Scene, time: f64) -> Result<f64, Error> {
        let k = TAU / (self.across as f64 * spacing());
        Ok(-self.left(gpu, scene, time)?.ln() / (4.0 * k * k * time))
    }

    /// Time of one turnover \[s\].
    fn turnover(&self) -> f64 {
        self.across as f64 * spacing() / self.speed
    }
}

/// Rows of the invariants of vortices, a void, uniform air and a blow.
pub(crate) fn rows(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let fluid = &Fluid::default();
    let turnover = MELTED.turnover();
    let one = MELTED.left(gpu, &scene(fluid, 1), turnover)?;
    let mut rows = vec![Row::new("Taylor-Green, 16 d, 1 substep: energy after a turnover", 0.97, one, 0.03, IDEAL)];
    let carried = Vortices { carried: 3.0, ..MELTED }.left(gpu, &scene(fluid, 1), turnover)?;
    rows.push(Row::new(
        "Taylor-Green, 16 d, carried by 3 m/s: energy off that at rest",
        0.0,
        carried - one,
        5e-3,
        GALILEO,
    ));
    let viscosity = FRESH.viscosity(gpu, &scene(fluid, 1), 0.276)?;
    rows.push(
        Row::new("Taylor-Green, 24 d: viscosity of the solver", 5e-6, viscosity, 5e-6, NUMERICAL).in_unit("m²/s"),
    );
    rows.push(uniform(gpu, fluid, 1)?);
    rows.push(Row::new("void of 3 d in 3 m/s: air in it after 70 ms", 0.9, filled(gpu, fluid)?, 0.1, FILLED));
    rows.push(Row::new(
        "a blow on a parcel: momentum of all air off it after 20 steps",
        0.0,
        blow(gpu, fluid)?,
        1e-6,
        IMPULSE,
    ));
    Ok(rows)
}

/// Rows of the energy of vortices at short steps and when they are large and fast, and of a stirred box.
pub(crate) fn limits(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let fluid = &Fluid::default();
    let turnover = MELTED.turnover();
    let left = |substeps: u32| MELTED.left(gpu, &scene(fluid, substeps), turnover);
    let (four, eight, sixteen) = (left(4)?, left(8)?, left(16)?);
    let large = Vortices { across: 64, deep: 6, speed: 3.0, ..MELTED };
    let mut rows = vec![
        Row::new("Taylor-Green, 16 d, 4 substeps: energy after a turnover", 0.99, four, 0.01, IDEAL),
        Row::new("Taylor-Green, 16 d, 16 substeps: energy after a turnover", 0.99, sixteen, 0.01, IDEAL),
        Row::new("Taylor-Green, 16 d: energy at 8 substeps off that at 16", 0.0, eight - sixteen, 0.01, HALVED),
        Row::new(
            "Taylor-Green, 64 d, 3 m/s: energy after a turnover",
            0.94,
            large.left(gpu, &scene(fluid, 1), large.turnover())?,
            0.06,
            IDEAL,
        ),
    ];
    for substeps in [4, 16] {
        rows.push(uniform(gpu, fluid, substeps)?);
    }
    rows.push(momentum::air_alone(gpu, FluidSolver::Divergence, 1000, 1e-6)?);
    let (coarse, fine) = (stirred(gpu, fluid, 1)?, stirred(gpu, fluid, 8)?);
    for (scale, (coarse, fine)) in SCALES.into_iter().zip(coarse.into_iter().zip(fine)) {
        let name = format!("stirred box: band of {} mm at 1 substep over that at 8", 1e3 * scale);
        rows.push(Row::new(name, 1.0, coarse / fine, 0.25, STIRRED));
    }
    Ok(rows)
}

/// Row of the rms of the velocities of jittered air off a uniform wind \[m/s\].
fn uniform(gpu: &Gpu, fluid: &Fluid, substeps: u32) -> Result<Row, Error> {
    let cloud = Cloud::lattice([8; 3], SIMPLE).jittered(0.2, 7).moving(|_| WIND);
    let simulation = ran(gpu, &scene(fluid, substeps), cloud.initial(), 600_u64.div_ceil(substeps.into()))?;
    let v = vectors(&simulation.frame()?.air.velocities);
    let noise = mean(v.iter().map(|v| (*v - WIND).length_squared())).sqrt();
    let name = format!("uniform wind of 3 m/s, {substeps} substeps, 600 in all: rms of the velocity off it");
    Ok(Row::new(name, 0.0, noise, 1e-6, NOTHING).in_unit("m/s"))
}

/// Part of its share of air that a void in a wind of 3 m/s has after 70 ms.
fn filled(gpu: &Gpu, fluid: &Fluid) -> Result<f64, Error> {
    let radius = 3.0 * spacing();
    let mut cloud = Cloud::lattice([14; 3], SIMPLE).jittered(0.2, 7).moving(|_| WIND);
    let (size, center) = (cloud.size, 0.5 * cloud.size);
    let off = |x: &[f64; 3], center: DVec3| {
        let gap = DVec3::from_array(*x) - center;
        (gap - size * (gap / size).round()).length()
    };
    cloud.positions.retain(|x| off(x, center) > radius);
    cloud.velocities.truncate(cloud.positions.len());
    let mut initial = cloud.initial();
    initial.air.volume = size.element_product() / cloud.positions.len() as f64;
    let simulation = ran(gpu, &scene(fluid, 1), initial.clone(), (0.070 / STEP).round() as u64)?;
    let moved = center + WIND * simulation.time();
    let within = cloud.of_frame(&simulation.frame()?.air).positions.iter().filter(|x| off(x, moved) < radius).count();
    Ok(within as f64 * initial.air.volume / (4.0 / 3.0 * std::f64::consts::PI * radius.powi(3)))
}

/// Momentum of air at rest in which one particle was given a blow, off that blow after 20 steps, of it.
fn blow(gpu: &Gpu, fluid: &Fluid) -> Result<f64, Error> {
    let cloud = Cloud::lattice([12; 3], SIMPLE).jittered(0.05, 7);
    let mut initial: InitialState = cloud.initial();
    initial.air.velocities[100] = DVec3::X;
    let simulation = ran(gpu, &scene(fluid, 1), initial, 20)?;
    let sum: DVec3 = vectors(&simulation.frame()?.air.velocities).into_iter().sum();
    Ok((sum - DVec3::X).length())
}

/// Scales of the bands that are looked at \[m\].
const SCALES: [f64; 3] = [0.006, 0.009, 0.018];

/// Waves in a stirred box, and the most periods of one to the box: down to five spacings, which particles still
/// resolve.
const WAVES: usize = 40;
const SHORTEST: f64 = 3.0;

/// A cloud at rest, stirred by solenoidal waves to so much rms speed \[m/s\]; long waves are larger.
fn swirling(cloud: Cloud, speed: f64) -> Cloud {
    let mut rng = Pcg64::seed_from_u64(11);
    let mut wave = || {
        let periods = loop {
            let periods = DVec3::from_array(std::array::from_fn(|_| f64::from(rng.random_range(-3..=3))));
            if (1.0..=SHORTEST).contains(&periods.length()) {
                break periods;
            }
        };
        let toward = DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
        (TAU * periods / cloud.size, toward.reject_from(periods) / periods.length(), rng.random_range(0.0..TAU))
    };
    let waves: Vec<(DVec3, DVec3, f64)> = (0..WAVES).map(|_| wave()).collect();
    let mut cloud = cloud.moving(|x| waves.iter().map(|(k, a, phase)| *a * (k.dot(x) + phase).sin()).sum());
    let faster = speed / (2.0 * cloud.energy()).sqrt();
    cloud.velocities.iter_mut().flatten().for_each(|v| *v *= faster);
    cloud
}

/// Energy of vortices of 16 spacings and 0.3 m/s after a turnover, of that at the start.
pub fn energy_left(gpu: &Gpu, fluid: &Fluid, substeps: u32) -> Result<f64, Error> {
    MELTED.left(gpu, &scene(fluid, substeps), MELTED.turnover())
}

/// Energy of the bands of `SCALES` in a box that was stirred to 0.5 m/s rms, after 0.12 s \[m²/s²\].
pub fn stirred(gpu: &Gpu, fluid: &Fluid, substeps: u32) -> Result<[f64; 3], Error> {
    let cloud = swirling(Cloud::lattice([16; 3], SIMPLE).jittered(0.2, 7), 0.5);
    let mut scene = scene(fluid, substeps);
    scene.viscosity.air = Some(0.014);
    let simulation = ran(gpu, &scene, cloud.initial(), (0.12 / STEP).round() as u64)?;
    let after = cloud.of_frame(&simulation.frame()?.air);
    let band = |scale: f64| -> Result<f64, Error> {
        let band =
            vectors(&after.particles().band_velocity(gpu, scale, Filter::Direct(DirectFilter { cutoff: 4.5 }))?);
        Ok(mean(band.iter().map(|u| 0.5 * u.length_squared())))
    };
    Ok([band(SCALES[0])?, band(SCALES[1])?, band(SCALES[2])?])
}
