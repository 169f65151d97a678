//! State between steps, in local coordinates: hair points first, then air.

use glam::{DQuat, DVec3};
use windswept_scene::{InitialState, Strands};

use crate::{contact::Memory, fluid::Pressed};

/// State that a step starts from, and counts of all steps so far.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// Number of steps since the start.
    pub steps: u64,
    /// Velocity of the frame of `air.follows` \[m/s\], which velocities are less.
    pub frame_velocity: DVec3,
    /// Position of each particle \[m\].
    pub position: Vec<DVec3>,
    /// Velocity of each particle \[m/s\].
    pub velocity: Vec<DVec3>,
    /// Frame of each segment.
    pub orientation: Vec<DQuat>,
    /// Spin of each segment \[rad/s\].
    pub angular_velocity: Vec<DVec3>,
    /// Move of each hair point in the last step \[m\].
    pub displacement: Vec<DVec3>,
    /// Velocity of each hair point one step before, with the changes by external forces since \[m/s\].
    pub velocity_before: Vec<DVec3>,
    /// Change of each hair point's velocity by external forces in its last step awake, a mean over the consecutive
    /// steps in which its strand rested \[m/s\]; 0 with the model `particles`.
    pub external_dv: Vec<DVec3>,
    /// Change of each hair point's velocity by its rod and gravity in its last step awake \[m/s\]; 0 with the model
    /// `particles`.
    pub own: Vec<DVec3>,
    /// Slip that friction of hair on hair holds each hair point back from \[m/s\]: see [`crate::fluid::friction`].
    pub tangential_spring: Vec<DVec3>,
    /// Memory of pressure of each particle from step to step; 0 with solver `pbf`.
    pub pressed: Vec<Pressed>,
    /// Way of each hair point from where it was when its strand came to rest \[m\].
    pub rest_drift: Vec<DVec3>,
    /// Turn of each segment since its strand came to rest \[rad\].
    pub segment_rest_drift: Vec<DVec3>,
    /// Turn of each segment in the last step \[rad\].
    pub turn: Vec<DVec3>,
    /// Spin of each segment one step before \[rad/s\].
    pub angular_velocity_before: Vec<DVec3>,
    /// Place of each strand's root \[m\], and its ghost frame.
    pub clamps: Vec<(DVec3, DQuat)>,
    /// Place \[m\] and ghost frame to which each root goes in the next step, and stays.
    pub root_targets: Vec<(DVec3, DQuat)>,
    /// Whether each strand's last step was integrated, or slept through, so that BDF2 may follow.
    pub bdf2_ready: Vec<bool>,
    /// Place of each strand's tip, where it is held, before the motion of its roots \[m\].
    pub tip_targets: Vec<DVec3>,
    /// Force that holds each strand's tip, where it is held \[N\].
    pub tip_force: Vec<DVec3>,
    /// Number of consecutive steps in which each strand was at rest.
    pub resting: Vec<u32>,
    /// Whether each strand sleeps.
    pub sleeping: Vec<bool>,
    /// Memories of contacts of hair with bodies, of points and then of segments, each with every body; empty before the
    /// first step.
    pub contacts: Vec<Memory>,
    /// Number of strand-steps by Euler where BDF2 is asked for, so far.
    pub euler_steps: usize,
    /// Number of sleeping strand-steps, so far.
    pub sleeping_steps: usize,
    /// Number of strand-steps that had not settled after the last Newton step, so far.
    pub unsolved_steps: usize,
    /// Number of teleports so far.
    pub teleports: usize,
    /// Whether each strand was not finite in the step before, and is to be reset.
    pub failed: Vec<bool>,
    /// Number of times that a strand was not finite, so far.
    pub resets: usize,
    /// Number of consecutive steps in which each strand had a segment stretched or crushed by more than a twentieth.
    pub strained_steps: Vec<u32>,
    /// Number of times that a strand was over-strained for [`crate::rods::STRAINED_STEPS`] consecutive steps, so far.
    pub over_strained: usize,
    /// Number of times that a hair point's exchange with the air was limited, so far.
    pub limited: usize,
    /// Largest stretch |l/l0 − 1| so far.
    pub max_stretch: f64,
    /// Impulse that confinement gave the air so far \[kg m/s\].
    pub confinement_impulse: DVec3,
    /// Impulse that the air gave each body so far \[kg m/s\]; empty before the first step.
    pub body_impulse: Vec<DVec3>,
    /// Acceleration that was set for each particle \[m/s²\]; empty without one.
    pub pushed: Vec<DVec3>,
    /// Volume of each particle \[m³\].
    pub volume: Vec<f64>,
    /// Inverse mass of each particle \[1/kg\].
    pub inverse_mass: Vec<f64>,
    /// Rods: rest shape and compliances; positions and orientations are those at the start, in local coordinates.
    pub hair: Strands,
}

impl State {
    /// State at the start: strands come as if they had moved with their velocities for a step of `step` \[s\].
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
            frame_velocity: DVec3::ZERO,
            displacement: hair.velocities.iter().map(|v| *v * step).collect(),
            velocity_before: hair.velocities.clone(),
            external_dv: vec![DVec3::ZERO; hair.velocities.len()],
            own: vec![DVec3::ZERO; hair.velocities.len()],
            tangential_spring: vec![DVec3::ZERO; hair.velocities.len()],
            pressed: vec![Pressed::default(); hair.velocities.len() + air],
            rest_drift: vec![DVec3::ZERO; hair.velocities.len()],
            segment_rest_drift: vec![DVec3::ZERO; hair.orientations.len()],
            turn: hair.angular_velocities.iter().map(|w| *w * step).collect(),
            angular_velocity_before: hair.angular_velocities.clone(),
            root_targets: clamps.clone(),
            clamps,
            bdf2_ready: vec![false; hair.len()],
            tip_targets: (0..hair.len()).map(|s| hair.positions[hair.points(s).end - 1]).collect(),
            tip_force: vec![DVec3::ZERO; hair.len()],
            resting: vec![0; hair.len()],
            sleeping: vec![false; hair.len()],
            contacts: Vec::new(),
            euler_steps: 0,
            sleeping_steps: 0,
            unsolved_steps: 0,
            teleports: 0,
            position: hair.positions.iter().copied().chain(initial.air.positions.iter().map(local)).collect(),
            velocity: hair.velocities.iter().chain(&initial.air.velocities).copied().collect(),
            orientation: hair.orientations.clone(),
            angular_velocity: hair.angular_velocities.clone(),
            failed: vec![false; hair.len()],
            resets: 0,
            strained_steps: vec![0; hair.len()],
            over_strained: 0,
            limited: 0,
            max_stretch: 0.0,
            confinement_impulse: DVec3::ZERO,
            body_impulse: Vec::new(),
            pushed: Vec::new(),
            volume: each(&hair.volume, initial.air.volume),
            inverse_mass: each(&hair.inverse_mass, 1.0 / initial.air.mass),
            hair,
        }
    }
}
