//! Which arrays lie in the same memory: those of which no recording needs two at a time.
//!
//! When an array is needed follows from what was recorded: from the first pass that binds it to the last one, in each
//! recording. An array that is kept ([`Lifetime::Static`], [`Lifetime::Checkpointed`]) lies alone, and so does one that
//! a recording reads before any of its passes wrote it: another recording or the host wrote its contents.
//!
//! Arrays that are read as textures (`textures.rs`) share those in the same way.

use std::{cmp::Reverse, collections::BTreeMap, ops::Range};

use crate::{
    array::{AnyArray, Lifetime},
    recorder::{Command, Recording},
    textures::{self, Reading},
};

/// Where each array lies, by the array's slot.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Aliasing {
    /// The block of memory.
    blocks: Vec<usize>,
    /// The largest array that is read through the same texture, by its slot.
    textures: Vec<usize>,
}

/// Times at which an array is needed: ranges of passes, which are numbered through all recordings.
type Times = Vec<Range<usize>>;

/// Blocks of memory, each with its first array, and when it is needed: `None` takes no other array.
#[derive(Default)]
struct Blocks(Vec<(usize, Option<Times>)>);

impl Blocks {
    /// The block of an array: the first one that is free at these times, or one of its own.
    fn place(&mut self, array: &AnyArray, times: Times, alone: bool) -> usize {
        let apart = |other: &Range<usize>| times.iter().all(|time| other.end <= time.start || time.end <= other.start);
        let free = |(_, taken): &(usize, Option<Times>)| taken.as_ref().is_some_and(|taken| taken.iter().all(apart));
        let found = self.0.iter().position(free).filter(|_| !alone);
        match found.and_then(|block| self.0[block].1.as_mut()) {
            Some(taken) => taken.extend(times),
            None => self.0.push((array.slot(), (!alone).then_some(times))),
        }
        found.unwrap_or(self.0.len() - 1)
    }
}

impl Aliasing {
    /// Every array alone, so that each can be looked at after any pass.
    #[must_use]
    pub fn none(arrays: &[AnyArray]) -> Self {
        let own: Vec<usize> = (0..arrays.len()).collect();
        Self { blocks: own.clone(), textures: own }
    }

    /// Arrays together that none of the recordings needs at the same time: the largest first, each in the first block
    /// where there is room.
    #[must_use]
    pub fn of(arrays: &[AnyArray], recordings: &[Recording]) -> Self {
        let mut aliasing = Self::none(arrays);
        let mut order: Vec<(&AnyArray, Times)> =
            arrays.iter().map(|array| (array, needed(array, recordings))).collect();
        // An array that no pass binds is never needed: it fits anywhere, and comes last.
        order.sort_by_key(|(array, times)| Reverse((!times.is_empty(), array.bytes())));
        let mut blocks = Blocks::default();
        for (array, times) in order {
            let kept = matches!(array.life(), Lifetime::Static | Lifetime::Checkpointed);
            let alone = kept || recordings.iter().any(|recording| comes_from_elsewhere(array, recording));
            aliasing.blocks[array.slot()] = blocks.place(array, times, alone);
        }
        let mut read = read(recordings);
        read.sort_by_key(|reading| Reverse(reading.array.bytes()));
        let mut textures: BTreeMap<u32, Blocks> = BTreeMap::new();
        for Reading { array, texel, times } in read {
            let same = textures.entry(texel).or_default();
            let block = same.place(&array, times, false);
            aliasing.textures[array.slot()] = same.0[block].0;
        }
        aliasing
    }

    /// The block of an array.
    pub(crate) fn block(&self, array: &AnyArray) -> usize {
        self.blocks[array.slot()]
    }

    /// The texture of an array, for those that passes read as textures: the slot of the largest array that is read
    /// through it.
    pub(crate) fn texture(&self, array: &AnyArray) -> usize {
        self.textures[array.slot()]
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

    /// The largest array of each texture that the recordings read.
    pub(crate) fn textures(&self, arrays: &[AnyArray], recordings: &[Recording]) -> Vec<AnyArray> {
        let read: Vec<usize> = read(recordings).iter().map(|reading| self.texture(&reading.array)).collect();
        arrays.iter().filter(|array| read.contains(&array.slot())).copied().collect()
    }

    /// The first pass of a recording, and the array that it binds, where the array's memory was another's since the
    /// array was written.
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

    /// Two arrays that a recording needs in one texture at the same time.
    #[must_use]
    pub fn mixed(&self, recording: &Recording) -> Option<(&'static str, &'static str)> {
        let readings = textures::readings(recording);
        let at_once = |a: &Reading, b: &Reading| {
            a.times.iter().any(|a| b.times.iter().any(|b| a.start < b.end && b.start < a.end))
        };
        let pairs = readings.iter().enumerate().flat_map(|(k, a)| readings[..k].iter().map(move |b| (a, b)));
        let mut mixed = pairs.filter(|(a, b)| self.texture(&a.array) == self.texture(&b.array) && at_once(a, b));
        mixed.next().map(|(a, b)| (a.array.name(), b.array.name()))
    }
}

/// Passes that bind an array, each by its place among those that run.
fn uses<'a>(array: &AnyArray, recording: &'a Recording) -> impl DoubleEndedIterator<Item = (usize, &'a Command)> {
    let slot = array.slot();
    let running: Vec<_> = recording.running().enumerate().collect();
    running.into_iter().filter(move |(_, command)| command.arrays.iter().any(|bound| bound.slot() == slot))
}

/// When an array is needed; never if no pass binds it.
fn needed(array: &AnyArray, recordings: &[Recording]) -> Times {
    let mut times = Vec::new();
    for (recording, before) in numbered(recordings) {
        let mut places = uses(array, recording).map(|(place, _)| before + place);
        let Some(first) = places.next() else { continue };
        let end = match array.life() {
            Lifetime::Transient => places.next_back().unwrap_or(first) + 1,
            Lifetime::Output | Lifetime::Static | Lifetime::Checkpointed => before + recording.running().count(),
        };
        times.push(first..end);
    }
    times
}

/// The arrays that recordings read as textures, and when.
fn read(recordings: &[Recording]) -> Vec<Reading> {
    let mut all: Vec<Reading> = Vec::new();
    for (recording, before) in numbered(recordings) {
        for reading in textures::readings(recording) {
            let times = reading.times.iter().map(|time| before + time.start..before + time.end).collect();
            match all.iter_mut().find(|other| other.array.slot() == reading.array.slot()) {
                Some(other) => other.times.extend::<Times>(times),
                None => all.push(Reading { times, ..reading }),
            }
        }
    }
    all
}

/// Recordings, and the number of passes of those before.
fn numbered(recordings: &[Recording]) -> impl Iterator<Item = (&Recording, usize)> {
    let before = |sum: &mut usize, recording: &Recording| {
        let before = *sum;
        *sum += recording.running().count();
        Some(before)
    };
    recordings.iter().zip(recordings.iter().scan(0, before))
}

/// Whether the first pass that binds an array only reads it.
fn comes_from_elsewhere(array: &AnyArray, recording: &Recording) -> bool {
    let first = uses(array, recording).next();
    first.is_some_and(|(_, command)| {
        let mut bound = command.pass.bindings.iter().zip(&command.arrays);
        bound.any(|(binding, other)| other.slot() == array.slot() && !binding.writes)
    })
}
