//! Which arrays a recording reads as textures, where passes read textures faster than buffers (`shaders/build/textures.rs`).
//!
//! Such an array has a buffer all the same, which passes write. Before a pass that reads its texture, the buffer is copied there unless
//! the texture has it already. Arrays that a recording does not need as textures at the same time share one.

use std::ops::Range;

use windswept_shaders::{Pass, TEXTURE_ROW};

use crate::{
    array::AnyArray,
    recorder::{Command, Recording},
};

/// A texture of whole rows of texels, each of [`TEXTURE_ROW`] bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct Shape {
    /// Bytes of a texel: 4, 8 or 16.
    pub(crate) texel: u32,
    /// Rows of texels.
    pub(crate) rows: u32,
    /// Number of the texture among those of the same texels and rows.
    pub(crate) number: usize,
}

impl Shape {
    fn new(array: &AnyArray, number: usize) -> Self {
        let texel = array.size().min(16) as u32;
        Self { texel, rows: array.bytes().div_ceil(TEXTURE_ROW.into()) as u32, number }
    }

    /// Size of the texture \[bytes\].
    pub(crate) fn bytes(&self) -> u64 {
        u64::from(TEXTURE_ROW) * u64::from(self.rows)
    }

    /// Texels of a row.
    pub(crate) fn width(&self) -> u32 {
        TEXTURE_ROW / self.texel
    }
}

/// The textures of a recording: for each array that it reads as one, by the array's slot.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Textures(Vec<(AnyArray, Shape)>);

impl Textures {
    /// The textures that those passes of a recording read of which `reads` says that they read any.
    pub(crate) fn of(recording: &Recording, reads: impl Fn(&Pass) -> bool) -> Self {
        let mut needed: Vec<(AnyArray, Range<usize>)> = Vec::new();
        for (place, command) in recording.running().enumerate() {
            for array in read(command).filter(|_| reads(command.pass)) {
                match needed.iter_mut().find(|(other, _)| other.slot() == array.slot()) {
                    Some((_, times)) => times.end = place + 1,
                    None => needed.push((*array, place..place + 1)),
                }
            }
        }
        let mut taken: Vec<(Shape, Range<usize>)> = Vec::new();
        let mut place = |(array, times): (AnyArray, Range<usize>)| {
            let free = |shape: &Shape| {
                let mut same = taken.iter().filter(|(other, _)| other == shape);
                same.all(|(_, other)| other.end <= times.start || times.end <= other.start)
            };
            let shape = (0..).map(|number| Shape::new(&array, number)).find(free);
            let shape = shape.unwrap_or_else(|| Shape::new(&array, 0));
            taken.push((shape, times));
            (array, shape)
        };
        Self(needed.into_iter().map(&mut place).collect())
    }

    /// The texture of an array.
    pub(crate) fn shape(&self, array: &AnyArray) -> Option<Shape> {
        self.0.iter().find(|(other, _)| other.slot() == array.slot()).map(|(_, shape)| *shape)
    }

    /// Every texture, once.
    pub(crate) fn shapes(&self) -> Vec<Shape> {
        let mut shapes: Vec<Shape> = Vec::new();
        for (_, shape) in &self.0 {
            if !shapes.contains(shape) {
                shapes.push(*shape);
            }
        }
        shapes
    }

    /// For each pass that runs, the arrays that are copied to their textures before it.
    pub(crate) fn copies(&self, recording: &Recording) -> Vec<Vec<AnyArray>> {
        // Which array each texture has, by slot.
        let mut has: Vec<(Shape, usize)> = Vec::new();
        let mut before = |command: &Command| {
            let mut copied = Vec::new();
            for array in read(command) {
                let Some(shape) = self.shape(array) else { continue };
                if !has.contains(&(shape, array.slot())) {
                    has.retain(|(other, _)| *other != shape);
                    has.push((shape, array.slot()));
                    copied.push(*array);
                }
            }
            for (binding, array) in command.pass.bindings.iter().zip(&command.arrays) {
                if binding.writes {
                    has.retain(|(_, slot)| *slot != array.slot());
                }
            }
            copied
        };
        recording.running().map(&mut before).collect()
    }
}

/// The arrays that a pass reads as textures.
fn read(command: &Command) -> impl Iterator<Item = &AnyArray> {
    let bound = command.pass.bindings.iter().zip(&command.arrays);
    bound.filter(|(binding, _)| binding.texture).map(|(_, array)| array)
}
