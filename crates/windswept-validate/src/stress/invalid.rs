//! A value in the buffers that is not finite, or absurd: its strand alone is reset.

use windswept_engine::{Gpu, Simulation};
use windswept_shaders::common::rod::INVALID;

use super::{COUPLINGS, Extent, USUAL, WIND, differing_bytes, points, reason, stretch};
use crate::{Error, Sweep};

pub(super) const SWEPT: &str =
    "one x, v or q of a strand set to NaN or 1e30 in the buffer; each model and fluid solver";

/// Steps before, and after.
const BEFORE: u64 = 20;
const AFTER: u64 = 20;
/// Strand that is invalid, and which of its points and segments.
const STRAND: usize = 2;
const PLACE: usize = 4;

/// Array that is invalid.
#[derive(Debug, Clone, Copy)]
enum Spoilt {
    Position,
    Velocity,
    Orientation,
}

const ARRAYS: [(&str, Spoilt); 3] = [("x", Spoilt::Position), ("v", Spoilt::Velocity), ("q", Spoilt::Orientation)];

pub(super) fn sweeps(gpu: &Gpu, extent: Extent) -> Result<Vec<Sweep>, Error> {
    let mut resets = Sweep::new("resets, off one that names the strand", 0.0, "");
    let mut others = Sweep::new("bytes of the state that differ from where the strand is reset by hand", 0.0, "");
    let mut whole = Sweep::new("stretch 20 steps later", 0.01, "");
    for coupling in extent.of(&COUPLINGS[..], &USUAL[..]) {
        for (name, array) in &ARRAYS {
            for value in extent.of(&[f32::NAN, 1e30][..], &[f32::NAN]) {
                let setting = format!("{name} = {value:e}");
                let mut invalid = Simulation::new(gpu, &coupling.tuft(WIND))?;
                let mut by_hand = Simulation::new(gpu, &coupling.tuft(WIND))?;
                invalid.step(BEFORE)?;
                by_hand.step(BEFORE)?;
                spoil(&invalid, *array, *value)?;
                reset(&by_hand)?;
                let ended = invalid.step(AFTER).err().map(|error| format!(": {}", reason(&error))).unwrap_or_default();
                by_hand.step(AFTER)?;
                let setting = setting + &ended;
                let named =
                    invalid.resets().iter().filter(|reset| reset.strands == 1 && reset.named == [STRAND as u32]);
                let (named, all) = (named.count() as f64, super::resets(&invalid));
                resets.add(coupling.name, &setting, f64::NAN, (named - 1.0).abs().max((all - 1.0).abs()));
                let (arrays, bytes) = differing(&invalid, &by_hand)?;
                others.add(coupling.name, format!("{setting}{arrays}"), f64::NAN, bytes as f64);
                let stretch = stretch(&invalid.initial().hair, &points(&invalid)?);
                whole.add(coupling.name, &setting, f64::NAN, stretch);
            }
        }
    }
    Ok(vec![resets, others, whole])
}

fn spoil(simulation: &Simulation, array: Spoilt, value: f32) -> Result<(), Error> {
    let (engine, hair) = (simulation.engine(), &simulation.initial().hair);
    let state = engine.state();
    let (array, at) = match array {
        Spoilt::Position => (&state.position, hair.points(STRAND).start + PLACE),
        Spoilt::Velocity => (&state.velocity, hair.points(STRAND).start + PLACE),
        Spoilt::Orientation => (&state.orientation, hair.segments(STRAND).start + PLACE),
    };
    let mut rows = engine.read(array)?;
    rows[at][0] = value;
    Ok(engine.write(array, &rows)?)
}

/// Says that the strand is invalid: the next step puts it into its rest shape, and counts it.
fn reset(simulation: &Simulation) -> Result<(), Error> {
    let engine = simulation.engine();
    let mut strands = engine.read(&engine.state().strand_history)?;
    strands[STRAND].condition.failed = INVALID;
    Ok(engine.write(&engine.state().strand_history, &strands)?)
}

/// Names of the arrays of the state whose bytes differ, and the number of these bytes. Only the point that was found
/// invalid is left out.
fn differing(one: &Simulation, other: &Simulation) -> Result<(String, usize), Error> {
    let (a, b) = (one.engine(), other.engine());
    let (mut names, mut bytes) = (String::new(), 0);
    let mut found = b.status()?;
    found.reset_first = a.status()?.reset_first;
    b.set_status(&found)?;
    for array in a.state().lasting() {
        let differing = differing_bytes(&a.read_bytes(&array)?, &b.read_bytes(&array)?);
        if differing > 0 {
            names += &format!(", {}", array.name());
        }
        bytes += differing;
    }
    Ok((names, bytes))
}
