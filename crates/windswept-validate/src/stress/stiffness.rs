//! Strands a million times too stiff or too limp: they hang as a chain of links does, and stay whole.

use std::f64::consts::FRAC_PI_2;

use glam::DVec3;
use windswept::{Gpu, Simulation};
use windswept_scene::InitialState;

use super::{COUPLINGS, Extent, Felt, Sweep, USUAL, points, scene, stretch_of, watch};
use crate::{
    Error,
    air::farthest,
    rods::{self, BEND_OVER_TWIST, GRAVITY, LENGTH, LINE_DENSITY, Rod, STRETCH},
};

pub(super) const SWEPT: &str = "bend stiffness times 1e-6 to 1e6 (γ = 1e7 to 1e-5), stretch stiffness times 1e-2 to 1e4; hair alone, and fewer of \
    them in still air, each other model and fluid solver";

const SEGMENTS: usize = 34;
/// Weight over stiffness γ = ρAgL³/EI of a strand whose stiffness is multiplied by 1.
const GAMMA: f64 = 10.0;
/// Step \[s\], and number of steps in which a damped strand comes to rest.
const STEP: f64 = 1.38e-3;
const STEPS: u64 = 2500;
/// Looks at the stretch in that time.
const LOOKS: u64 = 100;

pub(super) fn sweeps(gpu: &Gpu, extent: Extent) -> Result<Vec<Sweep>, Error> {
    let mut off = Sweep::new("tip at rest, off a chain of links", 1e-3, "L").over("bend stiffness, times");
    let mut stretched = Sweep::new("largest stretch beyond T/EA", 0.01, "").over("bend stiffness, times");
    let mut resets = Sweep::new("strands reset", 0.0, "");
    let bends = extent.of(&[1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0, 1e3, 1e4, 1e5, 1e6][..], &[1e-2, 1e3]);
    for &loose in extent.of(&[1e-2, 1.0, 100.0, 1e4][..], &[1.0]) {
        let series = format!("stretch stiffness × {loose:e}");
        let rods: Vec<Rod> = bends.iter().map(|bend| Rod::level(GAMMA / bend, SEGMENTS)).collect();
        let (scene, mut initial) = rods::build(&rods, 1, STEP, GRAVITY, "damping = 8.0")?;
        for c in &mut initial.hair.stretch_compliance {
            *c /= loose;
        }
        let hair = initial.hair.clone();
        let mut simulation = Simulation::with_state(gpu, &scene, initial)?;
        let mut most = vec![0.0; bends.len()];
        for _ in 0..LOOKS {
            simulation.step(STEPS / LOOKS)?;
            let x = points(&simulation)?;
            for (s, most) in most.iter_mut().enumerate() {
                *most = farthest([*most, stretch_of(&hair, s, &x)], 0.0);
            }
        }
        let (x, tension) = (points(&simulation)?, LINE_DENSITY * GRAVITY * LENGTH / (STRETCH * loose));
        for (s, &bend) in bends.iter().enumerate() {
            let setting = format!("bend stiffness × {bend:e}");
            let own = hair.points(s);
            let tip = (x[own.end - 1] - x[own.start]) / LENGTH;
            stretched.add(&series, &setting, bend, most[s] - tension);
            off.add(&series, &setting, bend, tip.distance(chain_tip(GAMMA / bend, SEGMENTS)));
        }
        resets.add(&series, "all", f64::NAN, super::resets(&simulation));
    }
    let bends = extent.of(&[1e-6, 1e-2, 1.0, 1e2, 1e6][..], &[1e-2]);
    for (coupling, keys) in extent.of(&COUPLINGS[1..], &USUAL[..]) {
        let series = format!("{coupling}, still air");
        let felt = in_still_air(gpu, keys, bends)?;
        for (&bend, (apart, beyond)) in bends.iter().zip(felt.1) {
            let setting = felt.0.at(format!("bend stiffness × {bend:e}"));
            stretched.add(&series, &setting, bend, beyond);
            off.add(&series, &setting, bend, apart);
        }
        resets.add(&series, "all", f64::NAN, felt.0.resets);
    }
    Ok(vec![off, stretched, resets])
}

/// Length of a strand in air \[m\], its segments, and steps in which it comes to rest.
const SHORT: f64 = 0.05;
const FEW: usize = 8;
const SOON: u64 = 1500;

/// Strands in still air, farther than a kernel radius from one another: how far from a chain of links' the tip of each
/// comes to rest \[L\], and its largest stretch on the way beyond that of its weight.
fn in_still_air(gpu: &Gpu, keys: &[&str], bends: &[f64]) -> Result<(Felt, Vec<(f64, f64)>), Error> {
    let depth = 0.012 * bends.len().max(3) as f64;
    let group = |(i, bend): (usize, &f64)| {
        let stiffness = LINE_DENSITY * GRAVITY * SHORT.powi(3) / GAMMA * bend;
        format!(
            "[[hair]]\nname = \"{i}\"\nstrands = 1\npoints = {}\nlength = {SHORT}\nradius = 4e-5\ndensity = 1320\n\
             stretch_stiffness = {STRETCH}\nbend_stiffness = {stiffness}\ntwist_stiffness = {}\n\
             roots = {{ center = [0.005, 0.055, {}], radius = 1e-9, direction = [1, 0, 0] }}\n",
            FEW + 1,
            stiffness / BEND_OVER_TWIST,
            0.012 * (i as f64 + 0.5),
        )
    };
    let text = format!(
        "time = {{ step = {STEP}, duration = 1e3 }}\ngravity = [0, {}, 0]\nrods = {{ damping = 21 }}\n\
         viscosity = {{ kinematic_hair = 4e-3, kinematic_air = 4e-5 }}\n\
         [air]\nbox = {{ min = [0, 0, 0], max = [0.06, 0.06, {depth}] }}\nwind = [0, 0, 0]\n{}",
        -GRAVITY,
        bends.iter().enumerate().map(group).collect::<String>(),
    );
    let scene = scene(&text, &[keys])?;
    let mut initial = InitialState::new(&scene)?;
    (0..bends.len()).for_each(|s| initial.hair.turn_clamp(s, Rod::level(1.0, FEW).root_frame));
    let hair = initial.hair.clone();
    let mut simulation = Simulation::with_state(gpu, &scene, initial)?;
    let mut most = vec![0.0; bends.len()];
    let mut look = |simulation: &Simulation| {
        let x = points(simulation)?;
        for (s, most) in most.iter_mut().enumerate() {
            *most = farthest([*most, stretch_of(&hair, s, &x)], 0.0);
        }
        Ok(x)
    };
    let felt = watch(&mut simulation, LOOKS, SOON / LOOKS, |simulation, _| look(simulation).map(drop));
    let x = look(&simulation)?;
    let tension = LINE_DENSITY * GRAVITY * SHORT / STRETCH;
    let strands = bends.iter().enumerate().map(|(s, bend)| {
        let own = hair.points(s);
        let tip = (x[own.end - 1] - x[own.start]) / SHORT;
        (tip.distance(chain_tip(GAMMA / bend, FEW)), most[s] - tension)
    });
    Ok((felt, strands.collect()))
}

/// Where the tip of a level chain of `n` links of equal length hangs, from its root \[L\].
///
/// The links do not stretch. Their joints have the moment (EI/l) sin Δ of a rod's, the clamp's, of half the length,
/// twice that; half of a link's weight hangs on each of its ends. It is found by shooting from the tip, from whose
/// angle φ off the plumb line all others follow inward, so that the clamp is level.
#[must_use]
pub fn chain_tip(gamma: f64, n: usize) -> DVec3 {
    let l = 1.0 / n as f64;
    // Angles off the plumb line, tip first, and the clamp's; `None` where it stands above level, or bends more than it
    // can.
    let shoot = |tip: f64| -> Option<Vec<f64>> {
        let (mut all, mut below, mut lever) = (vec![tip], 0.0, 0.0);
        for k in (0..n).rev() {
            let own = if k + 1 == n { 0.5 * l } else { l };
            let phi = *all.last()?;
            below += own;
            lever += below * l * phi.sin();
            let stiffness = if k == 0 { 2.0 } else { 1.0 } / (gamma * l);
            let turn = lever / stiffness;
            let next = phi + if turn <= 1.0 { turn.asin() } else { return None };
            if next > FRAC_PI_2 + 1e-9 {
                return None;
            }
            all.push(next);
        }
        Some(all)
    };
    let (mut low, mut high) = (f64::MIN_POSITIVE.ln(), FRAC_PI_2.ln());
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if shoot(middle.exp()).is_some() { low = middle } else { high = middle }
    }
    let angles = shoot(low.exp()).unwrap_or_default();
    angles.iter().take(n).map(|phi| l * DVec3::new(phi.sin(), -phi.cos(), 0.0)).sum()
}
