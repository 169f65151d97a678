//! Quantities of the state on request: the density of all particles, and the vorticity of the air.

use super::Simulation;
use crate::{
    error::RunError,
    step::{self, Quantity},
};

impl Simulation {
    /// Density ρ/ρ0 at every particle now, hair points first, then air by stable id; empty when the scene's particles
    /// do not meet.
    ///
    /// # Errors
    /// [`RunError`] when the neighbour list cannot grow or the device is lost.
    pub fn density(&mut self) -> Result<Vec<f32>, RunError> {
        self.measure(Quantity::Density)?;
        if !self.plan.conditions.neighbours.runs {
            return Ok(Vec::new());
        }
        let mut density = self.engine.read(&self.engine.state().density)?;
        let air = density.split_off(self.engine.sizes().hair_points as usize);
        density.extend(self.engine.slots()?.by_id(air));
        Ok(density)
    }

    /// Vorticity |ω| of the air now by stable id, by the plain SPH sum \[1/s\]; empty when the scene's particles do not
    /// meet.
    ///
    /// # Errors
    /// As [`Self::density`].
    pub fn air_vorticity(&mut self) -> Result<Vec<f32>, RunError> {
        self.measure(Quantity::Vorticity)?;
        if !self.plan.conditions.neighbours.runs {
            return Ok(Vec::new());
        }
        let hair = self.engine.sizes().hair_points as usize;
        let (slots, vorticity) = (self.engine.slots()?, [&self.engine.state().vorticity]);
        let air = |[omega]: [&[[f32; 4]]; 1]| slots.by_id(omega.iter().skip(hair).map(|omega| omega[3]));
        Ok(self.engine.view_vec4(vorticity, air)?)
    }

    /// Runs the passes of a quantity over the committed state. A step that ended the run stays frozen: only for these
    /// passes it thaws.
    fn measure(&mut self, quantity: Quantity) -> Result<(), RunError> {
        if !self.plan.conditions.neighbours.runs {
            return Ok(());
        }
        if self.last.causes != 0 {
            let frozen = self.last;
            self.last = self.engine.thaw(&frozen)?;
            let measured = self.measure(quantity);
            self.engine.set_status(&frozen)?;
            self.last = frozen;
            return measured;
        }
        let plan = &self.plan;
        if self.engine.evaluate(|r| step::record_quantity(r, plan, quantity))? {
            self.record_again()?;
        }
        self.finish_steps()
    }
}
