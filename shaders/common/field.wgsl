// Force fields as the host declares them. A field is a wind of its own within its reach.

struct Field {
    origin: vec3f,    // m
    reach: f32,       // m, distance at which the field ends
    axis: vec3f,      // unit vector of a jet or a vortex
    radius: f32,      // m, of a jet, or where a vortex or a point blows with its strength
    kind: u32,        // JET, VORTEX, POINT
    uptake: f32,      // m, way over which air takes the field's wind up
    first_key: u32,   // index of its first keyframe in field_keyframes
    keys: u32,        // number of its keyframes
}

const JET: u32 = 0u;
const VORTEX: u32 = 1u;
const POINT: u32 = 2u;

@group(0) @binding(9) var<storage, read> fields: array<Field>;
