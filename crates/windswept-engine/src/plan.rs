//! The plan as a table: the passes of a step and the buffers that they work on, without a GPU.

use std::ops::Range;

use windswept_scene::{CheckedScene, InitialState, SceneError};
use windswept_shaders::{Binding, Operations};

use crate::{
    aliasing::Aliasing,
    array::AnyArray,
    engine::first_sizes,
    recorder::{Command, Recorder},
    setup::Setup,
    state::State,
    step::{self, Plan},
    textures,
};

/// A row of `windswept plan`: a pass of the step.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PlanRow {
    /// The stage of the step.
    pub stage: &'static str,
    /// The pass, `folder/name`.
    pub pass: &'static str,
    /// Purpose of the pass, in a few words.
    pub label: &'static str,
    /// Which of `turbulence.bands` it is for.
    pub band: Option<usize>,
    /// How often it runs in a substep.
    pub runs: u32,
    /// Number of invocations that a substep asks for, of all its [`Self::runs`] together. A text whose invocations
    /// share the work runs more ([`Pass::shares`](windswept_shaders::Pass::shares)).
    pub invocations: u64,
    /// Operations of each of these invocations.
    pub operations: Operations,
    /// Clusters of particles that it goes through, each with its neighbours, by their numbers: those of hair come
    /// first. None if it goes through no clusters.
    pub clusters: Range<u32>,
    /// Memory traffic of all its [`Self::runs`] together \[bytes\], by a simple model: an array that the pass reads is
    /// read once as a whole, one that it writes is written once, and one that it does both with counts twice. Caches
    /// are taken to catch whatever is read again, and the neighbour list is taken to be as long as it is at the start
    /// of a run. A pass that looks at a part of an array moves less, one whose reads miss the caches moves more.
    pub bytes: u64,
    /// Why it does not run.
    pub skipped: Option<String>,
    /// Buffers that it reads and writes.
    pub uses: Uses,
}

/// Arrays that a pass reads and writes, as `windswept plan --buffers` prints them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Uses {
    /// Arrays that it reads.
    pub reads: Vec<&'static str>,
    /// Arrays that it writes.
    pub writes: Vec<&'static str>,
}

/// A buffer of the engine.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BufferRow {
    /// Name in the shaders.
    pub name: &'static str,
    /// Elements.
    pub len: u64,
    /// Size of an element \[bytes\].
    pub stride: u64,
    /// The largest buffer of those in the same memory, no two of which are needed at a time; its own name where it is
    /// the largest.
    pub memory: &'static str,
    /// Size of the texture that a software adapter that reads storage buffers slowly has besides for this buffer, and
    /// perhaps for smaller ones; 0 if for none \[bytes\].
    pub texture_bytes: u64,
    /// Content of the array, with the unit.
    pub doc: &'static str,
}

impl BufferRow {
    /// Size of the buffer \[bytes\]: an empty one still has an element, as a binding cannot be empty.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.stride * self.len.max(1)
    }

    /// Whether it is the largest of those in its memory, so that the memory is as large as it is.
    #[must_use]
    pub fn is_largest(&self) -> bool {
        self.memory == self.name
    }
}

/// The buffers of a setup at the start of a run, how they share memory, and the largest array of each texture on a
/// software adapter.
fn first_memory(setup: &Setup<'_>) -> (Vec<AnyArray>, Aliasing, Vec<AnyArray>) {
    let state = State::new(&first_sizes(u64::MAX, setup));
    let (arrays, recordings) = (state.arrays(), step::recordings(&state, &Plan::new(setup)));
    let aliasing = Aliasing::of(&arrays, &recordings);
    let textures = aliasing.textures(&arrays, &recordings);
    (arrays, aliasing, textures)
}

/// GPU memory of a scene at the start of a run; its neighbour list may grow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MemoryBytes {
    /// Size of all buffers together \[bytes\].
    pub buffers: u64,
    /// Size of the textures that there are besides on a software adapter that reads storage buffers slowly \[bytes\].
    pub textures: u64,
    /// Whether there is a neighbour list, which may grow in the run.
    pub grows: bool,
}

/// GPU memory that a scene takes at the start of a run, with no GPU.
///
/// # Errors
/// [`SceneError`] when the arrays of the initial state do not belong together.
pub fn memory_bytes(scene: &CheckedScene, initial: &InitialState) -> Result<MemoryBytes, SceneError> {
    initial.check()?;
    let setup = Setup::new(scene, initial);
    let (arrays, aliasing, textures) = first_memory(&setup);
    Ok(MemoryBytes {
        buffers: aliasing.bytes(&arrays),
        textures: textures.iter().map(textures::bytes).sum(),
        grows: Plan::new(&setup).conditions.neighbours.runs,
    })
}

/// The step of a scene, pass by pass in execution order: a dry run of `step.rs`, with no GPU.
///
/// # Errors
/// [`SceneError`] when the initial state cannot be made.
pub fn table(scene: &CheckedScene) -> Result<Vec<PlanRow>, SceneError> {
    let initial = InitialState::new(scene)?;
    let setup = Setup::new(scene, &initial);
    let (plan, state) = (Plan::new(&setup), State::new(&first_sizes(u64::MAX, &setup)));
    let recording = Recorder::record(&state, |r| step::record(r, &plan));
    let mut rows: Vec<PlanRow> = Vec::new();
    for command in &recording.commands {
        let same = |row: &PlanRow| {
            (row.pass, row.label, row.band, &row.skipped)
                == (command.pass.name, command.label, command.band, &command.skipped)
        };
        let at = rows.iter().position(same).unwrap_or_else(|| {
            rows.push(PlanRow {
                stage: command.stage,
                pass: command.pass.name,
                label: command.label,
                band: command.band,
                runs: 0,
                invocations: 0,
                operations: command.pass.operations,
                clusters: command.clusters.clone(),
                bytes: 0,
                skipped: command.skipped.clone(),
                uses: uses(command),
            });
            rows.len() - 1
        });
        if command.skipped.is_some() {
            continue;
        }
        rows[at].runs += 1;
        rows[at].invocations += u64::from(command.invocations);
        rows[at].bytes += traffic(command);
    }
    Ok(rows)
}

/// Memory traffic of a run by the model of [`PlanRow::bytes`].
fn traffic(command: &Command) -> u64 {
    let bound = command.pass.bindings.iter().zip(&command.arrays);
    let bytes = |(binding, array): (&Binding, &AnyArray)| {
        let whole = if array.element().is_some() { array.size() } else { array.size() * array.len() };
        whole * (u64::from(binding.reads) + u64::from(binding.writes))
    };
    bound.map(bytes).sum()
}

/// Uses of arrays by a pass, as naga finds them.
fn uses(command: &Command) -> Uses {
    let bound = command.pass.bindings.iter().zip(&command.arrays);
    let names = |does: fn(&Binding) -> bool| {
        bound.clone().filter(|(binding, _)| does(binding)).map(|(_, array)| array.name()).collect()
    };
    Uses { reads: names(|binding| binding.reads), writes: names(|binding| binding.writes) }
}

/// The buffers that a scene takes at the start of a run, with no GPU. Its neighbour list may grow.
///
/// # Errors
/// [`SceneError`] when the initial state cannot be made.
pub fn buffers(scene: &CheckedScene) -> Result<Vec<BufferRow>, SceneError> {
    let initial = InitialState::new(scene)?;
    let (arrays, aliasing, textures) = first_memory(&Setup::new(scene, &initial));
    let largest = aliasing.largest(&arrays);
    let row = |array: &AnyArray| BufferRow {
        name: array.name(),
        len: array.len(),
        stride: array.stride(),
        memory: largest[aliasing.block(array)].name(),
        texture_bytes: textures.iter().find(|first| first.slot() == array.slot()).map_or(0, textures::bytes),
        doc: array.doc(),
    };
    Ok(arrays.iter().map(row).collect())
}
