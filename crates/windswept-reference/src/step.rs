//! One step, in execution order: the reference of the engine's `step.rs`.

use glam::DVec3;

use crate::{
    Parameters, State, commit,
    commit::Frozen,
    contact,
    fluid::{self, Moments, Pressed, Wall},
    forcing,
    neighbours::{self, Neighbours},
    rods, turbulence, viscosity,
};

/// One step of `parameters.step`.
///
/// # Errors
/// [`Frozen`] says why the step was not committed; the state is as it was before.
pub fn step(state: &mut State, p: &Parameters) -> Result<(), Frozen> {
    let mut s = state.clone();
    let invalid = forcing::recover(&mut s); //   1. Bad strands are reset.
    let mut w = forcing::run(&s, p); //         Clamps and bodies move; wind enters; air moves, and hair drifts among it.
    w.invalid = invalid;
    neighbours::run(&mut w, p); //         2. List who is near whom.
    fluid::run(&s, &mut w, p); //          3. Pressure, or density constraints (eq. 1), of hair and air together or each for itself.
    rods::run(&mut s, &mut w, p); //       4. Air drags strands, which keep their length and shape and stay out of bodies; they slow the air.
    contact::run(&mut w, p); //            5. Air flows around bodies.
    turbulence::run(&mut s, &mut w, p); // 6. Strengthen the eddies of each band (eqs. 2, 4-6), air only.
    viscosity::run(&s, &mut w, p); //      7. Neighbours share velocity (eqs. 7, 8).
    commit::run(&mut s, w, p)?; //          8. Commit, or freeze and report.
    *state = s;
    Ok(())
}

/// Arrays that a step works on before it is committed: the engine's scratch buffers of the same names.
#[derive(Debug, Clone, Default)]
pub struct Scratch {
    /// Number of strands that were invalid when the step began.
    pub invalid: usize,
    /// Mean wind in this step \[m/s\].
    pub blowing: DVec3,
    /// Mean deficit of the air in the fringe to the wind \[m/s\].
    pub fringe_deficit: DVec3,
    /// Deficit of all air to the wind, along it \[m/s\].
    pub wind_deficit: DVec3,
    /// Change that ramp, gusts and fringe make to each air particle \[m/s\].
    pub wind_change: Vec<DVec3>,
    /// Position of each particle \[m\].
    pub predicted: Vec<DVec3>,
    /// Velocity of each particle \[m/s\].
    pub new_velocity: Vec<DVec3>,
    /// Neighbours of each particle.
    pub near: Neighbours,
    /// Density ρ/ρ0 of each particle.
    pub density: Vec<f64>,
    /// Sum of the moves of each particle by the density constraint \[m\]; of hair that shares pressure with air, the
    /// move by the impulse of the pressure over time.
    pub correction: Vec<DVec3>,
    /// Wall at each particle that pressure acts on; none without bodies.
    pub walls: Vec<Wall>,
    /// Impulse of the coarse pressure on each body, over the mass of an air particle \[m/s\].
    pub coarse_impulse: Vec<DVec3>,
    /// Surroundings of each particle, as pressure sees them.
    pub moments: Vec<Moments>,
    /// Memory of pressure of each particle for the next step.
    pub pressed: Vec<Pressed>,
    /// Tangential spring of each hair point after this step \[m/s\].
    pub tangential_spring: Vec<DVec3>,
    /// Way of each strand through the step, with its clamp's.
    pub motions: Vec<rods::StrandMotion>,
    /// Hair points and segments, as the rods have them, and what they meet.
    pub moving: rods::Moving,
    /// Air at each hair point.
    pub local: Vec<rods::Local>,
    /// Impulse that each hair point had from its load \[N s\].
    pub drag_impulse: Vec<DVec3>,
    /// Velocity of each hair point as its rod left it \[m/s\].
    pub rod_velocity: Vec<DVec3>,
    /// Velocity û of each particle in the last band \[m/s\].
    pub band_velocity: Vec<DVec3>,
    /// Vorticity ω of each particle in the last band \[1/s\].
    pub vorticity: Vec<DVec3>,
    /// Change of each particle's velocity by confinement, all bands together \[m/s\].
    pub confinement: Vec<DVec3>,
    /// XSPH coefficient c of unresolved eddies at each particle; 0 for hair.
    pub eddies: Vec<f64>,
    /// S of the XSPH limiter, of each particle.
    pub exchange: Vec<f64>,
}
