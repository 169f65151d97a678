//! The status word and counters that the GPU keeps (`shaders/common/status.wgsl`), and what the host makes of them.

use std::{collections::BTreeMap, mem::offset_of};

use bytemuck::{Pod, Zeroable};
use windswept_shaders::layout;

use crate::params::assert_layout;

/// The neighbour list is too short (`neighbours` exceeds its capacity): the host grows it and replays.
pub const NEIGHBOUR_OVERFLOW: u32 = 1;
/// Air became non-finite: the run ends.
pub const NON_FINITE_AIR: u32 = 2;
/// Too many strands became non-finite in one step: the run ends.
pub const TOO_MANY_BAD_STRANDS: u32 = 4;

/// Names of the counters, in the order of `counted`.
pub const COUNTERS: [&str; 10] = [
    "strand_reset",
    "move_capped",
    "over_strained",
    "hair_outside_box",
    "confinement_limited",
    "euler_steps",
    "quiet_steps",
    "asleep_steps",
    "teleports",
    "rescued_steps",
];
/// So many of them, the first, are keys of the report's `warnings`; the others of its `strand_steps`.
const WARNINGS: usize = 5;

/// `Status`, field by field.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct Status {
    pub causes: u32,
    pub step: u32,
    pub neighbours: u32,
    pub neighbour_carries: u32,
    pub bad_strands: u32,
    pub first_bad_strand: u32,
    pub first_bad_air: u32,
    pub max_stretch: u32,
    pub hair_outside: u32,
    pub outside_steps: u32,
    pub wind: [f32; 3],
    pub wind_before: [f32; 3],
    pub way: [f32; 3],
    pub counted: [u32; 10],
    pub counting: [u32; 10],
}

assert_layout!(Status {
    causes,
    step,
    neighbours,
    neighbour_carries,
    bad_strands,
    first_bad_strand,
    first_bad_air,
    max_stretch,
    hair_outside,
    outside_steps,
    wind,
    wind_before,
    way,
    counted,
    counting,
});

impl Status {
    /// At the start.
    #[must_use]
    pub fn start() -> Self {
        Self { first_bad_strand: u32::MAX, first_bad_air: u32::MAX, ..Self::zeroed() }
    }

    /// The same step again, thawed.
    #[must_use]
    pub fn thawed(self) -> Self {
        Self {
            causes: 0,
            neighbours: 0,
            neighbour_carries: 0,
            bad_strands: 0,
            first_bad_strand: u32::MAX,
            hair_outside: 0,
            wind: self.wind_before,
            counting: [0; 10],
            ..self
        }
    }

    /// Entries that the neighbour list needs in this step.
    #[must_use]
    pub fn neighbours_needed(&self) -> u64 {
        u64::from(self.neighbour_carries) << 32 | u64::from(self.neighbours)
    }

    /// max |l/l0 − 1| over the run.
    #[must_use]
    pub fn max_stretch(&self) -> f32 {
        f32::from_bits(self.max_stretch)
    }

    /// What was counted, by cause; causes that never acted are left out.
    #[must_use]
    pub fn warnings(&self) -> BTreeMap<String, u64> {
        self.named(0..WARNINGS).filter(|(_, count)| *count > 0).collect()
    }

    /// How many steps of strands went otherwise than by a solve of the integrator asked for, by how; 2³² − 1 at most.
    #[must_use]
    pub fn strand_steps(&self) -> BTreeMap<String, u64> {
        self.named(WARNINGS..COUNTERS.len()).collect()
    }

    fn named(&self, which: std::ops::Range<usize>) -> impl Iterator<Item = (String, u64)> {
        let counted = self.counted;
        which.map(move |i| (COUNTERS[i].to_owned(), u64::from(counted[i])))
    }
}
