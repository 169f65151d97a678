//! The air at any places.

use std::f64::consts::PI;

use glam::DVec3;

use super::{Simulation, drive::held};
use crate::error::RunError;

/// The air at a place.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AirSample {
    /// Velocity \[m/s\]: the mean of the particles around, weighted by the kernel; the mean wind where there is none.
    pub velocity: DVec3,
    /// Density of the air \[kg/m³\]: ρ = ρ0 Σ V W (Müller et al. 2003, W their poly6).
    pub density: f64,
}

impl Simulation {
    /// The air at places in the world \[m\], which the periodic box repeats.
    ///
    /// # Errors
    /// [`RunError::Input`] where a place is not finite, or the scene has no air particles; [`RunError::Gpu`] when the
    /// device is lost.
    pub fn sample_air(&self, places: &[DVec3]) -> Result<Vec<AirSample>, RunError> {
        let Some(air) = self.scene.air.as_ref().filter(|_| self.plan.conditions.air.runs) else {
            return Err(RunError::Input("points: the scene has no air particles".to_owned()));
        };
        if let Some(row) = places.iter().position(|x| !held(x)) {
            let words = format!("points: expected finite numbers, found {:?} in row {row}", places[row].to_array());
            return Err(RunError::Input(words));
        }
        let (radius, size) = (air.kernel_radius, self.initial.air.size);
        let now = self.air_now()?;
        let positions: Vec<DVec3> = now.positions.iter().copied().map(DVec3::from_array).collect();
        // Cells of at least a kernel radius, which divide the box.
        let cells = (size / radius).floor().max(DVec3::ONE);
        let cell = |x: DVec3| (x.rem_euclid(size) / size * cells).floor().min(cells - 1.0);
        let index = |cell: DVec3| {
            let [x, y, z] = cell.rem_euclid(cells).to_array().map(|i| i as usize);
            (z * cells.y as usize + y) * cells.x as usize + x
        };
        let mut members = vec![Vec::new(); cells.element_product() as usize];
        positions.iter().enumerate().for_each(|(i, x)| members[index(cell(*x))].push(i));
        // Each cell once, where the box has fewer than three.
        let reach = |cells: f64| if cells < 3.0 { (0.0, cells - 1.0) } else { (-1.0, 1.0) };
        let steps = |axis: usize| {
            let (low, high) = reach(cells[axis]);
            (low as i32..=high as i32).map(f64::from)
        };
        let unit = self.initial.air.volume * 315.0 / (64.0 * PI * radius.powi(9));
        let wind = self.frame_velocity() + DVec3::from_array(self.last.wind.map(f64::from));
        let origin = self.origin();
        let sample = |place: &DVec3| {
            let x = *place - origin;
            let own = cell(x);
            let (mut sum, mut weights) = (DVec3::ZERO, 0.0);
            for (dx, dy, dz) in
                steps(0).flat_map(|dx| steps(1).flat_map(move |dy| steps(2).map(move |dz| (dx, dy, dz))))
            {
                for &i in &members[index(own + DVec3::new(dx, dy, dz))] {
                    let gap = positions[i] - x;
                    let gap = gap - size * (gap / size).round();
                    let weight = unit * (radius * radius - gap.length_squared()).max(0.0).powi(3);
                    weights += weight;
                    sum += weight * DVec3::from_array(now.velocities[i]);
                }
            }
            let about_wind = if weights > 0.0 { sum / weights } else { DVec3::ZERO };
            AirSample { velocity: wind + about_wind, density: air.rest_density * weights }
        };
        Ok(places.iter().map(sample).collect())
    }
}
