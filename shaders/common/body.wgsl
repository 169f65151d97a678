// Bodies: all points within a radius of a line, the axis. A sphere's axis is a point.
//
// All that depends on a body's shape stands here: what it is made of, where it is after a step (`place`), the signed distance of a
// point and its gradient (`surface`), and where a way enters it (`entry`). Passes ask for these and for nothing else.
import package::common::{quaternion::{conjugate, product, rotate}, motion::Pose};

struct Body {
    start: vec3f,          // start of the axis, before any motion [m]
    radius: f32,           // distance of the surface from the axis [m]
    end: vec3f,            // end of the axis, before any motion [m]
    friction: f32,         // Coulomb's coefficient of hair on the body
    first_keyframe: u32,   // index of the body's first keyframe
    keyframes: u32,        // number of the body's keyframes; without any the body rests
}

// Rounds that a pass goes over all bodies: a second one for what lies between two bodies.
const ROUNDS: u32 = 2u;

// The bits below say what bodies did to a strand in a step.

const PUSHED: u32 = 1u;   // bit of `touched`: a body pushed one of the strand's points
const MOVED: u32 = 2u;    // bit of `touched`: some body moved, and the strand may have lain on it

// A body in this step.
struct Placed {
    start: vec3f,          // start of the axis, after the step [m]
    radius: f32,           // distance of the surface from the axis [m]
    end: vec3f,            // end of the axis, after the step [m]
    friction: f32,         // Coulomb's coefficient of hair on the body
    center: vec3f,         // middle of the axis, after the step [m]
    center_before: vec3f,  // middle of the axis, before the step [m]
    turn: vec4f,           // rotation in the step
}

// The body after a step that takes it from one pose to another.
fn place(body: Body, before: Pose, after: Pose) -> Placed {
    let center = 0.5 * (body.start + body.end);
    let half = rotate(after.rotation, 0.5 * (body.end - body.start));
    let now = center + after.translation;
    return Placed(
        now - half, body.radius, now + half, body.friction, now, center + before.translation,
        normalize(product(after.rotation, conjugate(before.rotation))),
    );
}

// The surface seen from a point.
struct Surface {
    normal: vec3f,         // unit vector out of the body
    distance: f32,         // distance of the point from the surface, negative inside [m]
}

fn surface(body: Placed, x: vec3f) -> Surface {
    let axis = body.end - body.start;
    let squared = dot(axis, axis);
    let along = select(0.0, clamp(dot(x - body.start, axis) / squared, 0.0, 1.0), squared > 0.0);
    let gap = x - (body.start + along * axis);
    let r = length(gap);
    if r > 1e-6 * body.radius { return Surface(gap / r, r - body.radius); }
    // From the axis every direction across it leads out.
    let across = select(vec3f(axis.z, 0.0, -axis.x), vec3f(0.0, axis.z, -axis.y), abs(axis.x) > abs(axis.y));
    return Surface(select(vec3f(0.0, 1.0, 0.0), normalize(across), squared > 0.0), -body.radius);
}

// Where a point that goes with the body is after the step.
fn carried(body: Placed, before: vec3f) -> vec3f {
    return body.center + rotate(body.turn, before - body.center_before);
}

// How far the body's own point that is at `x` after the step has moved in it [m].
fn surface_move(body: Placed, x: vec3f) -> vec3f {
    return x - (body.center_before + rotate(conjugate(body.turn), x - body.center));
}

// Part of a way that says that the way meets nothing: any number above 1 does.
const NEVER: f32 = 2.0;

// Part of the way at which a x^2 + 2 b x + c = 0 is met from above; 0 where it is below at the start already.
fn first_root(a: f32, b: f32, c: f32) -> f32 {
    if c <= 0.0 { return 0.0; }
    let d = b * b - a * c;
    // Written without the difference of b and the root: c/(-b + sqrt(d)).
    if b >= 0.0 || d < 0.0 { return NEVER; }
    return c / (sqrt(d) - b);
}

fn entry_of_ball(center: vec3f, radius: f32, start: vec3f, way: vec3f) -> f32 {
    let gap = start - center;
    let r = length(gap);
    return first_root(dot(way, way), dot(gap, way), (r - radius) * (r + radius));
}

// Part of the way from `start` along `way` at which it enters the body: 0 if it starts inside, above 1 if it does not.
fn entry(body: Placed, start: vec3f, way: vec3f) -> f32 {
    let ends = min(entry_of_ball(body.start, body.radius, start, way), entry_of_ball(body.end, body.radius, start, way));
    let axis = body.end - body.start;
    let squared = dot(axis, axis);
    if squared == 0.0 { return ends; }
    // Between the ends: everything across the axis.
    let gap = start - body.start;
    let gap_across = gap - dot(gap, axis) / squared * axis;
    let way_across = way - dot(way, axis) / squared * axis;
    let r = length(gap_across);
    let part = first_root(
        dot(way_across, way_across), dot(gap_across, way_across), (r - body.radius) * (r + body.radius),
    );
    let height = dot(gap + part * way, axis);
    return min(ends, select(NEVER, part, height >= 0.0 && height <= squared));
}
