//! Strands that are none: an error that names them; and strands that start far from any shape of theirs: whole again
//! soon.

use glam::DVec3;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use windswept_engine::{Gpu, Simulation};
use windswept_scene::{Groom, InitialState};

use super::{COUPLINGS, Extent, USUAL, WIND, points, stretch};
use crate::{Error, Sweep};

pub(super) const SWEPT: &str = "a zero-length edge, doubled points, a strand of 2 points, all points in one; a random tangle of 0.4 to 2 \
    lengths of the strand, one point 1 to 30 lengths away, strands that fold back upward, all points pulled into one; each model and fluid \
    solver";

const STEPS: u64 = 20;
/// Points of a strand, and its length \[m\].
const POINTS: usize = 9;
const LENGTH: f64 = 0.05;

pub(super) fn sweeps(gpu: &Gpu, extent: Extent) -> Result<Vec<Sweep>, Error> {
    let mut refused = Sweep::new("faulty grooms that are not refused with the strand's number", 0.0, "");
    let mut whole = Sweep::new("stretch after 20 steps", 0.01, "");
    for coupling in extent.of(&COUPLINGS[..], &USUAL[..]) {
        let scene = coupling.tuft(WIND);
        for (fault, row) in grooms() {
            let groom = two(&row);
            let said = match InitialState::with_groom(&scene, &groom) {
                Err(error) => f64::from(u8::from(!error.to_string().contains("strand 1"))),
                Ok(_) => 1.0,
            };
            refused.add(coupling.name, fault, f64::NAN, said);
        }
        let shortest = two(&[[0.021, 0.055, 0.014], [0.021, 0.005, 0.014]]);
        let mut simulation = Simulation::with_groom(gpu, &scene, &shortest)?;
        let after = largest_stretch(&mut simulation, None);
        whole.add(coupling.name, "a strand of 2 points", f64::NAN, after.unwrap_or(f64::NAN));
        for (start, place) in STARTS {
            let mut simulation = Simulation::new(gpu, &scene)?;
            let after = largest_stretch(&mut simulation, Some(place));
            whole.add(coupling.name, *start, f64::NAN, after.unwrap_or(f64::NAN));
        }
    }
    Ok(vec![refused, whole])
}

/// Faults, each with the points of a strand that has it.
fn grooms() -> [(&'static str, Vec<[f64; 3]>); 3] {
    let straight: Vec<_> = (0..POINTS).map(|k| [0.021, 0.055 - LENGTH * k as f64 / 8.0, 0.014]).collect();
    let mut zero = straight.clone();
    zero[4] = zero[3];
    let doubled = straight.iter().flat_map(|x| [*x, *x]).collect();
    [("a zero-length edge", zero), ("doubled points", doubled), ("all points in one", vec![straight[0]; POINTS])]
}

/// A sound strand, and this one.
fn two(row: &[[f64; 3]]) -> Groom {
    let sound = (0..POINTS).map(|k| [0.019, 0.055 - LENGTH * k as f64 / 8.0, 0.014]);
    let points: Vec<_> = sound.chain(row.iter().copied()).collect();
    let offsets = vec![0, POINTS as u32, points.len() as u32];
    Groom::new(points, offsets)
}

/// A place for point `k` of a strand with this root.
type Place = fn(DVec3, usize, &mut Pcg64) -> DVec3;

/// Starts that tear strands.
const STARTS: &[(&str, Place)] = &[
    ("a random tangle of 0.4 L", |root, _, rng| tangled(root, 0.4, rng)),
    ("a random tangle of 1 L", |root, _, rng| tangled(root, 1.0, rng)),
    ("a random tangle of 2 L", |root, _, rng| tangled(root, 2.0, rng)),
    ("one point 1 L away", |root, k, _| away(root, k, 1.0)),
    ("one point 10 L away", |root, k, _| away(root, k, 10.0)),
    ("one point 30 L away", |root, k, _| away(root, k, 30.0)),
    ("an upside-down zigzag", |root, k, _| {
        root + LENGTH / 8.0 * DVec3::new(0.3 * f64::from(u8::from(k % 2 == 1)), 0.9 * k as f64, 0.0)
    }),
    ("folded back and forth", |root, k, _| root - DVec3::Y * LENGTH / 8.0 * f64::from(u8::from(k % 2 == 1))),
    ("all points pulled into one", |root, _, _| root),
];

/// A place in a box about the root, within so many lengths of the strand along each axis.
fn tangled(root: DVec3, lengths: f64, rng: &mut Pcg64) -> DVec3 {
    root + lengths * LENGTH * (2.0 * DVec3::from_array(rng.random()) - 1.0)
}

/// Point `k` of a strand that hangs, whose middle point is so many lengths of the strand off.
fn away(root: DVec3, k: usize, lengths: f64) -> DVec3 {
    let off = if k == POINTS / 2 { lengths * LENGTH } else { 0.0 };
    root + DVec3::new(off, -LENGTH / 8.0 * k as f64, 0.0)
}

/// Stretch of the strands 20 steps after their points were put somewhere.
fn largest_stretch(simulation: &mut Simulation, place: Option<&Place>) -> Result<f64, Error> {
    let mut rng = Pcg64::seed_from_u64(5);
    let hair = simulation.initial().hair.clone();
    if let Some(place) = place {
        let put = (0..hair.len()).flat_map(|s| {
            let root = hair.positions[hair.points(s).start];
            (0..hair.points(s).len()).map(move |k| (root, k))
        });
        let put: Vec<DVec3> = put.map(|(root, k)| place(root, k, &mut rng)).collect();
        simulation.set_hair(Some(&put), Some(&vec![DVec3::ZERO; put.len()]), None)?;
    }
    simulation.step(STEPS)?;
    Ok(stretch(&hair, &points(simulation)?))
}
