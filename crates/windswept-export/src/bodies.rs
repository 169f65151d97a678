//! Bodies as they stand in a frame.

use std::collections::HashMap;

use windswept_engine::Frame;
use windswept_scene::{CheckedBody, CheckedShape, Pose, Triangles};

/// The pose of each body where the frame has it, or where the scene has it at the frame's time if the frame does not
/// say.
pub(crate) fn pose(bodies: &[CheckedBody], i: usize, frame: &Frame) -> Pose {
    frame.bodies.get(i).copied().unwrap_or_else(|| bodies[i].motion.at(frame.time))
}

/// The shape of each body in a frame.
pub(crate) fn in_frame<'a>(bodies: &'a [CheckedBody], frame: &'a Frame) -> impl Iterator<Item = CheckedShape> + 'a {
    (0..bodies.len()).map(|i| bodies[i].placed(&pose(bodies, i, frame), frame.time))
}

/// Points of a round body from pole to pole, and around.
const OUTLINE: [u32; 2] = [24, 48];
/// Points no farther apart are one \[m\].
const SAME: f64 = 1e-9;

/// The surface of a shape with each of its points once: closed where the shape is.
pub(crate) fn welded(shape: &CheckedShape) -> Triangles {
    let surface = shape.surface(OUTLINE[0], OUTLINE[1]);
    let mut points = Vec::new();
    let mut known = HashMap::new();
    let mut index = Vec::with_capacity(surface.points.len());
    for x in surface.points {
        let place = (x / SAME).round().as_i64vec3();
        index.push(*known.entry(place).or_insert_with(|| {
            points.push(x);
            points.len() as u32 - 1
        }));
    }
    let corners = surface.corners.iter().map(|corners| corners.map(|corner| index[corner as usize]));
    // At a pole two corners of a triangle are one.
    let corners = corners.filter(|[a, b, c]| a != b && b != c && c != a).collect();
    Triangles { points, corners, ..Triangles::default() }
}
