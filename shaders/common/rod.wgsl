// A strand is points root to tip; segment k joins points k and k + 1, joint k precedes segment k (joint 0: the clamp).
//
//   ghost frame = joint 0 = [point 0]--segment 0--[point 1]--segment 1-- ...
//                 (half a segment long)        joint 1
//
// The ghost frame stands at the root, where the clamp is; from there to the middle of segment 0 is half a segment.

struct Strand {
    root_frame: vec4f,   // the ghost frame that clamps the root
    first_point: u32,
    first_segment: u32,
    points: u32,
    _unused: u32,
}

struct Segment {
    rest_rotation: vec4f,        // of the joint before it
    stretch_compliance: vec3f,   // shear d1, shear d2, stretch d3 [1/(N m)]
    rest_length: f32,            // m
    bend_compliance: vec3f,      // of the joint before it: bend d1, bend d2, twist d3 [1/(N m)]
    inverse_inertia: f32,        // 1/(kg m^2)
    radius: f32,                 // m, of a fibre
    fibres: f32,                 // that the strand stands for
}

struct Multipliers {
    stretch: vec4f,   // of stretch-shear, material frame [J]
    bend: vec4f,      // of bend-twist [J]
}

struct Health {
    committed: u32,   // after the last committed step
    found: u32,       // in this step; `commit` makes it the other
}

// Health of a strand: the lowest bit says that it is to be reset, the others count steps of over-strain on end.
const BAD: u32 = 1u;
const STRAINED_STEP: u32 = 2u;
const STRAINED_STEPS: u32 = 50u;   // on end, before it is counted
const STRAINED: f32 = 0.5;         // |l/l0 - 1|
