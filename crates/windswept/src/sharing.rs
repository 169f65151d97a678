//! Which arrays lie in the same memory: those of which no recording needs two at a time.
//!
//! When an array is needed follows from what was recorded: from the first pass that binds it to the last one, in each recording.
//! An array that is kept ([`Life::Kept`], [`Life::Lasting`]) lies alone, and so does one that a recording reads before any of its passes wrote it:
//! what it holds came from elsewhere.

use std::{cmp::Reverse, ops::Range};

use crate::{
    array::{AnyArray, Life},
    recorder::{Command, Recording},
};

/// A block of memory for each array, by the array's slot.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Sharing {
    blocks: Vec<usize>,
}

impl Sharing {
    /// Every array alone, so that each can be looked at after any pass.
    #[must_use]
    pub fn none(arrays: &[AnyArray]) -> Self {
        Self { blocks: (0..arrays.len()).collect() }
    }

    /// Arrays together that none of the recordings needs at the same time: the largest first, each in the first block where there is
    /// room.
    #[must_use]
    pub fn of(arrays: &[AnyArray], recordings: &[Recording]) -> Self {
        let needed = |array: &AnyArray| recordings.iter().map(|recording| needed(array, recording)).collect::<Vec<_>>();
        let mut order: Vec<(&AnyArray, Vec<Range<usize>>)> =
            arrays.iter().map(|array| (array, needed(array))).collect();
        // What no pass binds is never needed: it fits anywhere, and comes last.
        order.sort_by_key(|(array, times)| Reverse((times.iter().any(|time| !time.is_empty()), array.bytes())));
        let mut blocks = vec![0; arrays.len()];
        // When each block is needed; a block of one array takes no other.
        let mut taken: Vec<Option<Vec<Vec<Range<usize>>>>> = Vec::new();
        for (array, times) in order {
            let apart = |other: &Vec<Range<usize>>| {
                other
                    .iter()
                    .zip(&times)
                    .all(|(a, b)| a.is_empty() || b.is_empty() || a.end <= b.start || b.end <= a.start)
            };
            let kept = matches!(array.life(), Life::Kept | Life::Lasting);
            let alone = kept || recordings.iter().any(|recording| comes_from_elsewhere(array, recording));
            let free = |block: &Option<Vec<_>>| block.as_ref().is_some_and(|others| others.iter().all(apart));
            let found = taken.iter().position(free).filter(|_| !alone);
            blocks[array.slot()] = found.unwrap_or(taken.len());
            match found.and_then(|block| taken[block].as_mut()) {
                Some(others) => others.push(times),
                None => taken.push((!alone).then(|| vec![times])),
            }
        }
        Self { blocks }
    }

    /// The block of an array.
    pub(crate) fn block(&self, array: &AnyArray) -> usize {
        self.blocks[array.slot()]
    }

    /// Whether no other array lies in the block of this one.
    #[must_use]
    pub fn is_alone(&self, array: &AnyArray) -> bool {
        self.blocks.iter().filter(|block| **block == self.block(array)).count() == 1
    }

    /// The largest array of each block, which says how large the block is.
    #[must_use]
    pub fn largest(&self, arrays: &[AnyArray]) -> Vec<AnyArray> {
        let blocks = self.blocks.iter().max().map_or(0, |last| last + 1);
        let of = |block: usize| {
            let inside = arrays.iter().filter(|array| self.block(array) == block);
            inside.copied().max_by_key(|array| (array.bytes(), Reverse(array.slot())))
        };
        (0..blocks).filter_map(of).collect()
    }

    /// Size of all blocks together \[bytes\].
    #[must_use]
    pub fn bytes(&self, arrays: &[AnyArray]) -> u64 {
        self.largest(arrays).iter().map(AnyArray::bytes).sum()
    }

    /// The first pass of a recording, and the array that it binds, where the array's memory was another's since the array was
    /// written.
    #[must_use]
    pub fn overwritten(&self, recording: &Recording) -> Option<(&'static str, &'static str)> {
        let mut written = vec![false; self.blocks.len()];
        let mut owners: Vec<Option<usize>> = vec![None; self.blocks.len()];
        for command in recording.running() {
            for (binding, array) in command.pass.bindings.iter().zip(&command.arrays) {
                if self.is_alone(array) {
                    continue;
                }
                let (slot, owner) = (array.slot(), &mut owners[self.block(array)]);
                let holds = if written[slot] { *owner == Some(slot) } else { binding.writes };
                if !holds {
                    return Some((command.pass.name, array.name()));
                }
                (written[slot], *owner) = (true, Some(slot));
            }
        }
        None
    }
}

/// Passes that bind an array, each by its place among those that run.
fn uses<'a>(array: &AnyArray, recording: &'a Recording) -> impl DoubleEndedIterator<Item = (usize, &'a Command)> {
    let slot = array.slot();
    let running: Vec<_> = recording.running().enumerate().collect();
    running.into_iter().filter(move |(_, command)| command.arrays.iter().any(|bound| bound.slot() == slot))
}

/// Passes of a recording that an array is needed for; none if no pass binds it.
fn needed(array: &AnyArray, recording: &Recording) -> Range<usize> {
    let mut places = uses(array, recording).map(|(place, _)| place);
    let Some(first) = places.next() else { return 0..0 };
    match array.life() {
        Life::Scratch => first..places.next_back().unwrap_or(first) + 1,
        Life::Left | Life::Kept | Life::Lasting => first..usize::MAX,
    }
}

/// Whether the first pass that binds an array only reads it.
fn comes_from_elsewhere(array: &AnyArray, recording: &Recording) -> bool {
    let first = uses(array, recording).next();
    first.is_some_and(|(_, command)| {
        let mut bound = command.pass.bindings.iter().zip(&command.arrays);
        bound.any(|(binding, other)| other.slot() == array.slot() && !binding.writes)
    })
}
