//! A force of the caller's own: accelerations of hair points and air particles, as arrays or by a callback.

use std::{error, fmt};

use glam::DVec3;

use super::{Simulation, drive::checked};
use crate::{
    error::{GpuError, RunError},
    frame::Frame,
};

/// Accelerations that push hair and air \[m/s²\].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Accelerations {
    /// Acceleration of each hair point; an empty array pushes no hair.
    pub hair: Vec<DVec3>,
    /// Acceleration of each air particle by stable id, as [`crate::AirFrame`] has them; an empty array pushes no air.
    pub air: Vec<DVec3>,
}

/// Result of a callback.
pub(super) type Answer = Result<Accelerations, Box<dyn error::Error + Send + Sync>>;

/// A function that is asked for the accelerations of each step.
pub(super) struct Callback(Box<dyn FnMut(&Frame) -> Answer + Send + Sync>);

impl fmt::Debug for Callback {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Callback")
    }
}

impl Simulation {
    /// Sets a force, which pushes hair points and air particles with these accelerations from the next step on, until
    /// another one is set; without any accelerations nothing is pushed any more. It takes the place of a callback
    /// ([`Self::set_force_by`]).
    ///
    /// A hair point has the force m a, which its rod takes implicitly; m is its own mass, without that of air which it
    /// carries ([`Strands::add_air_mass`](windswept_scene::Strands::add_air_mass)). A held point ignores it. A strand
    /// that sleeps wakes when its force changes. Air has a Δt added to its velocity in each step; pressure then takes
    /// out what would compress the air, and what blows through the fringe is still held at the mean wind. The air does
    /// not lose what hair gets from this force.
    ///
    /// # Errors
    /// [`RunError::Input`] when an array that is not empty has not a row for each point or particle, or something is
    /// beyond 1e18;
    /// [`RunError::Gpu`].
    pub fn set_force(&mut self, force: &Accelerations) -> Result<(), RunError> {
        self.push(force)?;
        (self.callback, self.loads_after) = (None, self.last.step);
        Ok(())
    }

    /// Sets a force by a function that is called before each step of Δt with the state as it is then, and returns the
    /// accelerations of that step, as [`Self::set_force`] takes them. It is called by [`Self::step`] and
    /// [`Self::step_timed`], not by [`Self::encode_steps`].
    ///
    /// ```no_run
    /// use windswept_engine::{Accelerations, Simulation, glam::DVec3};
    ///
    /// /// Draws hair to the plane x = 0, by 100 m/s² a metre.
    /// fn draw(simulation: &mut Simulation) {
    ///     simulation.set_force_by(|frame| {
    ///         let pull = |x: &[f32; 3]| DVec3::new(-100.0 * f64::from(x[0]), 0.0, 0.0);
    ///         Ok(Accelerations { hair: frame.hair.positions.iter().map(pull).collect(), ..Accelerations::default() })
    ///     });
    /// }
    /// ```
    ///
    /// An error that it returns ends the stepping there as [`RunError::Callback`]. A checkpoint holds the accelerations
    /// that were set last, and not the function: set it again after [`Self::load`].
    pub fn set_force_by(
        &mut self,
        force: impl FnMut(&Frame) -> Result<Accelerations, Box<dyn error::Error + Send + Sync>> + Send + Sync + 'static,
    ) {
        self.callback = Some(Callback(Box::new(force)));
    }

    /// Asks the callback, if there is one, for the accelerations of the next step.
    pub(super) fn ask_for_force(&mut self) -> Result<(), RunError> {
        let Some(mut callback) = self.callback.take() else { return Ok(()) };
        let asked = self.frame().and_then(|frame| (callback.0)(&frame).map_err(RunError::Callback));
        self.callback = Some(callback);
        self.push(&asked?)
    }

    fn push(&mut self, force: &Accelerations) -> Result<(), RunError> {
        self.was_set = true;
        let (hair, air) = (self.initial.hair.positions.len(), self.initial.air.positions.len());
        checked("hair", Some(&force.hair).filter(|rows| !rows.is_empty()).map(Vec::as_slice), hair)?;
        checked("air", Some(&force.air).filter(|rows| !rows.is_empty()).map(Vec::as_slice), air)?;
        let pushes = !(force.hair.is_empty() && force.air.is_empty());
        self.plan_force(pushes)?;
        if pushes {
            let all = |rows: &[DVec3], len: usize| if rows.is_empty() { vec![DVec3::ZERO; len] } else { rows.to_vec() };
            self.engine.write_force(&all(&force.hair, hair), &all(&force.air, air))?;
        }
        Ok(())
    }

    /// Makes room for accelerations and lets them push, or neither.
    pub(super) fn plan_force(&mut self, pushes: bool) -> Result<(), GpuError> {
        if self.plan.conditions.pushes.runs == pushes {
            return Ok(());
        }
        self.engine.make_room_for_force(pushes)?;
        self.plan.set_force(pushes);
        self.record_again()
    }
}
