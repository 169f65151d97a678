//! Cosserat rods: rest shapes, weight, fall, vibration. Hair alone, direct solver, BDF2, 0.35 m in 34 segments.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DQuat, DVec3};
use windswept_engine::{Gpu, HairFrame, Simulation};
use windswept_reference::tables;
use windswept_scene::{Fibre, Hair, InitialState, Moduli, Rods, Roots, Scene, Stiffness, StrandStiffness};

use crate::{
    Error, Row,
    air::{farthest, ran, vectors},
    scenes::alone,
};

const TIP: &str = "windswept_reference::tables; 34 segments by themselves are 1e-4 to 2.1e-3 off (elastica), 6e-4 (helix); \
    the bound is 2.5e-3";
const SHAPE: &str = "windswept_reference::tables; 34 segments are measured 4.6e-4 off; margin 3";
const STAYS: &str = "at rest; measured 1.2e-7, undamped rounding; margin 4";
const BEAM: &str = "(beta L)²/(2 pi L²) sqrt(EI/rho A); tip 2 % of L, 1.38 ms: measured 0.2 % off; the bound is 1 %";
const FALL: &str = "-g (t²/2 + 3/4 dt²): BDF2 is exact but for its first step, Euler's; measured 3e-8 off";

/// Segments of a strand.
pub const SEGMENTS: usize = 34;
/// Length of a strand \[m\].
pub const LENGTH: f64 = 0.35;
/// Line density ρA of a hair of 40 µm radius and 1320 kg/m³ \[kg/m\].
pub const LINE_DENSITY: f64 = 1320.0 * PI * 1.6e-9;
/// Stretching stiffness EA of 4 GPa and that radius \[N\].
pub const STRETCH: f64 = 4e9 * PI * 1.6e-9;
/// Bending stiffness over twisting stiffness, EI/GJ.
pub const BEND_OVER_TWIST: f64 = 1.38;
/// Gravity \[m/s²\].
pub const GRAVITY: f64 = 9.81;

/// A strand to be built.
#[derive(Debug, Clone, Copy)]
pub struct Rod {
    /// Weight over stiffness γ = ρAgL³/EI.
    pub gamma: f64,
    /// Rest Darboux vector times L, of the form (0, κ, τ).
    pub darboux: DVec3,
    /// Frame of the clamp.
    pub root_frame: DQuat,
    /// Segments of the strand.
    pub segments: usize,
}

impl Rod {
    /// A strand that is straight and level, as those of cantilever.csv.
    #[must_use]
    pub fn level(gamma: f64, segments: usize) -> Self {
        let root_frame = DQuat::from_mat3(&DMat3::from_cols(DVec3::NEG_Y, DVec3::NEG_Z, DVec3::X));
        Self { gamma, darboux: DVec3::ZERO, root_frame, segments }
    }

    /// The strand of a row of helix.csv.
    #[must_use]
    pub fn helix(row: &tables::Helix, segments: usize) -> Self {
        let root_frame = DQuat::from_mat3(&DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y));
        Self { gamma: row.gamma, darboux: row.darboux, root_frame, segments }
    }

    /// Bending stiffness EI \[N m²\].
    #[must_use]
    pub fn bend(&self) -> f64 {
        LINE_DENSITY * GRAVITY * LENGTH.powi(3) / self.gamma
    }

    /// The strand's group, of `copies` strands.
    fn group(&self, i: usize, copies: usize) -> Hair {
        let kappa = self.darboux / LENGTH;
        let square = kappa.length_squared();
        let fibre = Fibre { stiffness: stiffness(STRETCH, self.bend()), ..Fibre::default() };
        let roots = Roots::disc([0.0, 0.0, i as f64], 1e-3).toward([1.0, 0.0, 0.0]);
        let mut hair = Hair::drawn(copies as u32, self.segments as u32 + 1, LENGTH, roots).named(i.to_string());
        if square > 0.0 {
            hair = hair.curled(kappa.y / square, TAU * kappa.z / square);
        }
        Hair { fibre, ..hair }
    }
}

/// Stiffnesses of a strand: EA \[N\], EI \[N m²\], and the GJ of a round one.
pub(crate) fn stiffness(stretch: f64, bend: f64) -> Stiffness {
    let (twist, poissons_ratio) = (bend / BEND_OVER_TWIST, Moduli::default().poissons_ratio);
    Stiffness::Direct(StrandStiffness { stretch, bend, twist, poissons_ratio })
}

/// Scene of `copies` strands of each rod; Δt in s, gravity downward in m/s².
#[must_use]
pub fn scene(rods: &[Rod], copies: usize, step: f64, gravity: f64, solved: Rods) -> Scene {
    let groups: Vec<Hair> = rods.iter().enumerate().map(|(i, rod)| rod.group(i, copies)).collect();
    Scene { gravity: [0.0, -gravity, 0.0], rods: solved, ..alone(step, groups) }
}

/// The [`scene`] and its strands, each clamped as its rod says.
///
/// # Errors
/// [`Error::Scene`] if the scene cannot be.
pub fn build(
    rods: &[Rod],
    copies: usize,
    step: f64,
    gravity: f64,
    solved: Rods,
) -> Result<(Scene, InitialState), Error> {
    let scene = scene(rods, copies, step, gravity, solved);
    let mut initial = InitialState::new(&scene)?;
    for s in 0..initial.hair.len() {
        let rod = &rods[initial.hair.group[s] as usize];
        initial.hair.turn_clamp(s, rod.root_frame);
    }
    Ok((scene, initial))
}

/// The scene that this file runs: the direct solver with BDF2, awake. Damping in 1/s.
fn built(rods: &[Rod], step: f64, damping: f64, gravity: f64) -> Result<(Scene, InitialState), Error> {
    build(rods, 1, step, gravity, Rods { damping, sleep: false, ..Rods::default() })
}

/// Tip of each strand, from its root \[L\].
#[must_use]
pub fn tips(hair: &HairFrame) -> Vec<DVec3> {
    let positions = vectors(&hair.positions);
    hair.offsets
        .windows(2)
        .map(|ends| (positions[ends[1] as usize - 1] - positions[ends[0] as usize]) / LENGTH)
        .collect()
}

/// Rows of a curled strand without weight: it stays as it is, on the helix of helix.csv.
pub(crate) fn at_rest(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let (step, steps) = (1.38e-3, 100);
    let table = tables::helix();
    let row =
        table.iter().find(|row| row.gamma == 0.0).ok_or_else(|| Error::Missing("helix.csv: gamma 0".to_owned()))?;
    let (scene, initial) = built(&[Rod { gamma: 10.0, ..Rod::helix(row, SEGMENTS) }], step, 0.0, 0.0)?;
    let start = initial.hair.positions.clone();
    let simulation = ran(gpu, &scene, initial, steps)?;
    let frame = simulation.frame()?;
    let moved = vectors(&frame.hair.positions).into_iter().zip(start).map(|(x, start)| (x - start).length() / LENGTH);
    let off = tips(&frame.hair).into_iter().map(|tip| (tip - row.tip).length());
    Ok(vec![
        Row::new("curled strand without weight: tip off helix.csv", 0.0, farthest(off, 0.0), 1.5e-3, SHAPE)
            .in_unit("L"),
        Row::new("curled strand without weight: strays in 100 steps", 0.0, farthest(moved, 0.0), 5e-7, STAYS)
            .in_unit("L"),
    ])
}

/// A strand and the place of its tip where it hangs still.
#[derive(Debug, Clone)]
pub struct Hanging {
    /// The curve that it hangs in, in words.
    pub name: String,
    /// The strand.
    pub rod: Rod,
    /// Tip from root \[L\].
    pub tip: DVec3,
}

impl Hanging {
    /// Straight strands that are clamped level, of these γ (cantilever.csv).
    #[must_use]
    pub fn elasticas(gammas: &[f64]) -> Vec<Self> {
        let rows = tables::cantilever().into_iter().filter(|row| gammas.contains(&row.gamma));
        rows.map(|row| Self {
            name: format!("elastica γ = {}", row.gamma),
            rod: Rod::level(row.gamma, SEGMENTS),
            tip: DVec3::new(row.tip, -row.drop, 0.0),
        })
        .collect()
    }

    /// Helical strands (helix.csv).
    #[must_use]
    pub fn helices() -> Vec<Self> {
        let rows = tables::helix().into_iter().filter(|row| row.gamma > 0.0);
        rows.map(|row| Self {
            name: format!("helix γ = {}", row.gamma), rod: Rod::helix(&row, SEGMENTS), tip: row.tip
        })
        .collect()
    }
}

/// Rows of the tips of strands that hang still: those of the elastica (cantilever.csv) and of the helix (helix.csv).
pub(crate) fn hanging(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let (step, steps, damping) = (1.38e-3, 2500, 8.0);
    let cases = [Hanging::elasticas(&[1.0, 10.0, 100.0]), Hanging::helices()].concat();
    let rods: Vec<_> = cases.iter().map(|case| case.rod).collect();
    let (scene, initial) = built(&rods, step, damping, GRAVITY)?;
    let simulation = ran(gpu, &scene, initial, steps)?;
    let tips = tips(&simulation.frame()?.hair);
    let row = |(case, tip): (&Hanging, DVec3)| {
        Row::new(format!("hanging strand: tip off the {}", case.name), 0.0, tip.distance(case.tip), 2.5e-3, TIP)
            .in_unit("L")
    };
    Ok(cases.iter().zip(tips).map(row).collect())
}

/// Row of the first frequency of a clamped-free beam, f = (βL)²/(2πL²) √(EI/ρA), from the tip's second and third
/// passage of zero.
pub(crate) fn beam(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let (step, amplitude) = (1.38e-3, 0.02);
    let rod = Rod::level(1.0, SEGMENTS);
    let (scene, mut initial) = built(&[rod], step, 0.0, 0.0)?;
    let beta = tables::BEAM_MODES[0];
    let frequency = beta * beta / (TAU * LENGTH * LENGTH) * (rod.bend() / LINE_DENSITY).sqrt();
    let speed = TAU * frequency * amplitude * LENGTH;
    for (k, v) in initial.hair.velocities.iter_mut().enumerate() {
        *v = DVec3::Y * speed * mode(beta, k as f64 / SEGMENTS as f64).0;
    }
    for (k, omega) in initial.hair.angular_velocities.iter_mut().enumerate() {
        *omega = DVec3::Z * speed / LENGTH * mode(beta, (k as f64 + 0.5) / SEGMENTS as f64).1;
    }
    let mut simulation = Simulation::with_state(gpu, &scene, initial)?;
    let (mut before, mut passages) = (0.0, Vec::new());
    while passages.len() < 3 && simulation.time() < 3.0 / frequency {
        simulation.step(1)?;
        let tip = tips(&simulation.frame()?.hair)[0].y;
        if before * tip < 0.0 {
            passages.push(simulation.time() - step * tip / (tip - before));
        }
        before = tip;
    }
    let measured = passages.get(2).map_or(f64::NAN, |last| 1.0 / (last - passages[0]));
    Ok(vec![Row::new("clamped beam: first frequency", frequency, measured, 0.01 * frequency, BEAM).in_unit("Hz")])
}

/// Shape and slope of a clamped-free beam's mode at s from 0 to 1, in units of the tip's shape.
#[must_use]
pub fn mode(beta: f64, s: f64) -> (f64, f64) {
    let sigma = (beta.cosh() + beta.cos()) / (beta.sinh() + beta.sin());
    let shape = |x: f64| x.cosh() - x.cos() - sigma * (x.sinh() - x.sin());
    let slope = |x: f64| beta * (x.sinh() + x.sin() - sigma * (x.cosh() - x.cos()));
    (shape(beta * s) / shape(beta), slope(beta * s) / shape(beta))
}

/// Row of a loose strand that falls by ½ g t². The first step is Euler's and goes twice as far; BDF2 keeps 3/2 of that.
pub(crate) fn falling(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let (step, steps) = (1.38e-3, 100);
    let (scene, mut initial) = built(&[Rod::level(10.0, SEGMENTS)], step, 0.0, GRAVITY)?;
    initial.hair.inverse_mass[0] = initial.hair.inverse_mass[SEGMENTS];
    let start = initial.hair.positions.clone();
    let simulation = ran(gpu, &scene, initial, steps)?;
    let frame = simulation.frame()?;
    let n = steps as f64;
    let expected = -GRAVITY * step * step * (0.5 * n * n + 0.75);
    let fallen: Vec<f64> = vectors(&frame.hair.positions).iter().zip(&start).map(|(x, start)| x.y - start.y).collect();
    Ok(vec![Row::new("loose strand: fall in 100 steps", expected, farthest(fallen, expected), 1e-6, FALL).in_unit("m")])
}
