//! Writes down a step: which pass runs over which arrays, and which is left out and why. No GPU.

use windswept_shaders::{Access, Pass};

use crate::state::Array;

/// Whether a part of the step is needed, and why.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Decision {
    /// Whether it runs.
    pub runs: bool,
    /// The reason, a short clause.
    pub why: String,
}

impl Decision {
    /// A part that runs if `runs`; `why` explains its absence.
    #[must_use]
    pub fn when(runs: bool, why: impl Into<String>) -> Self {
        Self { runs, why: why.into() }
    }

    /// This one if it says no, else the other.
    #[must_use]
    pub fn and(&self, other: Self) -> Self {
        if self.runs { other } else { self.clone() }
    }
}

/// One pass of the step.
#[derive(Debug, Clone)]
pub struct Command {
    /// The heading it stands under.
    pub heading: &'static str,
    /// Its text and bindings.
    pub pass: &'static Pass,
    /// A short sentence: its row in the profile, its debug group, its name in errors.
    pub label: &'static str,
    /// Invocations that are wanted.
    pub invocations: u32,
    /// Its buffers, in the order of the pass's bindings.
    pub arrays: Vec<Array>,
    /// The band of eddies that it is for, an index into `turbulence.bands`.
    pub band: Option<usize>,
    /// Why it is left out; `None`: it runs.
    pub skipped: Option<String>,
}

/// A recorded step, in execution order, skipped passes included.
#[derive(Debug, Clone, Default)]
pub struct Recording {
    /// The passes.
    pub commands: Vec<Command>,
}

impl Recording {
    /// The passes that run.
    pub fn running(&self) -> impl Iterator<Item = &Command> {
        self.commands.iter().filter(|command| command.skipped.is_none())
    }
}

/// Collects a [`Recording`].
#[derive(Debug, Default)]
pub struct Recorder {
    recording: Recording,
    heading: &'static str,
    band: Option<usize>,
    skipping: Option<String>,
}

impl Recorder {
    /// What `record` records.
    #[must_use]
    pub fn record(record: impl FnOnce(&mut Self)) -> Recording {
        let mut recorder = Self::default();
        record(&mut recorder);
        recorder.recording
    }

    /// The heading under which the next passes stand.
    pub fn heading(&mut self, heading: &'static str) {
        self.heading = heading;
    }

    /// One pass over `invocations` elements.
    ///
    /// # Panics
    /// When the arrays are not those of the pass's bindings: a mistake in a fragment, found by the first dry run.
    pub fn run(&mut self, pass: &'static Pass, label: &'static str, invocations: u32, arrays: &[&Array]) {
        check(pass, arrays);
        self.recording.commands.push(Command {
            heading: self.heading,
            pass,
            label,
            invocations,
            arrays: arrays.iter().map(|&array| array.clone()).collect(),
            band: self.band,
            skipped: self.skipping.clone(),
        });
    }

    /// Passes for one band of eddies: the profile has rows of its own for each.
    pub fn for_band(&mut self, band: usize, record: impl FnOnce(&mut Self)) {
        self.band = Some(band);
        record(self);
        self.band = None;
    }

    /// Passes that run if the decision says so; otherwise they are recorded as skipped, with its reason.
    pub fn when(&mut self, decision: &Decision, record: impl FnOnce(&mut Self)) {
        if decision.runs || self.skipping.is_some() {
            record(self);
        } else {
            self.skipping = Some(decision.why.clone());
            record(self);
            self.skipping = None;
        }
    }

    /// Passes that run `times` times.
    pub fn repeat(&mut self, times: u32, record: impl Fn(&mut Self)) {
        self.when(&Decision::when(times > 0, "0 iterations"), &record);
        for _ in 1..times {
            if self.skipping.is_none() {
                record(self);
            }
        }
    }
}

/// Count, order (by name), element size and access of the arrays against what naga read out of the pass.
fn check(pass: &Pass, arrays: &[&Array]) {
    let wanted: Vec<_> = pass.bindings.iter().map(|binding| binding.name).collect();
    let given: Vec<_> = arrays.iter().map(|array| array.name).collect();
    assert!(wanted == given, "{}: binds {wanted:?}, was given {given:?}", pass.name);
    for (binding, array) in pass.bindings.iter().zip(arrays) {
        assert!(
            u64::from(binding.stride) == array.stride,
            "{}: {} has elements of {} bytes, the array of {}",
            pass.name,
            binding.name,
            binding.stride,
            array.stride
        );
        let writers = arrays.iter().filter(|other| other.slot == array.slot).count();
        assert!(
            binding.access != Access::ReadWrite || writers == 1,
            "{}: {} is written while bound twice",
            pass.name,
            binding.name
        );
    }
}
