//! An engine and its twin side by side: run a fragment of the step on one, the same headings on the other, compare.

use glam::{DQuat, DVec3};
use windswept::{
    Engine, Plan,
    recorder::{Recorder, Recording},
    state::{Array, State},
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

/// The first three of a vector in a struct.
pub fn xyz(v: &[f32]) -> DVec3 {
    DVec3::new(v[0].into(), v[1].into(), v[2].into())
}

pub fn quaternion(q: [f32; 4]) -> DQuat {
    DQuat::from_array(q.map(f64::from))
}

impl Stage {
    pub fn new(scene: &Scene, initial: &InitialState) -> Self {
        let mut engine = Engine::new(&support::gpu(), scene, initial).unwrap();
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

    pub fn run(&self, record: impl FnOnce(&mut Recorder, &State, &Plan)) {
        let recording: Recording = Recorder::record(|r| record(r, self.engine.state(), &self.plan));
        self.engine.replay(&recording).unwrap();
        let status = self.engine.status().unwrap();
        assert!(status.causes == 0 && status.neighbours <= self.engine.sizes().neighbours, "frozen: {status:?}");
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

    pub fn numbers(&self, array: &Array) -> Vec<f64> {
        let read: Vec<f32> = self.engine.read(array).unwrap();
        read.into_iter().map(f64::from).collect()
    }

    /// Positions where a step's predicted ones stand, neighbours listed; the twin's neighbours.
    pub fn meet(&self) -> Neighbours {
        self.engine.copy_state_to_scratch().unwrap();
        self.run(windswept::step::neighbours::record);
        windswept_reference::grid::neighbours(&self.parameters, &self.twin.position)
    }

    pub fn write_vectors(&self, array: &Array, values: &[DVec3]) {
        let values: Vec<[f32; 4]> = values.iter().map(|v| v.as_vec3().extend(0.0).to_array()).collect();
        self.engine.write(array, &values).unwrap();
    }
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
