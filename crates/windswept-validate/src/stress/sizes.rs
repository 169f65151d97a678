//! Strands of 2 to 1024 points, of 1 to 500 µm, of 1 mm to 10 m, and a kilometre from the origin.

use glam::DVec3;
use windswept::{Gpu, Simulation};
use windswept_scene::InitialState;

use super::{COUPLINGS, Extent, Sweep, points, scene, stiffness::chain_tip, undriven, watch};
use crate::{
    Error,
    rods::{GRAVITY, Rod},
};

pub(super) const SWEPT: &str = "2 to 1024 points; radius 1 to 500 µm; length 1 mm to 10 m; as they are, and 1 km from the origin; hair alone, and fewer of them in \
    still air, each other model and fluid solver";

const DENSITY: f64 = 1320.0;
const MODULUS: f64 = 4e9;
/// Sizes of a strand whose others are swept: points, radius \[m\], length \[m\].
const USUAL: (usize, f64, f64) = (35, 4e-5, 0.05);
/// Length of the strands whose number of points is swept \[m\]: of 50 mm those of 1024 points would need 21 substeps.
const LONG: f64 = 0.35;
/// Periods of a beam's first swing in which it is damped to rest.
const PERIODS: f64 = 5.0;
/// Steps of a run, at most, without particles of air and among them.
const STEPS: (u64, u64) = (1000, 250);
/// Longest step \[s\], without particles of air and among them.
const LONGEST: (f64, f64) = (1.38e-3, 8.3e-3);
/// Length of strands in air \[m\], and the sizes of one that is looked at 1 km away, too.
const SHORT: f64 = 0.03;
const USUAL_IN_AIR: (usize, f64, f64) = (35, 4e-5, SHORT);

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
    fn of(self, (n, radius, length): (usize, f64, f64)) -> f64 {
        match self {
            Self::Points => n as f64,
            Self::Radius => 1e6 * radius,
            Self::Length => length,
        }
    }
}

pub(super) fn sweeps(gpu: &Gpu, extent: Extent) -> Result<Vec<Sweep>, Error> {
    let mut off = Swept::ALL.map(|(sizes, axis)| {
        Sweep::new(format!("tip at rest, off a chain of links, over {sizes}"), 1e-3, "L").over(axis)
    });
    let mut moved = Sweep::new("tip at rest 1 km away, off that at the origin", 1e-3, "L");
    let mut stretched = Sweep::new("largest stretch", 0.01, "");
    let mut resets = Sweep::new("strands reset", 0.0, "");
    let (n, radius, length) = USUAL;
    let counts = extent.of(&[2, 3, 5, 9, 35, 128, 1024][..], &[2, 9]);
    let counts = counts.iter().map(|&n| (format!("{n} points"), Swept::Points, (n, radius, LONG)));
    let radii = extent.of(&[1e-6, 1e-5, 5e-4][..], &[]);
    let radii = radii.iter().map(|&radius| (format!("radius {} µm", 1e6 * radius), Swept::Radius, (n, radius, length)));
    let lengths = extent.of(&[1e-3, 0.1, 1.0, 10.0][..], &[]);
    let lengths = lengths.iter().map(|&length| (format!("length {length} m"), Swept::Length, (n, radius, length)));
    for (setting, swept, size) in counts.chain(radii).chain(lengths) {
        let mut tips = Vec::new();
        for (place, center) in [("at the origin", 0.0), ("1 km away", 1000.0)] {
            let (tip, felt) = hang(gpu, COUPLINGS[0].1, size, center)?;
            let setting = felt.at(&setting);
            stretched.add(place, &setting, f64::NAN, felt.stretch);
            resets.add(place, &setting, f64::NAN, felt.resets);
            let far = tip.distance(chain_tip(gamma(size), size.0 - 1));
            off[swept as usize].add(place, &setting, swept.of(size), far);
            tips.push(tip);
        }
        moved.add("1 km away", setting, f64::NAN, tips[0].distance(tips[1]));
    }
    let sizes = [
        ("2 points", Swept::Points, (2, radius, SHORT)),
        ("35 points", Swept::Points, USUAL_IN_AIR),
        ("128 points", Swept::Points, (128, radius, SHORT)),
        ("1024 points", Swept::Points, (1024, radius, LONG)),
        ("radius 1 µm, length 1 mm", Swept::Radius, (9, 1e-6, 1e-3)),
        ("radius 500 µm", Swept::Radius, (9, 5e-4, SHORT)),
        // Hair of 40 µm falls through still air at half a metre per second, and would swing out for minutes.
        ("radius 500 µm, length 10 m", Swept::Length, (n, 5e-4, 10.0)),
    ];
    let sizes = extent.of(&sizes[..], &sizes[..1]);
    for (coupling, keys) in extent.of(&COUPLINGS[1..], &COUPLINGS[1..3]) {
        for &(setting, swept, size) in sizes {
            let mut tips = Vec::new();
            for (place, center) in [("at the origin", 0.0), ("1 km away", 1000.0)] {
                if center > 0.0 && size != USUAL_IN_AIR {
                    continue;
                }
                let (tip, felt) = hang(gpu, keys, size, center)?;
                let (series, setting) = (format!("{coupling}, still air, {place}"), felt.at(setting));
                stretched.add(&series, &setting, f64::NAN, felt.stretch);
                resets.add(&series, &setting, f64::NAN, felt.resets);
                let far = tip.distance(chain_tip(gamma(size), size.0 - 1));
                off[swept as usize].add(&series, &setting, swept.of(size), far);
                tips.push(tip);
            }
            if let [here, away] = tips[..] {
                moved.add(format!("{coupling}, still air, 1 km away"), setting, f64::NAN, here.distance(away));
            }
        }
    }
    let off = off.into_iter().filter(|sweep| !sweep.samples.is_empty());
    Ok(off.chain([moved, stretched, resets]).collect())
}

/// Weight over stiffness γ = ρAgL³/EI.
fn gamma((_, radius, length): (usize, f64, f64)) -> f64 {
    4.0 * DENSITY * GRAVITY * length.powi(3) / (MODULUS * radius.powi(2))
}

/// Where the tip of a level strand comes to rest, from its root \[L\].
fn hang(gpu: &Gpu, keys: &[&str], size: (usize, f64, f64), center: f64) -> Result<(DVec3, super::Felt), Error> {
    let (n, radius, length) = size;
    // The slower of the two: a beam's first swing, or a chain's.
    let beam = std::f64::consts::TAU * length.powi(2) / 3.516 * (4.0 * DENSITY / (MODULUS * radius.powi(2))).sqrt();
    let period = beam.min(5.2 * (length / GRAVITY).sqrt());
    let (steps, longest) = if keys.len() > 1 { (STEPS.1, LONGEST.1) } else { (STEPS.0, LONGEST.0) };
    let step = (PERIODS * period / steps as f64).min(longest);
    let corner = |shift: [f64; 3]| shift.map(|x| center + x);
    let text = format!(
        "gravity = [0, {}, 0]\ntime = {{ step = {step}, duration = 1e3 }}\n\
         rods = {{ damping = {} }}\nviscosity = {{ kinematic_hair = 4e-3, kinematic_air = 4e-5 }}\n\
         air = {{ box = {{ min = {:?}, max = {:?} }}, wind = [0, 0, 0] }}\n\
         [hair]\nstrands = 1\npoints = {n}\nlength = {length}\nradius = {radius}\ndensity = {DENSITY}\nyoungs_modulus = {MODULUS}\n\
         roots = {{ center = [{center}, {center}, {center}], radius = 1e-9, direction = [1, 0, 0] }}\n",
        -GRAVITY,
        8.0 / period,
        corner([-0.01, -0.04, -0.014]),
        corner([0.04, 0.01, 0.014]),
    );
    let scene = scene(&text, &[keys])?;
    let mut initial = InitialState::new(&scene)?;
    initial.hair.turn_clamp(0, Rod::level(1.0, n - 1).root_frame);
    let mut simulation = Simulation::with_state(gpu, &scene, initial)?;
    let felt = watch(&mut simulation, 1, (PERIODS * period / step).ceil() as u64, undriven);
    let x = points(&simulation)?;
    Ok(((x[n - 1] - x[0]) / length, felt))
}
