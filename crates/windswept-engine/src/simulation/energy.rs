//! Energy of the air's eddies, by band.

use glam::DVec3;

use super::Simulation;
use crate::{error::RunError, ops::Particles, report::BandEnergy};

/// Air, as positions in the box \[m\] and velocities about the mean wind \[m/s\].
pub(super) struct Air {
    pub(super) positions: Vec<[f64; 3]>,
    pub(super) velocities: Vec<[f64; 3]>,
}

impl Simulation {
    /// Energy ½ |û|² of the first of `turbulence.bands` at each air particle now, by stable id \[m²/s²\], about the
    /// wind as far as it has risen, in the accurate form whatever the law. Empty when no band is strengthened.
    ///
    /// # Errors
    /// As [`Self::density`].
    pub fn band_energy(&self) -> Result<Vec<f32>, RunError> {
        let (Some(band), true) = (self.scene.turbulence.bands.first(), self.plan.conditions.turbulence.runs) else {
            return Ok(Vec::new());
        };
        let air = self.air_now()?;
        let eddies = self.particles(&air).band_velocity(self.engine.gpu(), band.scale, self.scene.turbulence.filter)?;
        Ok(eddies.iter().map(|u| 0.5 * (u[0] * u[0] + u[1] * u[1] + u[2] * u[2])).collect())
    }

    /// Energy of each scale \[m\] now: the mean of ½ |û|² over the air \[m²/s²\], about the wind as far as it has
    /// risen. Empty without air particles.
    ///
    /// # Errors
    /// As [`Self::density`], and [`RunError::Measurement`] for a scale that no grid can have, or of eddies that are
    /// larger than the box: above half of its longest side.
    pub fn spectrum(&self, scales: &[f64]) -> Result<Vec<f64>, RunError> {
        if !self.plan.conditions.air.runs {
            return Ok(Vec::new());
        }
        let most = 0.5 * self.initial.air.size.max_element();
        if let Some(scale) = scales.iter().find(|scale| **scale > most) {
            return Err(RunError::Measurement(format!(
                "scales: expected at most half of the box, {most:.3} m, found {scale}"
            )));
        }
        let air = self.air_now()?;
        scales.iter().map(|&scale| self.mean_energy(&air, scale)).collect()
    }

    /// Energies of the scene's bands at the start and now.
    pub(super) fn band_energies(&self) -> Result<Vec<BandEnergy>, RunError> {
        let bands = &self.scene.turbulence.bands;
        if !self.plan.conditions.air.runs || bands.is_empty() {
            return Ok(Vec::new());
        }
        let (before, now) = (self.air_at_start(), self.air_now()?);
        let passes = self.pass_times();
        let cost = |i: usize| -> Option<f64> {
            let own: Vec<f64> = passes.iter().filter(|pass| pass.band == Some(i)).map(|pass| pass.ms).collect();
            (!own.is_empty()).then(|| own.iter().sum())
        };
        let energy = |(i, band): (usize, &windswept_scene::Band)| {
            Ok(BandEnergy {
                scale: band.scale,
                m2_per_s2_at_start: self.mean_energy(&before, band.scale)?,
                m2_per_s2: self.mean_energy(&now, band.scale)?,
                ms: cost(i),
            })
        };
        bands.iter().enumerate().map(energy).collect()
    }

    fn mean_energy(&self, air: &Air, scale: f64) -> Result<f64, RunError> {
        Ok(self.particles(air).band_energy(self.engine.gpu(), scale, self.scene.turbulence.filter)?)
    }

    fn particles<'a>(&self, air: &'a Air) -> Particles<'a> {
        let initial = &self.initial.air;
        Particles {
            positions: &air.positions,
            velocities: &air.velocities,
            mass: initial.mass,
            rest_density: initial.mass / initial.volume,
            radius: self.scene.air.as_ref().map_or(1.0, |air| air.kernel_radius),
            bounds: Some(initial.size.to_array()),
        }
    }

    fn air_at_start(&self) -> Air {
        let (air, wind) = (&self.initial.air, self.wind_at_start);
        Air {
            positions: air.positions.iter().map(|x| (*x - self.initial.origin).to_array()).collect(),
            velocities: air.velocities.iter().map(|v| (*v - wind).to_array()).collect(),
        }
    }

    pub(super) fn air_now(&self) -> Result<Air, RunError> {
        let s = self.engine.state();
        let [positions, velocities] = self.engine.read_vec4([&s.position, &s.velocity])?;
        let (hair, slots) = (self.engine.sizes().hair_points as usize, self.engine.slots()?);
        let wind = DVec3::from_array(self.last.wind.map(f64::from));
        let rows = |values: &[[f32; 4]], less: DVec3| -> Vec<[f64; 3]> {
            let row = |v: &[f32; 4]| (DVec3::new(v[0].into(), v[1].into(), v[2].into()) - less).to_array();
            slots.by_id(values[hair..].iter().map(row))
        };
        Ok(Air { positions: rows(&positions, DVec3::ZERO), velocities: rows(&velocities, wind) })
    }
}
