//! Which arrays passes read as textures on a software adapter (`shaders/build/software.rs`).
//!
//! Such an array has a buffer all the same, which passes write. It is copied to its texture before the first pass that
//! reads it there, and again before the next one that does after a pass has written it. A texture is whole rows of
//! texels. Arrays that are not needed as textures at the same time share one (`aliasing.rs`).

use std::ops::Range;

use windswept_shaders::{Bound, TEXTURE_ROW};

use crate::{array::AnyArray, recorder::Recording};

/// An array that a recording reads as a texture.
#[derive(Debug)]
pub(crate) struct Reading {
    pub(crate) array: AnyArray,
    /// Bytes of a texel.
    pub(crate) texel: u32,
    /// When it is in the texture: from a pass before which it is copied there to the last one that reads that copy, by
    /// their places among the passes that run.
    pub(crate) times: Vec<Range<usize>>,
}

/// The arrays that a recording reads as textures.
pub(crate) fn readings(recording: &Recording) -> Vec<Reading> {
    let mut all: Vec<Reading> = Vec::new();
    // Slots of the arrays whose textures have what their buffers have.
    let mut there: Vec<usize> = Vec::new();
    for (place, command) in recording.running().enumerate() {
        let bound = || command.pass.bindings.iter().zip(&command.arrays);
        for (binding, array) in bound() {
            let Bound::Texture { texel } = binding.in_software else { continue };
            let known = all.iter().position(|reading| reading.array.slot() == array.slot());
            let at = known.unwrap_or_else(|| {
                all.push(Reading { array: *array, texel, times: Vec::new() });
                all.len() - 1
            });
            if !there.contains(&array.slot()) {
                there.push(array.slot());
                all[at].times.push(place..place);
            }
            all[at].times.last_mut().into_iter().for_each(|time| time.end = place + 1);
        }
        for (_, array) in bound().filter(|(binding, _)| binding.writes) {
            there.retain(|slot| *slot != array.slot());
        }
    }
    all
}

/// Rows of the texture that holds an array: no power of two. Mesa's software driver compiles a pass for textures whose
/// height is one, and again for those whose height is none, so that the passes of another simulation would be compiled
/// anew.
pub(crate) fn rows(array: &AnyArray) -> u64 {
    let rows = array.bytes().div_ceil(TEXTURE_ROW.into());
    if rows.is_power_of_two() { (rows | 1).max(3) } else { rows }
}

/// Size of the texture that holds an array \[bytes\].
pub(crate) fn bytes(array: &AnyArray) -> u64 {
    rows(array) * u64::from(TEXTURE_ROW)
}
