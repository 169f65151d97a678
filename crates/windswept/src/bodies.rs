//! Bodies as the shaders see them (`shaders/common/body.wgsl`).

use std::mem::offset_of;

use bytemuck::{Pod, Zeroable};
use windswept_scene::{InitialState, Scene};
use windswept_shaders::layout;

use crate::{motion::Motions, params::assert_layout, rods::vec3};

/// `Body`, field by field.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[allow(missing_docs)]
pub(crate) struct Body {
    pub start: [f32; 3],
    pub radius: f32,
    pub end: [f32; 3],
    pub friction: f32,
    pub first_keyframe: u32,
    pub keyframes: u32,
    pub _unused: [u32; 2],
}

assert_layout!(Body { start, radius, end, friction, first_keyframe, keyframes });

/// The scene's bodies, in local coordinates.
#[must_use]
pub(crate) fn bodies(scene: &Scene, initial: &InitialState, motions: &Motions) -> Vec<Body> {
    let each = scene.bodies.iter().zip(&motions.bodies).map(|(body, keyframes)| {
        let round = body.shape.round();
        let [start, end] = round.ends.map(|end| vec3(end - initial.origin));
        Body {
            start,
            radius: round.radius as f32,
            end,
            friction: body.friction as f32,
            first_keyframe: keyframes.start,
            keyframes: keyframes.len() as u32,
            _unused: [0; 2],
        }
    });
    each.collect()
}
