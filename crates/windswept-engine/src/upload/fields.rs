//! Force fields as the shaders see them (`shaders/common/field.wgsl`).

use windswept_scene::{CheckedForce, CheckedScene, ForceField, InitialState};
use windswept_shaders::common::field::{Field, JET, POINT, VORTEX};

use crate::upload::vectors::vec3;

/// The scene's force fields, in local coordinates, and their keyframes. There are none where fields do nothing.
#[derive(Debug, Default)]
pub(crate) struct Fields {
    /// The fields.
    pub(crate) fields: Vec<Field>,
    /// Times \[s\] and strengths \[m/s\] of all fields, field by field.
    pub(crate) keyframes: Vec<[f32; 2]>,
}

impl Fields {
    pub(crate) fn new(scene: &CheckedScene, initial: &InitialState) -> Self {
        let mut all = Self::default();
        if scene.why_no_fields().is_none() {
            scene.forces.iter().for_each(|force| all.add(force, initial));
        }
        all
    }

    fn add(&mut self, force: &CheckedForce, initial: &InitialState) {
        let keys = force.strengths();
        self.fields.push(Field {
            origin: vec3(glam::DVec3::from_array(force.origin) - initial.origin),
            reach: force.reach as f32,
            axis: vec3(force.axis()),
            radius: force.radius as f32,
            kind: match force.field {
                ForceField::Jet => JET,
                ForceField::Vortex => VORTEX,
                ForceField::Point => POINT,
            },
            uptake: force.uptake as f32,
            first_key: self.keyframes.len() as u32,
            keys: keys.len() as u32,
        });
        self.keyframes.extend(keys.into_iter().map(|(time, strength)| [time as f32, strength as f32]));
    }
}
