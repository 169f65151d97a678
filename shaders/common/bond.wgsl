// Roots that are bound to a triangle of a body that deforms.

struct Bond {
    place: vec3f,   // parts of the edges from the triangle's first corner, and the height above it [m]
    bound: u32,     // 0: the strand has no bond
    frame: vec4f,   // of the clamp, in that of the triangle: along its first edge, across, and along its normal
}

// Corners of a triangle, from the body's center, before its motion [m].
struct Corners {
    a: vec3f,
    b: vec3f,
    c: vec3f,
}
