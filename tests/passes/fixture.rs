//! An engine and its reference side by side: run a fragment of the step on one, the same stages on the other, compare.

use glam::{DQuat, DVec3};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use windswept::{
    Gpu,
    internals::{Array, Engine, Plan, Poses, Recorder, Recording, Setup, Slots},
};
use windswept_reference::{
    Parameters, State as Reference,
    contact::Memory,
    neighbours::{self, Neighbours},
};
use windswept_scene::{AsChecked, InitialState};
use windswept_shaders::common::{
    contact::ContactHistory,
    matter::Exchange,
    rod::{Condition, RodPoint, RodSegment, RodStrand, Root, SLEEPS},
};

use crate::support::{self, Layout};

/// Engine with its state on the device, and the reference with the same numbers (rounded to f32 as the engine's are).
pub struct Fixture {
    pub engine: Engine,
    pub plan: Plan,
    pub reference: Reference,
    pub parameters: Parameters,
    /// Poses of bodies that deform.
    poses: Poses,
}

/// Vector of the first three numbers of a vector in a struct.
pub fn xyz(v: &[f32]) -> DVec3 {
    DVec3::new(v[0].into(), v[1].into(), v[2].into())
}

pub fn quaternion(q: [f32; 4]) -> DQuat {
    DQuat::from_array(q.map(f64::from))
}

impl Fixture {
    pub fn new(scene: &impl AsChecked, initial: &InitialState) -> Self {
        Self::on(&support::gpu(), scene, initial)
    }

    pub fn on(gpu: &Gpu, scene: &impl AsChecked, initial: &InitialState) -> Self {
        let scene = scene.as_checked().unwrap();
        let setup = Setup::new(&scene, initial);
        let mut engine = Engine::new(gpu, &setup).unwrap();
        // Room for every pair of a clump; growing is tested elsewhere.
        let capacity = (initial.hair.positions.len() + initial.air.positions.len()).max(64) as u32 * 300;
        engine.grow_neighbours(1, capacity).unwrap();
        let mut plan = Plan::new(&setup);
        plan.recover_strands();
        let parameters = Parameters::new(&scene, initial);
        let mut reference = Reference::new(initial, parameters.step);
        for x in reference.position.iter_mut().chain(&mut reference.tip_targets) {
            *x = x.as_vec3().as_dvec3();
        }
        let mut poses = Poses::new(&scene, initial);
        poses.bring(&engine, 0).unwrap();
        Self { engine, plan, reference, parameters, poses }
    }

    /// Brings the poses to the device that bodies go between in the next step.
    pub fn bring_poses(&mut self) {
        self.poses.bring(&self.engine, self.reference.steps as u32).unwrap();
    }

    fn recorded(&self, record: impl FnOnce(&mut Recorder<'_>, &Plan)) -> Recording {
        Recorder::record(self.engine.state(), |r| record(r, &self.plan))
    }

    /// Runs a fragment of the step, which may freeze.
    pub fn replay(&self, record: impl FnOnce(&mut Recorder<'_>, &Plan)) {
        self.engine.replay(&self.recorded(record)).unwrap();
    }

    fn assert_not_frozen(&self) {
        let status = self.engine.status().unwrap();
        assert!(status.causes == 0 && status.neighbours <= self.engine.sizes().neighbours, "frozen: {status:?}");
    }

    pub fn run(&self, record: impl FnOnce(&mut Recorder<'_>, &Plan)) {
        self.replay(record);
        self.assert_not_frozen();
    }

    /// Runs these passes of a fragment of the step, and no others.
    pub fn run_only(&self, passes: &[&str], record: impl FnOnce(&mut Recorder<'_>, &Plan)) {
        self.replay_only(passes, record);
        self.assert_not_frozen();
    }

    /// Runs these passes of a fragment of the step, which may freeze, and no others.
    pub fn replay_only(&self, passes: &[&str], record: impl FnOnce(&mut Recorder<'_>, &Plan)) {
        let mut recording = self.recorded(record);
        recording.commands.retain(|command| passes.contains(&command.pass.name));
        assert!(passes.iter().all(|pass| recording.running().any(|command| command.pass.name == *pass)), "{passes:?}");
        self.engine.replay(&recording).unwrap();
    }

    pub fn vectors(&self, array: &Array<[f32; 4]>) -> Vec<DVec3> {
        self.engine.read(array).unwrap().iter().map(|v| xyz(&v[..3])).collect()
    }

    pub fn quaternions(&self, array: &Array<[f32; 4]>) -> Vec<DQuat> {
        self.engine.read(array).unwrap().into_iter().map(quaternion).collect()
    }

    /// Hair points and segments of the step.
    pub fn rods(&self) -> (Vec<RodPoint>, Vec<RodSegment>) {
        let s = self.engine.state();
        (self.engine.read(&s.rod_points).unwrap(), self.engine.read(&s.rod_segments).unwrap())
    }

    /// Strands of the step.
    pub fn rod_strands(&self) -> Vec<RodStrand> {
        self.engine.read(&self.engine.state().rod_strands).unwrap()
    }

    /// How each strand is, as the last step committed it.
    pub fn health(&self) -> Vec<Condition> {
        self.engine.read(&self.engine.state().strand_history).unwrap().iter().map(|strand| strand.condition).collect()
    }

    /// Sets how each strand is.
    pub fn set_health(&self, health: &[Condition]) {
        let array = &self.engine.state().strand_history;
        let mut strands = self.engine.read(array).unwrap();
        strands.iter_mut().zip(health).for_each(|(strand, condition)| strand.condition = *condition);
        self.engine.write(array, &strands).unwrap();
    }

    /// How each strand is, as this step found it so far.
    pub fn found(&self) -> Vec<Condition> {
        self.rod_strands().iter().map(|rod| rod.condition).collect()
    }

    /// Sets accelerations of up to 30 m/s² along each axis for hair and air, rounded to f32.
    pub fn push(&mut self) {
        let pushed: Vec<_> =
            stirred(self.reference.position.len()).into_iter().map(|v| (10.0 * v).as_vec3().as_dvec3()).collect();
        let (hair, air) = pushed.split_at(self.parameters.hair_points);
        self.engine.make_room_for_force(true).unwrap();
        self.engine.write_force(hair, air).unwrap();
        self.plan.set_force(true);
        self.reference.pushed = pushed;
    }

    /// Makes the engine's hair the reference's, so that what rounding made of one step is not held against the next.
    pub fn adopt(&self, s: &mut Reference) {
        let state = self.engine.state();
        let points = self.engine.read(&state.point_history).unwrap();
        let segments = self.engine.read(&state.segment_history).unwrap();
        let root = |root: &Root| (xyz(&root.position), quaternion(root.frame));
        let strands = self.engine.read(&state.strand_history).unwrap();
        s.clamps = strands.iter().map(|strand| root(&strand.root)).collect();
        s.tip_force = strands.iter().map(|strand| xyz(&strand.pin_force)).collect();
        s.root_targets = self.engine.read(&state.root_targets).unwrap().iter().map(root).collect();
        let hair = self.parameters.hair_points;
        let position = self.vectors(&state.position);
        for i in 0..hair {
            let held_tip = s.inverse_mass[i] == 0.0 && s.hair.points(self.parameters.strand_of[i]).start < i;
            s.position[i] = position[i] + if held_tip { DVec3::ZERO } else { xyz(&points[i].remainder) };
            (s.displacement[i], s.velocity_before[i]) = (xyz(&points[i].displacement), xyz(&points[i].velocity));
            (s.own[i], s.tangential_spring[i]) = (xyz(&points[i].own), xyz(&points[i].tangential_spring));
            (s.rest_drift[i], s.external_dv[i]) = (xyz(&points[i].rest_drift), xyz(&points[i].external_dv));
        }
        let memory = |kept: &ContactHistory| Memory { friction: xyz(&kept.friction), force: kept.force.into() };
        s.contacts = self.engine.read(&state.contact_history).unwrap().iter().map(memory).collect();
        s.velocity[..hair].copy_from_slice(&self.vectors(&state.velocity)[..hair]);
        s.orientation = self.quaternions(&state.orientation);
        for (k, history) in segments.iter().enumerate() {
            (s.turn[k], s.segment_rest_drift[k]) = (xyz(&history.turn), xyz(&history.rest_drift));
            s.angular_velocity[k] = xyz(&history.angular_velocity);
            s.angular_velocity_before[k] = xyz(&history.before);
        }
    }

    /// Puts the reference's air into the engine's slots; it was in those of `before`.
    pub fn follow(&self, s: &mut Reference, before: &Slots) {
        let slot_of = before.by_id(0..before.ids().len());
        let from = self.engine.slots().unwrap().by_slot(&slot_of);
        fn put<T: Copy>(air: &mut [T], from: &[usize]) {
            let rows: Vec<T> = from.iter().map(|slot| air[*slot]).collect();
            air.copy_from_slice(&rows);
        }
        let first = self.parameters.hair_points;
        put(&mut s.position[first..], &from);
        put(&mut s.velocity[first..], &from);
        put(&mut s.pressed[first..], &from);
        if !s.pushed.is_empty() {
            put(&mut s.pushed[first..], &from);
        }
    }

    pub fn numbers(&self, array: &Array<f32>) -> Vec<f64> {
        self.engine.read(array).unwrap().into_iter().map(f64::from).collect()
    }

    /// A part of each particle's `Exchange` for XSPH: its S, or how the flow deforms it.
    pub fn exchange(&self, part: fn(&Exchange) -> f32) -> Vec<f64> {
        self.engine.read(&self.engine.state().exchange).unwrap().iter().map(|all| f64::from(part(all))).collect()
    }

    /// Lists neighbours, on the engine with positions where a step's predicted ones stand; returns the reference's.
    pub fn list_neighbours(&self) -> Neighbours {
        self.engine.copy_state_to_scratch().unwrap();
        self.run(windswept::internals::step::neighbours::record);
        neighbours::list(&self.parameters, &self.reference.position)
    }

    pub fn write_vectors(&self, array: &Array<[f32; 4]>, values: &[DVec3]) {
        let values: Vec<[f32; 4]> = values.iter().map(|v| v.as_vec3().extend(0.0).to_array()).collect();
        self.engine.write(array, &values).unwrap();
    }
}

/// Condition of a strand of the reference, in the engine's words.
pub fn condition(s: &Reference, strand: usize) -> Condition {
    Condition {
        failed: s.failed[strand].into(),
        strained: s.strained_steps[strand].min(windswept_reference::rods::STRAINED_STEPS + 1),
        bdf2_ready: s.bdf2_ready[strand].into(),
        resting: if s.sleeping[strand] { SLEEPS } else { s.resting[strand] },
    }
}

/// Crowds that passes over particles are tried on: layouts and shares of hair, for each of the awkward sizes. Hair
/// alone never meets (`rods/solve.rs` has it); the largest size in one cell would be 2e8 pairs.
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

/// Velocities of up to 3 m/s on each axis, rounded to f32.
pub fn stirred(n: usize) -> Vec<DVec3> {
    let mut rng = Pcg64::seed_from_u64(11);
    (0..n).map(|_| (6.0 * DVec3::from_array(rng.random()) - 3.0).as_vec3().as_dvec3()).collect()
}

/// Compares each of the [`crowds`] in a scene.
pub fn each(scene: &impl AsChecked, mut compare: impl FnMut(&str, &Fixture)) {
    for (what, initial) in crowds() {
        compare(&what, &Fixture::new(scene, &initial));
    }
}

/// Largest |a − b| over largest |b|; below `floor` a value is rounding (pairs exactly a kernel radius apart).
pub fn relative(got: &[DVec3], wanted: &[DVec3], floor: f64) -> f64 {
    assert_eq!(got.len(), wanted.len());
    let scale = wanted.iter().map(|v| v.length()).fold(floor, f64::max);
    assert!(got.iter().all(|v| v.is_finite()), "not finite");
    got.iter().zip(wanted).map(|(a, b)| (*a - *b).length()).fold(0.0, f64::max) / scale
}
