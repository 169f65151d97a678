//! Bodies as they stand in a frame.

use windswept_engine::Frame;
use windswept_scene::{CheckedBody, CheckedShape};

/// The shape of each body where the frame has it, or where the scene has it at the frame's time if the frame does not
/// say.
pub(crate) fn in_frame<'a>(bodies: &'a [CheckedBody], frame: &'a Frame) -> impl Iterator<Item = CheckedShape> + 'a {
    bodies.iter().enumerate().map(|(i, body)| match frame.bodies.get(i) {
        Some(pose) => body.placed(pose, frame.time),
        None => body.at(frame.time),
    })
}
