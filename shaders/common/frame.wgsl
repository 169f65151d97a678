// The frame that the simulation runs in: it goes with a body's translation (`air.follows`), or stands still.
import package::common::status::status;

struct Entry {
    place: vec3f,      // m, way since the start
    time: f32,         // s
    velocity: vec3f,   // m/s, in the step that ends then
}

// Way of the frame from the start to the step's end [m].
fn frame_place() -> vec3f {
    return status.frame_place;
}
