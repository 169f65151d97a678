// Rigid motions by keyframes: x(t) = c + R (x - c) + T, c the thing's centre.
//
// Time is counted in steps: a whole number of them and a fraction. Their difference to the step's own number is exact,
// so that an hour into a run the time since a keyframe is as precise as in its first second.
import package::common::quaternion::{product, rotation};

struct Keyframe {
    translation: vec3f,    // translation T at the keyframe [m]
    step: u32,             // whole part of the keyframe's time, `step + fraction` [steps]
    rotation: vec4f,       // rotation R at the keyframe
    displacement: vec3f,   // translation from this keyframe to the next [m]
    fraction: f32,         // rest of the keyframe's time, 0 to 1 [steps]
    turn: vec3f,           // rotation vector from this keyframe to the next, less than half a turn [rad]
    rate: f32,             // part of the way to the next keyframe that one step goes [1/steps]; 0 for the last
    pose: u32,             // of a body that deforms: the pose that it leaves,
    pose_part: f32,        // part of the way to the next pose,
    pose_span: f32,        // and what the next keyframe adds to that
}

struct Pose {
    translation: vec3f,   // translation T [m]
    rotation: vec4f,      // rotation R
}

// Keyframes of all motions. The binding's number is above those that a pass has of its own.
@group(0) @binding(10) var<storage, read> keyframes: array<Keyframe>;

// Whether roots or bodies have keyframes: a switch (`shaders/src/lib.rs`).
override KEYFRAMES: bool = true;

// Whether a motion of so many keyframes is one; without any it rests.
fn moves(count: u32) -> bool {
    return KEYFRAMES && count > 0u;
}

// Where a motion is: between a keyframe, or a pose, and the next.
struct Phase {
    index: u32,   // of keyframes, counted from the motion's first: the last that has begun, else the first
    part: f32,    // of the way to the next
}

// Phase after `steps` steps of the motion that has `count` keyframes from `first` on.
fn phase_after(steps: u32, first: u32, count: u32) -> Phase {
    if !moves(count) { return Phase(0u, 0.0); }
    var low = first;
    var high = first + count;
    while high - low > 1u {
        let middle = (low + high) / 2u;
        let key = keyframes[middle];
        if key.step < steps || (key.step == steps && key.fraction == 0.0) { low = middle; } else { high = middle; }
    }
    let key = keyframes[low];
    let since = select(0.0, f32(steps - key.step) - key.fraction, steps > key.step);
    return Phase(low - first, min(since * key.rate, 1.0));
}

// Pose in a phase of the motion that has `count` keyframes from `first` on; a motion without any rests.
fn pose_in(phase: Phase, first: u32, count: u32) -> Pose {
    if !moves(count) { return Pose(vec3f(0.0), vec4f(0.0, 0.0, 0.0, 1.0)); }
    let key = keyframes[first + phase.index];
    return Pose(key.translation + phase.part * key.displacement,
        product(rotation(phase.part * key.turn), key.rotation));
}

// Where a body that deforms is between its poses.
fn shape_in(phase: Phase, first: u32, count: u32) -> Phase {
    if !moves(count) { return Phase(0u, 0.0); }
    let key = keyframes[first + phase.index];
    return Phase(key.pose, key.pose_part + phase.part * key.pose_span);
}

fn pose_after(steps: u32, first: u32, count: u32) -> Pose {
    return pose_in(phase_after(steps, first, count), first, count);
}
