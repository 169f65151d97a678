//! Writes down a step: which pass runs over which arrays, and which is left out and why. It needs no GPU.

use std::ops::Range;

use windswept_shaders::{
    Binding, BufferKind, Pass,
    common::{dispatch::WORKGROUP, lanes::LANES},
};

use crate::{
    array::{AnyArray, Index},
    clusters,
    state::{Sizes, State},
};

/// Whether a part of the step is needed, and why.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Decision {
    /// Whether the part runs.
    pub runs: bool,
    /// The reason why it does not, a short clause; empty if it runs.
    pub why: String,
}

impl Decision {
    /// A part that runs.
    pub const YES: Self = Self { runs: true, why: String::new() };

    /// A part that runs if `runs`; `why` explains its absence.
    #[must_use]
    pub fn when(runs: bool, why: impl Into<String>) -> Self {
        Self::unless((!runs).then(|| why.into()))
    }

    /// A part that runs unless there is a reason against it.
    #[must_use]
    pub fn unless(why: Option<impl Into<String>>) -> Self {
        Self { runs: why.is_none(), why: why.map(Into::into).unwrap_or_default() }
    }

    /// This decision if it says no, else the other one.
    #[must_use]
    pub fn and(&self, other: Self) -> Self {
        if self.runs { other } else { self.clone() }
    }
}

/// One pass of the step.
#[derive(Debug, Clone)]
pub struct Command {
    /// Stage of the pass.
    pub stage: &'static str,
    /// Text and bindings of the pass.
    pub pass: &'static Pass,
    /// Label, a short sentence: row in the profile, debug group, name in errors.
    pub label: &'static str,
    /// Number of invocations that are wanted, before any share their work ([`Pass::shares`]).
    pub invocations: u32,
    /// Clusters whose particles the pass goes through, in all pages of the neighbour list; none if it goes through no
    /// clusters.
    pub clusters: Range<u32>,
    /// Arrays that the pass's bindings are bound to, in the order of the bindings.
    pub arrays: Vec<AnyArray>,
    /// Band of eddies that the pass is for, an index into `turbulence.bands`.
    pub band: Option<usize>,
    /// Reason why the pass is left out; `None` if it runs.
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
#[derive(Debug)]
pub struct Recorder<'a> {
    state: &'a State,
    arrays: Vec<AnyArray>,
    recording: Recording,
    stage: &'static str,
    band: Option<usize>,
    skipping: Option<String>,
}

impl<'a> Recorder<'a> {
    /// The recording that `record` writes down, over the arrays of `state`.
    ///
    /// # Panics
    /// When a pass binds a name that no array has, or an array of other elements, or writes one that it binds twice:
    /// mistakes in a fragment, which its first dry run finds.
    #[must_use]
    pub fn record(state: &'a State, record: impl FnOnce(&mut Self)) -> Recording {
        let mut recorder = Self {
            state,
            arrays: state.arrays(),
            recording: Recording::default(),
            stage: "",
            band: None,
            skipping: None,
        };
        record(&mut recorder);
        recorder.recording.commands.iter().for_each(check);
        recorder.recording
    }

    /// Counts of everything that passes run over.
    #[must_use]
    pub fn sizes(&self) -> Sizes {
        self.state.sizes
    }

    /// The arrays, for passes that bind one under another name.
    #[must_use]
    pub fn state(&self) -> &'a State {
        self.state
    }

    /// Begins a stage, in which the next passes stand.
    pub fn stage(&mut self, stage: &'static str) {
        self.stage = stage;
    }

    /// Adds a pass over `invocations` elements. Each of its bindings is bound to the array of its name, but where
    /// [`Bindings::bind`] says otherwise.
    pub fn run(&mut self, pass: &'static Pass, label: &'static str, invocations: u32) -> Bindings<'_> {
        let named = |binding: &Binding| {
            let array = self.arrays.iter().find(|array| array.name() == binding.name).copied().unwrap_or_default();
            if binding.kind == BufferKind::Uniform { array.as_uniform() } else { array }
        };
        let command = Command {
            stage: self.stage,
            pass,
            label,
            invocations,
            clusters: 0..0,
            arrays: pass.bindings.iter().map(named).collect(),
            band: self.band,
            skipped: self.skipping.clone(),
        };
        let commands = &mut self.recording.commands;
        commands.push(command);
        let last = commands.len() - 1;
        Bindings(&mut commands[last..])
    }

    /// Adds a pass over the particles of clusters, which meet their neighbours: once for each page of the neighbour
    /// list that has any of these clusters.
    pub fn dispatch_neighbours(
        &mut self,
        pass: &'static Pass,
        label: &'static str,
        clusters: Range<u32>,
    ) -> Bindings<'_> {
        let (recorded, state) = (self.recording.commands.len(), self.state);
        let pages = state.pages();
        let count = pages.len() as u32;
        let [first, end] = [clusters.start, clusters.end].map(|cluster| (cluster * LANES).div_ceil(WORKGROUP));
        for (page, list) in (0..count).zip(&pages) {
            let before = |workgroups| clusters::workgroups_of_page(workgroups, page, count);
            let workgroups = before(end) - before(first);
            // A pass without clusters, or a skipped one, is recorded once instead of once per page.
            let once = clusters.is_empty() || self.skipping.is_some();
            if (once && page == 0) || (!once && workgroups > 0) {
                let invocations = (workgroups * WORKGROUP).min(LANES * clusters.len() as u32);
                let uniform = state.params.at(Index::new(page as usize));
                self.run(pass, label, invocations).bind("params", &uniform).bind("neighbour_list", list);
            }
        }
        let commands = &mut self.recording.commands[recorded..];
        commands.iter_mut().for_each(|command| command.clusters = clusters.clone());
        Bindings(commands)
    }

    /// Adds passes for one band of eddies, which have rows of their own in the profile.
    pub fn for_band(&mut self, band: usize, record: impl FnOnce(&mut Self)) {
        self.band = Some(band);
        record(self);
        self.band = None;
    }

    /// Adds passes that run if the decision says so, and are otherwise recorded as skipped, with the decision's reason.
    pub fn when(&mut self, decision: &Decision, record: impl FnOnce(&mut Self)) {
        if decision.runs || self.skipping.is_some() {
            record(self);
        } else {
            self.skipping = Some(decision.why.clone());
            record(self);
            self.skipping = None;
        }
    }

    /// Adds passes that run `times` times.
    pub fn repeat(&mut self, times: u32, record: impl Fn(&mut Self)) {
        self.when(&Decision::when(times > 0, "0 iterations"), &record);
        for _ in 1..times {
            if self.skipping.is_none() {
                record(self);
            }
        }
    }
}

/// The bindings of a pass that was just recorded, in all pages of the neighbour list.
#[derive(Debug)]
pub struct Bindings<'a>(&'a mut [Command]);

impl Bindings<'_> {
    /// Binds an array under another name than its own, or one element of an array of uniforms.
    ///
    /// # Panics
    /// When the pass has no binding of that name.
    #[allow(clippy::return_self_not_must_use)] // the last of a chain has done its work
    pub fn bind(self, name: &str, array: &AnyArray) -> Self {
        for command in &mut *self.0 {
            // Names are written in `step/` alone, and no scene changes them: the first recording finds a wrong one.
            let Some(place) = command.pass.bindings.iter().position(|binding| binding.name == name) else {
                panic!("{}: binds no {name}", command.pass.name)
            };
            command.arrays[place] = *array;
        }
        self
    }
}

/// Panics unless the arrays are what the bindings of the pass take, which follows from `step/` and `state.rs` alone: no
/// scene and no driver changes it.
fn check(command: &Command) {
    let pass = command.pass;
    for (binding, array) in pass.bindings.iter().zip(&command.arrays) {
        assert!(*array != AnyArray::default(), "{}: no array is called {}: bind one", pass.name, binding.name);
        assert!(
            u64::from(binding.stride) == array.size(),
            "{}: {} has elements of {} bytes, the array {} of {}",
            pass.name,
            binding.name,
            binding.stride,
            array.name(),
            array.size()
        );
        let bound = command.arrays.iter().filter(|other| other.slot() == array.slot()).count();
        assert!(!binding.writes || bound == 1, "{}: {} is written while bound twice", pass.name, binding.name);
    }
}
