//! An engine and its twin side by side: run a fragment of the step on one, the same headings on the other, compare.

use glam::{DQuat, DVec3};
use windswept::{
    Gpu,
    internals::{Array, Command, Engine, Plan, Recorder, Recording, State},
};
use windswept_reference::{Parameters, State as Twin, grid::Neighbours};
use windswept_scene::{InitialState, Scene};

use crate::support::{self, Layout};

/// The engine with its state on the device, and the twin with the same numbers (rounded to f32 as the engine's are).
pub struct Stage {
    pub engine: Engine,
    pub plan: Plan,
    pub twin: Twin,
    pub parameters: Parameters,
}

/// `RodPoint` of `shaders/common/rod.wgsl`; the engine only needs its size.
#[repr(C)]
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub struct RodPoint {
    pub velocity: [f32; 3],
    pub inverse_mass: f32,
    pub before: [f32; 3],
    pub largest: f32,
    pub carried: [f32; 3],
    pub step: f32,
    pub change: [f32; 4],
    pub free: [f32; 4],
    pub travel: [f32; 4],
}

/// `RodSegment` of `shaders/common/rod.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub struct RodSegment {
    pub start: [f32; 4],
    pub frame: [f32; 4],
    pub angular_velocity: [f32; 3],
    pub step: f32,
    pub before: [f32; 4],
    pub carried: [f32; 4],
    pub free: [f32; 4],
    pub turn: [f32; 4],
    pub chord: [f32; 4],
    pub force: [f32; 4],
    pub moment: [f32; 4],
}

/// `RodStrand` of `shaders/common/rod.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub struct RodStrand {
    pub root_travel: [f32; 3],
    pub state: u32,
    pub root_frame: [f32; 4],
    pub root_turn: [f32; 4],
    pub tip_moment: [f32; 3],
    pub misfit: f32,
}

/// The first three of a vector in a struct.
pub fn xyz(v: &[f32]) -> DVec3 {
    DVec3::new(v[0].into(), v[1].into(), v[2].into())
}

pub fn quaternion(q: [f32; 4]) -> DQuat {
    DQuat::from_array(q.map(f64::from))
}

impl Stage {
    pub fn new(scene: &Scene, initial: &InitialState) -> Self {
        Self::on(&support::gpu(), scene, initial)
    }

    pub fn on(gpu: &Gpu, scene: &Scene, initial: &InitialState) -> Self {
        let mut engine = Engine::new(gpu, scene, initial).unwrap();
        // Room for every pair of a clump; growing is tested elsewhere.
        let capacity = (initial.hair.positions.len() + initial.air.positions.len()).max(64) as u32 * 300;
        engine.grow_neighbours(capacity).unwrap();
        let plan = Plan::new(scene, initial, engine.sizes());
        let parameters = Parameters::new(scene, initial);
        let mut twin = Twin::new(initial, parameters.step);
        for x in &mut twin.position {
            *x = x.as_vec3().as_dvec3();
        }
        Self { engine, plan, twin, parameters }
    }

    fn recorded(&self, record: impl FnOnce(&mut Recorder, &State, &Plan)) -> Recording {
        Recorder::record(|r| record(r, self.engine.state(), &self.plan))
    }

    /// Runs a fragment of the step, which may freeze.
    pub fn replay(&self, record: impl FnOnce(&mut Recorder, &State, &Plan)) {
        self.engine.replay(&self.recorded(record)).unwrap();
    }

    fn assert_not_frozen(&self) {
        let status = self.engine.status().unwrap();
        assert!(status.causes == 0 && status.neighbours <= self.engine.sizes().neighbours, "frozen: {status:?}");
    }

    pub fn run(&self, record: impl FnOnce(&mut Recorder, &State, &Plan)) {
        self.replay(record);
        self.assert_not_frozen();
    }

    /// Of a fragment of the step these passes only.
    pub fn run_only(&self, passes: &[&str], record: impl FnOnce(&mut Recorder, &State, &Plan)) {
        let mut recording = self.recorded(record);
        recording.commands.retain(|command| passes.contains(&command.pass.name));
        assert!(passes.iter().all(|pass| recording.running().any(|command| command.pass.name == *pass)), "{passes:?}");
        self.engine.replay(&recording).unwrap();
        self.assert_not_frozen();
    }

    /// A fragment of the step, to run pass by pass.
    pub fn passes(&self, record: impl FnOnce(&mut Recorder, &State, &Plan)) -> Passes<'_> {
        let mut commands = self.recorded(record).commands;
        commands.retain(|command| command.skipped.is_none());
        Passes { stage: self, commands }
    }

    pub fn vectors(&self, array: &Array) -> Vec<DVec3> {
        let read: Vec<[f32; 4]> = self.engine.read(array).unwrap();
        read.iter().map(|v| DVec3::new(v[0].into(), v[1].into(), v[2].into())).collect()
    }

    pub fn quaternions(&self, array: &Array) -> Vec<DQuat> {
        let read: Vec<[f32; 4]> = self.engine.read(array).unwrap();
        read.iter().map(|q| DQuat::from_array(q.map(f64::from))).collect()
    }

    /// Hair points and segments of the step, of which a test compares moves, frames and multipliers.
    pub fn rods(&self) -> (Vec<RodPoint>, Vec<RodSegment>) {
        let s = self.engine.state();
        (self.engine.read(&s.rod_points).unwrap(), self.engine.read(&s.rod_segments).unwrap())
    }

    /// Strands of the step.
    pub fn rod_strands(&self) -> Vec<RodStrand> {
        self.engine.read(&self.engine.state().rod_strands).unwrap()
    }

    /// Per strand what it is committed and found as: bad, strained, calm, still.
    pub fn health(&self) -> Vec<[[u32; 4]; 2]> {
        self.engine.read(&self.engine.state().health).unwrap()
    }

    /// The engine's hair becomes the twin's, so that what rounding made of one step is not held against the next.
    pub fn adopt(&self, s: &mut Twin) {
        let state = self.engine.state();
        let points: Vec<[[f32; 4]; 3]> = self.engine.read(&state.point_history).unwrap();
        let segments: Vec<[[f32; 4]; 4]> = self.engine.read(&state.segment_history).unwrap();
        let roots = |array| -> Vec<_> {
            let read: Vec<[[f32; 4]; 2]> = self.engine.read(array).unwrap();
            read.iter().map(|[position, frame]| (xyz(position), quaternion(*frame))).collect()
        };
        (s.clamps, s.root_targets) = (roots(&state.clamps), roots(&state.root_targets));
        let hair = self.parameters.hair_points;
        let position = self.vectors(&state.position);
        for i in 0..hair {
            s.position[i] = position[i] + xyz(&points[i][2]);
            (s.travel[i], s.velocity_before[i]) = (xyz(&points[i][0]), xyz(&points[i][1]));
        }
        s.velocity[..hair].copy_from_slice(&self.vectors(&state.velocity)[..hair]);
        s.orientation = self.quaternions(&state.orientation);
        s.angular_velocity = self.vectors(&state.angular_velocity);
        for (k, history) in segments.iter().enumerate() {
            (s.turn[k], s.angular_velocity_before[k]) = (xyz(&history[0]), xyz(&history[1]));
            (s.force[k], s.moment[k]) = (xyz(&history[2]), xyz(&history[3]));
        }
    }

    pub fn numbers(&self, array: &Array) -> Vec<f64> {
        let read: Vec<f32> = self.engine.read(array).unwrap();
        read.into_iter().map(f64::from).collect()
    }

    /// Positions where a step's predicted ones stand, neighbours listed; the twin's neighbours.
    pub fn meet(&self) -> Neighbours {
        self.engine.copy_state_to_scratch().unwrap();
        self.run(windswept::internals::step::neighbours::record);
        windswept_reference::grid::neighbours(&self.parameters, &self.twin.position)
    }

    pub fn write_vectors(&self, array: &Array, values: &[DVec3]) {
        let values: Vec<[f32; 4]> = values.iter().map(|v| v.as_vec3().extend(0.0).to_array()).collect();
        self.engine.write(array, &values).unwrap();
    }
}

/// A fragment of the step whose passes run one after the other.
pub struct Passes<'a> {
    stage: &'a Stage,
    commands: Vec<Command>,
}

impl Passes<'_> {
    /// Runs what is left of the fragment up to the next runs of `pass`, and these. Says whether there were any; without, nothing
    /// runs.
    pub fn through(&mut self, pass: &str) -> bool {
        let Some(first) = self.commands.iter().position(|command| command.pass.name == pass) else { return false };
        let runs = self.commands[first..].iter().take_while(|command| command.pass.name == pass).count();
        self.replay(first + runs);
        true
    }

    /// Runs the rest.
    pub fn finish(mut self) {
        self.replay(self.commands.len());
    }

    fn replay(&mut self, passes: usize) {
        let commands = self.commands.drain(..passes).collect();
        self.stage.engine.replay(&Recording { commands }).unwrap();
    }
}

/// How a strand of the twin is, in the engine's words: bad, strained, calm, still.
pub fn condition(s: &Twin, strand: usize) -> [u32; 4] {
    let still = if s.asleep[strand] { u32::MAX } else { s.still[strand] };
    let strained = s.strained_steps[strand].min(windswept_reference::rods::STRAINED_STEPS + 1);
    [u32::from(s.bad[strand]), strained, s.calm[strand], still]
}

/// The layouts and the share of hair that passes over particles are tried on, for each of the awkward sizes. Hair alone
/// never meets (`tests/passes/rods.rs` has it); all in one cell would be 2e8 pairs of the largest size.
pub fn crowds() -> impl Iterator<Item = (String, InitialState)> {
    let cases = |n: usize| {
        let spread =
            [(0, Layout::Random), (n / 3, Layout::Random), (n / 3, Layout::Lattice), (n / 4, Layout::Clustered)];
        let crowded = if n < 1000 { vec![(n / 3, Layout::OneCell)] } else { Vec::new() };
        spread.into_iter().chain(crowded)
    };
    support::SIZES.into_iter().flat_map(move |n| {
        cases(n).map(move |(hair, layout)| {
            (format!("{n} particles, {hair} of hair, {layout:?}"), support::particles(n, hair, layout, n as u64 + 1))
        })
    })
}

/// Largest |a − b| over largest |b|; below `floor` a value is rounding (pairs exactly a kernel radius apart).
pub fn relative(got: &[DVec3], wanted: &[DVec3], floor: f64) -> f64 {
    assert_eq!(got.len(), wanted.len());
    let scale = wanted.iter().map(|v| v.length()).fold(floor, f64::max);
    assert!(got.iter().all(|v| v.is_finite()), "not finite");
    got.iter().zip(wanted).map(|(a, b)| (*a - *b).length()).fold(0.0, f64::max) / scale
}

/// The same for numbers.
pub fn relative_numbers(got: &[f64], wanted: &[f64], floor: f64) -> f64 {
    let vectors = |values: &[f64]| values.iter().map(|x| DVec3::X * *x).collect::<Vec<_>>();
    relative(&vectors(got), &vectors(wanted), floor)
}
