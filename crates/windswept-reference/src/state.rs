//! The state between steps: local coordinates, hair points first, then air.

use glam::{DQuat, DVec3};
use windswept_scene::{InitialState, Strands};

/// Positions, velocities and frames.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// Steps since the start.
    pub steps: u64,
    /// Per particle \[m\].
    pub position: Vec<DVec3>,
    /// Per particle \[m/s\].
    pub velocity: Vec<DVec3>,
    /// Per segment.
    pub orientation: Vec<DQuat>,
    /// Per segment \[rad/s\].
    pub angular_velocity: Vec<DVec3>,
    /// Per hair point: the last step's move \[m\].
    pub travel: Vec<DVec3>,
    /// Per hair point: the velocity of the step before, with all that acted from outside since \[m/s\].
    pub velocity_before: Vec<DVec3>,
    /// Per hair point: all that acted from outside in the last step awake \[m/s\]; nothing with the model `particles`.
    pub outside: Vec<DVec3>,
    /// Per segment: the last step's turn \[rad\].
    pub turn: Vec<DVec3>,
    /// Per segment: of the step before \[rad/s\].
    pub angular_velocity_before: Vec<DVec3>,
    /// Per segment: μ of stretch-shear, material frame \[N m\].
    pub force: Vec<DVec3>,
    /// Per segment: μ of the joint before it, in the frame before \[N m\].
    pub moment: Vec<DVec3>,
    /// Per strand: where its root is \[m\] and its ghost frame.
    pub clamps: Vec<(DVec3, DQuat)>,
    /// Per strand: where they go in the next step, and stay.
    pub root_targets: Vec<(DVec3, DQuat)>,
    /// Per strand: steps on end that were calm, [`crate::rods::CALM`] at most.
    pub calm: Vec<u32>,
    /// Per strand: steps on end at rest.
    pub still: Vec<u32>,
    /// Per strand: asleep.
    pub asleep: Vec<bool>,
    /// Per strand: a body pushed a point of it in the step before.
    pub touched: Vec<bool>,
    /// Strand-steps by Euler where BDF2 is asked for so far.
    pub euler_steps: usize,
    /// Strand-steps that needed no solve so far.
    pub quiet_steps: usize,
    /// Strand-steps asleep so far.
    pub asleep_steps: usize,
    /// Strand-steps that the direct solver tore so far.
    pub rescued_steps: usize,
    /// Teleports so far.
    pub teleports: usize,
    /// Per strand: non-finite in the step before, to be reset.
    pub bad: Vec<bool>,
    /// Strands that went bad so far.
    pub resets: usize,
    /// Per strand: steps on end with a segment stretched or crushed by more than half.
    pub strained_steps: Vec<u32>,
    /// How often a strand was over-strained for [`crate::rods::STRAINED_STEPS`] steps on end so far.
    pub over_strained: usize,
    /// Moves that were capped so far.
    pub capped: usize,
    /// Hair points, step by step, whose exchange with the air was limited so far.
    pub limited: usize,
    /// max |l/l0 − 1| so far.
    pub max_stretch: f64,
    /// What confinement gave the air so far \[kg m/s\].
    pub confinement_impulse: DVec3,
    /// Per particle \[m³\].
    pub volume: Vec<f64>,
    /// Per particle \[1/kg\].
    pub inverse_mass: Vec<f64>,
    /// Rods: rest shape, compliances; positions and orientations are those of the rest pose, local.
    pub hair: Strands,
}

impl State {
    /// The start: strands come as if they had moved with their velocities for a step of `step` \[s\].
    #[must_use]
    pub fn new(initial: &InitialState, step: f64) -> Self {
        let local = |x: &DVec3| *x - initial.origin;
        let mut hair = initial.hair.clone();
        hair.positions = hair.positions.iter().map(local).collect();
        let air = initial.air.positions.len();
        let each =
            |hair: &[f64], air_value: f64| hair.iter().copied().chain(std::iter::repeat_n(air_value, air)).collect();
        let clamps: Vec<_> =
            hair.roots().collect::<Vec<_>>().into_iter().zip(hair.root_frame.iter().copied()).collect();
        Self {
            steps: 0,
            travel: hair.velocities.iter().map(|v| *v * step).collect(),
            velocity_before: hair.velocities.clone(),
            outside: vec![DVec3::ZERO; hair.velocities.len()],
            turn: hair.angular_velocities.iter().map(|w| *w * step).collect(),
            angular_velocity_before: hair.angular_velocities.clone(),
            force: vec![DVec3::ZERO; hair.orientations.len()],
            moment: vec![DVec3::ZERO; hair.orientations.len()],
            root_targets: clamps.clone(),
            clamps,
            // One step of Euler, then BDF2: there is no acceleration to carry on before.
            calm: vec![1; hair.len()],
            still: vec![0; hair.len()],
            asleep: vec![false; hair.len()],
            touched: vec![false; hair.len()],
            euler_steps: 0,
            quiet_steps: 0,
            asleep_steps: 0,
            rescued_steps: 0,
            teleports: 0,
            position: hair.positions.iter().copied().chain(initial.air.positions.iter().map(local)).collect(),
            velocity: hair.velocities.iter().chain(&initial.air.velocities).copied().collect(),
            orientation: hair.orientations.clone(),
            angular_velocity: hair.angular_velocities.clone(),
            bad: vec![false; hair.len()],
            resets: 0,
            strained_steps: vec![0; hair.len()],
            over_strained: 0,
            capped: 0,
            limited: 0,
            max_stretch: 0.0,
            confinement_impulse: DVec3::ZERO,
            volume: each(&hair.volume, initial.air.volume),
            inverse_mass: each(&hair.inverse_mass, 1.0 / initial.air.mass),
            hair,
        }
    }
}
