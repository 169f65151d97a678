//! Status word and counters of the GPU, read by the host (`shaders/common/status.wgsl`).

use std::collections::BTreeMap;

use windswept_scene::Warning;
use windswept_shaders::common::status::{
    AIR_BESIDE, BY_RESET, BY_UPDATE, CONFINEMENT_LIMITED, EULER_STEP, EXCHANGE_LIMITED, HAIR_OUTSIDE, OVER_STRAINED,
    SLEEPING_STEP, STRAND_RESET, Status, TELEPORT, UNSOLVED_STEP,
};

/// Counters of what a user should know: codes of the report's `warnings`, and what each counts.
const WARNINGS: [(u32, &str, &str); 6] = [
    (STRAND_RESET, "strand_reset", "times that a strand was not finite and was put into its rest shape"),
    (OVER_STRAINED, "over_strained", "strands of which a segment was 5 % too long or too short for 50 steps on end"),
    (
        TELEPORT,
        "teleported",
        "times that the root of a strand went farther in a step than the strand is long: the strand went with it as \
        it was, without \
         wind or weight; a shorter time.step follows the root",
    ),
    (
        HAIR_OUTSIDE,
        "hair_outside_box",
        "steps in which more than 5 % of the hair had been outside the box of air for 0.1 s",
    ),
    (
        EXCHANGE_LIMITED,
        "exchange_limited",
        "times that the drag between a hair point and its air was limited, so as not to overshoot",
    ),
    (
        AIR_BESIDE,
        "air_beside_bodies",
        "steps in which air beside bodies went farther than 1.2 particle spacings, or had a density error of more \
        than 0.06 rms for 20 ms: a \
         larger time.substeps follows these bodies",
    ),
];
/// Key of the strand steps that the direct solver did not solve, and the words of a warning of many.
const UNSOLVED: (&str, &str) = (
    "unsolved_steps",
    "steps of strands that had not settled after rods.newton Newton steps, more than one in a hundred of all: these \
    strands lag behind; a \
     shorter time.step follows this wind or these roots",
);
/// Strand steps of which one may go unsolved unmentioned: such a strand lags behind.
const FEW: u64 = 100;
/// Counters of how strands were stepped; keys of the report's `strand_steps`.
const STRAND_STEPS: [(u32, &str); 4] = [
    (EULER_STEP, "euler_steps"),
    (SLEEPING_STEP, "sleeping_steps"),
    (TELEPORT, "teleports"),
    (UNSOLVED_STEP, UNSOLVED.0),
];

/// The status of a run that has not begun.
#[must_use]
pub fn start() -> Status {
    Status { first_bad: u32::MAX, first_bad_air: u32::MAX, ..Status::default() }
}

/// The status with which a frozen step is run again.
#[must_use]
pub fn thawed(status: &Status) -> Status {
    Status {
        causes: 0,
        ended: 0,
        neighbours: 0,
        neighbour_carries: 0,
        failed_strands: 0,
        first_bad: u32::MAX,
        first_bad_air: u32::MAX,
        stretch: 0,
        inspected: 0,
        hair_outside: 0,
        path_beside: 0,
        wind: status.wind_before,
        counting: Status::default().counting,
        ..*status
    }
}

/// Elements that the longest page of the neighbour list needs in this step.
#[must_use]
pub fn neighbours_needed(status: &Status) -> u64 {
    u64::from(status.neighbour_carries) << 32 | u64::from(status.neighbours)
}

/// The hair point that `first` names, and the pass that found it not finite.
#[must_use]
pub fn bad_point(first: u32) -> (usize, &'static str) {
    let pass = match first % 4 {
        BY_RESET => "forcing/reset",
        BY_UPDATE => "rods/update",
        _ => "commit/hold",
    };
    ((first / 4) as usize, pass)
}

/// max |l/l0 − 1| over the run.
#[must_use]
pub fn max_stretch(status: &Status) -> f32 {
    f32::from_bits(status.max_stretch)
}

/// A warning for each cause that acted in a run of so many strand steps.
#[must_use]
pub fn warnings(status: &Status, strand_steps: u64) -> Vec<Warning> {
    let counted = |counter: u32| u64::from(status.counted[counter as usize]);
    let unsolved = Some(counted(UNSOLVED_STEP)).filter(|unsolved| unsolved * FEW > strand_steps).unwrap_or_default();
    let rows = WARNINGS.iter().map(|(counter, code, text)| (counted(*counter), *code, *text));
    let rows = rows.chain([(unsolved, UNSOLVED.0, UNSOLVED.1)]).filter(|(count, ..)| *count > 0);
    rows.map(|(count, code, text)| Warning { count, ..Warning::new(code, "", text) }).collect()
}

/// How many steps of strands went otherwise than by a solve of the integrator asked for, by how; 2³² − 1 at most.
#[must_use]
pub fn strand_steps(status: &Status) -> BTreeMap<String, u64> {
    STRAND_STEPS.iter().map(|(counter, key)| ((*key).to_owned(), status.counted[*counter as usize].into())).collect()
}

/// Steps in which the limit of the confinement acted on some particle; 2³² − 1 at most.
#[must_use]
pub fn confinement_limited_steps(status: &Status) -> u64 {
    status.counted[CONFINEMENT_LIMITED as usize].into()
}
