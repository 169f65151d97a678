//! Strands far too stiff, limp, thin, thick, short or long, and a kilometre from the origin: they hang as a chain of
//! links does, and stay whole.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec3;
use windswept_engine::{Gpu, Simulation};
use windswept_scene::{Air, Bounds, Fibre, Hair, InitialState, Model, Roots, Scene, Time};

use super::{COUPLINGS, Coupling, Extent, Felt, USUAL, points, stretch_of, watch};
use crate::{
    Error, Sweep,
    air::farthest,
    rods::{self, GRAVITY, Rod, stiffness},
};

pub(super) const STIFFNESSES: &str = "bend stiffness times 1e-6 to 1e6 (γ = 1e7 to 1e-5), stretch stiffness times \
    1e-2 to 1e4; hair alone, and fewer of \
    them in still air, each other model and fluid solver";
pub(super) const SIZES: &str = "2 to 1024 points; radius 1 to 500 µm; length 1 mm to 10 m; as they are, and \
    1 km from the origin; hair alone, and fewer of them in \
    still air, each other model and fluid solver";

/// Density of a hair \[kg/m³\], its Young's modulus \[Pa\] and usual radius \[m\].
const DENSITY: f64 = 1320.0;
const MODULUS: f64 = 4e9;
const RADIUS: f64 = 4e-5;

/// A strand that is clamped level.
#[derive(Clone, Copy)]
struct Strand {
    points: usize,
    /// Radius and length \[m\].
    radius: f64,
    length: f64,
    /// Stretching and bending stiffness, over those of a hair of this radius.
    stiffness: [f64; 2],
}

impl Strand {
    /// A hair of so many points, radius and length \[m\].
    const fn hair(points: usize, radius: f64, length: f64) -> Self {
        Self { points, radius, length, stiffness: [1.0; 2] }
    }

    /// Weight of a metre \[N/m\], and the stiffnesses EA \[N\] and EI \[N m²\].
    fn properties(&self) -> (f64, f64, f64) {
        let area = PI * self.radius.powi(2);
        let [stretch, bend] = self.stiffness;
        (DENSITY * GRAVITY * area, stretch * MODULUS * area, bend * 0.25 * MODULUS * area * self.radius.powi(2))
    }

    /// Weight over stiffness γ = ρAgL³/EI.
    fn gamma(&self) -> f64 {
        let (weight, _, bend) = self.properties();
        weight * self.length.powi(3) / bend
    }

    /// The strand with its root at `root` \[m\].
    fn group(&self, name: usize, root: [f64; 3]) -> Hair {
        let (_, stretch, bend) = self.properties();
        let stiffness = stiffness(stretch, bend);
        let fibre = Fibre { radius: self.radius, density: DENSITY, stiffness, ..Fibre::default() };
        let roots = Roots::disc(root, 1e-9).toward([1.0, 0.0, 0.0]);
        Hair { fibre, ..Hair::drawn(1, self.points as u32, self.length, roots).named(name.to_string()) }
    }
}

/// How strands come to rest.
struct Rest {
    /// Step \[s\], number of steps, and looks at the stretch in that time.
    step: f64,
    steps: u64,
    looks: u64,
    /// Damping \[1/s\].
    damping: f64,
    /// Sides of the box along x and y \[m\].
    side: f64,
}

/// A strand at rest.
struct Hung {
    /// Tip from root, and its distance from that of a chain of links \[L\].
    tip: DVec3,
    off: f64,
    /// Largest stretch on the way beyond that of its weight.
    stretch: f64,
}

/// Strands that come to rest in still air, farther than a kernel radius from one another, about a place that is so far
/// along each axis \[m\].
fn hang(
    gpu: &Gpu,
    coupling: Coupling,
    strands: &[Strand],
    center: f64,
    rest: &Rest,
) -> Result<(Felt, Vec<Hung>), Error> {
    let depth = 0.028_f64.max(0.012 * strands.len() as f64);
    let root = |i: usize| [center, center, center + depth * ((i as f64 + 0.5) / strands.len() as f64 - 0.5)];
    let corner = |shift: [f64; 3]| shift.map(|x| center + x);
    let bounds = Bounds {
        min: corner([-0.01, 0.01 - rest.side, -0.5 * depth]),
        max: corner([rest.side - 0.01, 0.01, 0.5 * depth]),
    };
    let mut scene = coupling.of(Scene::new(Time::new(rest.step, 1e3)));
    scene.hair = strands.iter().enumerate().map(|(i, strand)| strand.group(i, root(i))).collect();
    scene.air = Some(Air { bounds: Some(bounds), ..Air::default().wind([0.0; 3]) });
    scene.rods.damping = rest.damping;
    (scene.viscosity.kinematic_hair, scene.viscosity.kinematic_air) = (Some(4e-3), Some(4e-5));
    let mut initial = InitialState::new(&scene)?;
    (0..strands.len()).for_each(|s| initial.hair.turn_clamp(s, Rod::level(1.0, 1).root_frame));
    let hair = initial.hair.clone();
    let mut simulation = Simulation::with_state(gpu, &scene, initial)?;
    let mut most = vec![0.0; strands.len()];
    let mut look = |simulation: &Simulation| {
        let x = points(simulation)?;
        for (s, most) in most.iter_mut().enumerate() {
            *most = farthest([*most, stretch_of(&hair, s, &x)], 0.0);
        }
        Ok(x)
    };
    let stride = rest.steps.div_ceil(rest.looks);
    let felt = watch(&mut simulation, rest.looks, stride, |simulation, _| look(simulation).map(drop));
    let x = look(&simulation)?;
    let hung = strands.iter().zip(most).enumerate().map(|(s, (strand, most))| {
        let own = hair.points(s);
        let tip = (x[own.end - 1] - x[own.start]) / strand.length;
        let (weight, stretch, _) = strand.properties();
        let off = tip.distance(chain_tip(strand.gamma(), strand.points - 1));
        Hung { tip, off, stretch: most - weight * strand.length / stretch }
    });
    Ok((felt, hung.collect()))
}

/// Weight over stiffness γ of a strand whose bending stiffness is multiplied by 1.
const GAMMA: f64 = 10.0;
/// Strands whose stiffnesses are swept, without particles of air and among them, and how they come to rest.
const ALONE: (Strand, Rest) =
    (Strand::hair(35, RADIUS, rods::LENGTH), Rest { step: 1.38e-3, steps: 2500, looks: 100, damping: 8.0, side: 0.06 });
const IN_AIR: (Strand, Rest) =
    (Strand::hair(9, RADIUS, 0.05), Rest { step: 1.38e-3, steps: 1500, looks: 100, damping: 21.0, side: 0.06 });

pub(super) fn stiffnesses(gpu: &Gpu, extent: Extent) -> Result<Vec<Sweep>, Error> {
    let mut off = Sweep::new("tip at rest, off a chain of links", 1e-3, "L").over("bend stiffness, times");
    let mut stretched = Sweep::new("largest stretch beyond T/EA", 0.01, "").over("bend stiffness, times");
    let mut resets = Sweep::new("strands reset", 0.0, "");
    let bends = extent.of(&[1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0, 1e3, 1e4, 1e5, 1e6][..], &[1e-2, 1e3]);
    let few = extent.of(&[1e-6, 1e-2, 1.0, 1e2, 1e6][..], &[1e-2]);
    let stretches = extent.of(&[1e-2, 1.0, 100.0, 1e4][..], &[1.0]).iter();
    let alone =
        stretches.map(|stretch| (format!("stretch stiffness × {stretch:e}"), COUPLINGS[0], &ALONE, *stretch, bends));
    let couplings = extent.of(&COUPLINGS[1..], &USUAL[..]).iter();
    let in_air = couplings.map(|coupling| (format!("{}, still air", coupling.name), *coupling, &IN_AIR, 1.0, few));
    for (series, coupling, (strand, rest), stretch, bends) in alone.chain(in_air) {
        let strand = |bend: &f64| Strand { stiffness: [stretch, bend * strand.gamma() / GAMMA], ..*strand };
        let (felt, hung) = hang(gpu, coupling, &bends.iter().map(strand).collect::<Vec<_>>(), 0.0, rest)?;
        for (&bend, hung) in bends.iter().zip(hung) {
            let setting = felt.at(format!("bend stiffness × {bend:e}"));
            stretched.add(&series, &setting, bend, hung.stretch);
            off.add(&series, &setting, bend, hung.off);
        }
        resets.add(&series, "all", f64::NAN, felt.resets);
    }
    Ok(vec![off, stretched, resets])
}

/// Which size of a strand is swept, by its place in [`Swept::ALL`].
#[derive(Clone, Copy)]
enum Swept {
    Points,
    Radius,
    Length,
}

impl Swept {
    /// All, in words and as the axis of a picture.
    const ALL: [(&str, &str); 3] =
        [("numbers of points", "points of the strand"), ("radii", "radius [µm]"), ("lengths", "length [m]")];

    /// Where a strand is on the axis.
    fn of(self, strand: &Strand) -> f64 {
        match self {
            Self::Points => strand.points as f64,
            Self::Radius => 1e6 * strand.radius,
            Self::Length => strand.length,
        }
    }
}

/// Length of the strands whose number of points is swept \[m\]: of 50 mm those of 1024 points would need 21 substeps.
const LONG: f64 = 0.35;
/// Length of other strands without particles of air and among them \[m\].
const USUAL_LENGTH: f64 = 0.05;
const SHORT: f64 = 0.03;

pub(super) fn sizes(gpu: &Gpu, extent: Extent) -> Result<Vec<Sweep>, Error> {
    let mut off = Swept::ALL.map(|(sizes, axis)| {
        Sweep::new(format!("tip at rest, off a chain of links, over {sizes}"), 1e-3, "L").over(axis)
    });
    let mut moved = Sweep::new("tip at rest 1 km away, off that at the origin", 1e-3, "L");
    let mut stretched = Sweep::new("largest stretch", 0.01, "");
    let mut resets = Sweep::new("strands reset", 0.0, "");
    let counts = extent.of(&[2, 3, 5, 9, 35, 128, 1024][..], &[2, 9]).iter();
    let counts = counts.map(|&n| (format!("{n} points"), Swept::Points, Strand::hair(n, RADIUS, LONG)));
    let radii = extent.of(&[1e-6, 1e-5, 5e-4][..], &[]).iter();
    let radii = radii.map(|r| (format!("radius {} µm", 1e6 * r), Swept::Radius, Strand::hair(35, *r, USUAL_LENGTH)));
    let lengths = extent.of(&[1e-3, 0.1, 1.0, 10.0][..], &[]).iter();
    let lengths = lengths.map(|l| (format!("length {l} m"), Swept::Length, Strand::hair(35, RADIUS, *l)));
    let alone: Vec<_> = counts.chain(radii).chain(lengths).collect();
    let in_air = [
        ("35 points", Swept::Points, Strand::hair(35, RADIUS, SHORT)),
        ("2 points", Swept::Points, Strand::hair(2, RADIUS, SHORT)),
        ("128 points", Swept::Points, Strand::hair(128, RADIUS, SHORT)),
        ("1024 points", Swept::Points, Strand::hair(1024, RADIUS, LONG)),
        ("radius 1 µm, length 1 mm", Swept::Radius, Strand::hair(9, 1e-6, 1e-3)),
        ("radius 500 µm", Swept::Radius, Strand::hair(35, 5e-4, SHORT)),
        // Hair of 40 µm falls through still air at half a metre per second, and would swing out for minutes.
        ("radius 500 µm, length 10 m", Swept::Length, Strand::hair(35, 5e-4, 10.0)),
    ];
    let in_air = in_air.map(|(setting, swept, strand)| (setting.to_owned(), swept, strand));
    let in_air = extent.of(&in_air[..], &in_air[1..2]);
    for coupling in extent.of(&COUPLINGS[..], &COUPLINGS[..3]) {
        let (is_alone, series) = (coupling.model == Model::None, format!("{}, still air, ", coupling.name));
        let series = if is_alone { "" } else { &series };
        for (setting, swept, strand) in if is_alone { &alone } else { in_air } {
            let mut tips = Vec::new();
            // Among particles of air only one is looked at far away.
            let places = [("at the origin", 0.0), ("1 km away", 1000.0)];
            for (place, center) in &places[..if is_alone || setting == "35 points" { 2 } else { 1 }] {
                let (felt, hung) = hang(gpu, *coupling, &[*strand], *center, &at_leisure(strand, is_alone))?;
                let (series, setting) = (format!("{series}{place}"), felt.at(setting));
                stretched.add(&series, &setting, f64::NAN, felt.stretch);
                resets.add(&series, &setting, f64::NAN, felt.resets);
                off[*swept as usize].add(&series, &setting, swept.of(strand), hung[0].off);
                tips.push(hung[0].tip);
            }
            if let [here, away] = tips[..] {
                moved.add(format!("{series}1 km away"), setting, f64::NAN, here.distance(away));
            }
        }
    }
    let off = off.into_iter().filter(|sweep| !sweep.rows.is_empty());
    Ok(off.chain([moved, stretched, resets]).collect())
}

/// Rest of a strand of any size, within five periods of its first swing: a beam's, or a chain's where that is faster.
fn at_leisure(strand: &Strand, is_alone: bool) -> Rest {
    let (weight, _, bend) = strand.properties();
    let beam = TAU * strand.length.powi(2) / 3.516 * (weight / GRAVITY / bend).sqrt();
    let period = beam.min(5.2 * (strand.length / GRAVITY).sqrt());
    let (steps, longest) = if is_alone { (1000.0, 1.38e-3) } else { (250.0, 8.3e-3) };
    let step = (5.0 * period / steps).min(longest);
    Rest { step, steps: (5.0 * period / step).ceil() as u64, looks: 1, damping: 8.0 / period, side: 0.05 }
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
