//! Forces on hair in the last step: of the air on its points, and of strands on their clamps.

use glam::{DQuat, DVec3};
use windswept_scene::Model;
use windswept_shaders::common::{air::Sampled, rod::StrandHistory};

use super::Simulation;
use crate::error::RunError;

/// Forces on hair in the last step, substeps counted singly; zero before the first one.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct HairLoads {
    /// Force of the air on each point, drag and lift \[N\], of all fibres that the strand stands for.
    pub drag: Vec<[f32; 3]>,
    /// Velocity of the air at each point from which the drag follows \[m/s\]: in model `two-way` that of the air
    /// particles, which the hair has slowed. Zero in the models `particles` and `none`, which know no such air.
    pub air_velocity: Vec<[f32; 3]>,
    /// Force of each strand on its clamp \[N\]: that of its first segment on its root, without the loads on the root
    /// itself; in the model `two-way` it has the pressure of other strands too. Not a number where something else holds
    /// the strand as well: a held tip, a pin, a body that it touches. Zero in the model `particles`.
    pub root_force: Vec<[f32; 3]>,
    /// Moment of each strand on its clamp, about the root \[N m\], without the inertia of the segments' own turns. Not
    /// a number, and zero, where `root_force` is.
    pub root_moment: Vec<[f32; 3]>,
}

impl Simulation {
    /// Forces on hair in the last step.
    ///
    /// The force on a clamp is the sum of those of the rod on the strand's other points, which follow from the velocity
    /// that the rod gave each of them. A sleeping strand has those of its last step awake.
    ///
    /// # Errors
    /// [`RunError::Measurement`] where there was no step since the simulation was loaded or updated, or a force was
    /// set; [`RunError::Gpu`] when the device is lost.
    pub fn hair_loads(&self) -> Result<HairLoads, RunError> {
        if self.last.step > 0 && self.last.step == self.loads_after {
            let words =
                "forces on hair: expected a step since the last update, set_force or load: they are those of a step";
            return Err(RunError::Measurement(words.to_owned()));
        }
        let (s, hair) = (self.engine.state(), &self.initial.hair);
        let step = f64::from(self.engine.seconds_of_step());
        let xyz = |v: &[f32; 4]| [v[0], v[1], v[2]];
        let impulses = self.engine.read(&s.drag_impulse)?;
        let drag = impulses.iter().map(|impulse| xyz(impulse).map(|x| x / step as f32)).collect();
        let felt = matches!(self.scene.interaction.model, Model::TwoWay | Model::Drag) && self.last.step > 0;
        let mean = if felt { self.last.wind } else { [0.0; 3] };
        let sampled: Vec<Sampled> = if felt { self.engine.read(&s.sampled)? } else { Vec::new() };
        let air = |p| sampled.get(p).map_or(mean, |air: &Sampled| air.wind);
        let air_velocity = (0..hair.positions.len()).map(air).collect();
        let positions = self.engine.read(&s.position)?;
        let history = self.engine.read(&s.point_history)?;
        let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        let pushes = self.engine.read(&s.pushed)?;
        let pushed = |p: usize| pushes.get(p).map_or(DVec3::ZERO, |push| vector(xyz(push)));
        let pins = self.engine.read(&s.pins)?;
        let (bodies, contacts) = (self.scene.bodies.len(), self.engine.read(&s.contact_history)?);
        let touched = |place: usize| (0..bodies).any(|body| contacts[place * bodies + body].force != 0.0);
        let moved = self.last.step > 0 && self.scene.interaction.model != Model::Particles;
        let clamp = |strand: usize| {
            let points = hair.points(strand);
            let [root, tip] = [points.start, points.end - 1].map(|p| hair.inverse_mass[p]);
            let (mut force, mut moment) = (DVec3::ZERO, DVec3::ZERO);
            if root > 0.0 || !moved {
                return [force, moment];
            }
            let segments = hair.segments(strand).map(|k| hair.positions.len() + k);
            let touches = points.clone().chain(segments).any(&touched);
            if tip == 0.0 || touches || points.clone().any(|p| pins[p].held != 0) {
                return [DVec3::NAN; 2];
            }
            let at = vector(xyz(&positions[points.start]));
            for p in points.skip(1) {
                let mass = 1.0 / hair.inverse_mass[p];
                let gravity = hair.weight(p) * DVec3::from_array(self.scene.gravity);
                let load = vector(xyz(&impulses[p])) / step + mass * hair.weight(p) * pushed(p);
                let of_rod = mass * (vector(history[p].own) / step - gravity) - load;
                force -= of_rod;
                moment -= (vector(xyz(&positions[p])) - at).cross(of_rod);
            }
            [force, moment]
        };
        let clamps: Vec<[DVec3; 2]> = (0..hair.len()).map(clamp).collect();
        let [root_force, root_moment] =
            [0, 1].map(|i| clamps.iter().map(|clamp| clamp[i].as_vec3().to_array()).collect());
        Ok(HairLoads { drag, air_velocity, root_force, root_moment })
    }

    /// Place \[m\] and frame of the clamp of each strand now: those that [`Self::set_roots`] and keyframes move.
    ///
    /// # Errors
    /// [`RunError::Gpu`] when the device is lost.
    pub fn clamps(&self) -> Result<Vec<(DVec3, DQuat)>, RunError> {
        let strands = self.engine.read(&self.engine.state().strand_history)?;
        let origin = self.origin();
        let clamp = |strand: &StrandHistory| {
            let position = DVec3::from_array(strand.root.position.map(f64::from)) + origin;
            (position, DQuat::from_array(strand.root.frame.map(f64::from)))
        };
        Ok(strands.iter().map(clamp).collect())
    }
}
