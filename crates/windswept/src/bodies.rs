//! Bodies as the shaders see them (`shaders/common/body.wgsl`).

use windswept_scene::{InitialState, Scene};
use windswept_shaders::common::body::Body;

use crate::{motion::Motions, rods::vec3};

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
            ..Body::default()
        }
    });
    each.collect()
}
