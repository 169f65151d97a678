//! One step, in execution order: the reference of the engine's `step.rs`.

use glam::DVec3;

use crate::{
    Parameters, State, commit,
    commit::Frozen,
    contact,
    fluid::{self, FrictionPoint, Moments, Pressed, Solid, Wall},
    forcing,
    neighbours::{self, Neighbours},
    rods,
    turbulence::{self, Mesh},
    viscosity,
};

/// Observer of a step: it gets the name of a pass of the engine, the state and the scratch when the reference has
/// computed what that pass does.
pub type Observer<'a> = dyn FnMut(&'static str, &State, &Scratch) + 'a;

/// The observer that does nothing.
pub fn unobserved(_: &'static str, _: &State, _: &Scratch) {}

/// One step of `parameters.step`.
///
/// # Errors
/// [`Frozen`] says why the step was not committed; the state is as it was before.
pub fn step(state: &mut State, p: &Parameters) -> Result<(), Frozen> {
    step_observed(state, p, &mut unobserved)
}

/// [`step`], with an observer. The observer gets no call for some passes: their results are seen at the next call.
///
/// # Errors
/// Those of [`step`].
pub fn step_observed(state: &mut State, p: &Parameters, see: &mut Observer<'_>) -> Result<(), Frozen> {
    let mut s = state.clone();
    // 1. Invalid strands are reset; clamps and bodies move; wind enters; air moves, and hair drifts among it.
    let invalid = forcing::recover(&mut s);
    see("forcing/reset", &s, &Scratch { invalid, ..Scratch::default() });
    forcing::carry(&mut s, p);
    see("forcing/carry", &s, &Scratch { invalid, ..Scratch::default() });
    let mut w = Scratch { invalid, ..forcing::run(&s, p, see) };
    // 2. List neighbours.
    neighbours::run(&mut w, p);
    see("neighbours/list", &s, &w);
    // 3. Pressure, or density constraints (eq. 1), of hair and air together or each for itself.
    fluid::run(&s, &mut w, p, see);
    // 4. Air drags strands, which keep their length and shape and stay out of bodies; they slow the air.
    rods::run(&mut s, &mut w, p, see);
    // 5. Air flows around bodies.
    contact::run(&mut w, p);
    see("contact/body_impulse", &s, &w);
    // 6. Strengthen the eddies of each band (eqs. 2 to 6), air only.
    turbulence::run(&mut s, &mut w, p, see);
    // 7. Neighbours share velocity (eqs. 7, 8).
    viscosity::run(&s, &mut w, p);
    see("viscosity/xsph", &s, &w);
    // 8. Commit, or freeze and report.
    commit::run(&mut s, &mut w, p)?;
    see("commit/state", &s, &w);
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
    /// Multiplier λ of the density constraint of each particle \[kg m²\].
    pub multiplier: Vec<f64>,
    /// Part of each multiplier that becomes velocity \[kg m²\].
    pub felt: Vec<f64>,
    /// Last move of each particle by the density constraint, by friction or by the spread \[m\].
    pub shift: Vec<DVec3>,
    /// Part of the move by the density constraint that becomes velocity \[m\].
    pub velocity_shift: Vec<DVec3>,
    /// Hair points, as friction sees them.
    pub friction_points: Vec<FrictionPoint>,
    /// Normal impulse on each hair point, over its mass \[m/s\].
    pub normal_impulses: Vec<f64>,
    /// Sum of the moves of each particle by the density constraint \[m\]; of hair that shares pressure with air, the
    /// move by the impulse of the pressure over time.
    pub correction: Vec<DVec3>,
    /// Wall at each particle that pressure acts on; none without bodies.
    pub walls: Vec<Wall>,
    /// Position of each particle when it was sorted, before the spread \[m\].
    pub sorted_position: Vec<DVec3>,
    /// Deformation of the flow at each particle in the step.
    pub deformation: Vec<f64>,
    /// Divergence s at each particle \[1/s\].
    pub divergence: Vec<f64>,
    /// Divergence deposited on the nodes of the coarse grid.
    pub coarse_divergence: Vec<f64>,
    /// Pressure of each node of the coarse grid.
    pub coarse: Vec<f64>,
    /// Change of each particle by the coarse pressure \[m/s\].
    pub coarse_change: Vec<DVec3>,
    /// Sums over each body as if air filled it.
    pub solids: Vec<Solid>,
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
    /// Last band, an index into [`Parameters::bands`].
    pub band: usize,
    /// Grids of the last band's filter: air deposited, and smoothed.
    pub grids: [Mesh; 2],
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
