// Bodies: all points within a radius of a box, or all points that a mesh encloses. The box of a sphere is a point, that
// of a capsule a line, and that of a plane has one side that ends. A mesh is a grid of signed distances, trilinear
// between the nodes.
//
// A mesh that deforms goes from pose to pose, and has the grids of two at a time: those of every other pose in the
// first half of its values, the rest in the second. Between two poses its distance is linear. Each pose has beside the
// distances the move of the nearest place of the surface since the pose before.
//
// This file has every function that depends on a body's shape: its place after a step (`place`), the signed distance of
// a point and its gradient (`surface`, `near`).
import package::common::{quaternion::{conjugate, product, rotate, turned_by}, motion::{phase_after, pose_in, shape_in}};

struct Body {
    center: vec3f,         // the point that the body turns about, before any motion: of a mesh its file's origin [m]
    radius: f32,           // distance of the surface from the box [m]
    low: vec3f,            // corner of the box, from the center, in the body's own axes [m]
    inradius: f32,         // radius of the largest ball in the body [m]
    high: vec3f,           // opposite corner of the box [m]
    friction: f32,         // Coulomb's coefficient of hair on the body
    rotation: vec4f,       // from the body's own axes to the world's, before any motion
    grid: Grid,            // signed distances of a mesh
    first_keyframe: u32,   // index of the body's first keyframe
    keyframes: u32,        // number of the body's keyframes; without any the body rests
    pose_values: u32,      // values of a pose of a mesh that deforms; 0 of any other
    half: u32,             // 1: its first pose is in the second half
}

// A grid of signed distances, in a mesh's own place: the origin of its file is at 0.
struct Grid {
    origin: vec3f,         // the first node [m]
    spacing: f32,          // distance between nodes [m]
    counts: vec3u,         // nodes along x, y and z; 0 unless the body is a mesh
    first: u32,            // index of the first node's distance
}

// Signed distances at the nodes of all grids [m], x running fastest, then y; each pose of a mesh that deforms adds a
// move x, y, z of each node behind them [m]. Passes number their own bindings below 9.
@group(0) @binding(9) var<storage, read> distances: array<f32>;

// Whether the scene has bodies, whether one is a mesh, and whether one deforms: switches (`shaders/src/lib.rs`).
override BODIES: bool = true;
override MESHES: bool = true;
override DEFORMS: bool = true;

// A body in this step.
struct Placed {
    center: vec3f,         // the point that the body turns about, after the step [m]
    radius: f32,           // distance of the surface from the box [m]
    low: vec3f,            // corner of the box, from the center, in the body's own axes [m]
    inradius: f32,         // radius of the largest ball in the body [m]
    high: vec3f,           // opposite corner of the box [m]
    friction: f32,         // Coulomb's coefficient of hair on the body
    center_before: vec3f,  // the point that the body turns about, before the step [m]
    turn: vec4f,           // rotation in the step
    rotation: vec4f,       // from the body's own axes to the world's, after the step
    grid: Grid,            // signed distances of a mesh, of its pose before,
    next: u32,             // first distance of its pose after,
    part: f32,             // and part of the way there
    moved: vec2f,          // parts of the moves of both poses that the step makes
}

// The body before and after the step that follows `steps` others.
fn place(body: Body, steps: u32) -> Placed {
    let starts = phase_after(steps, body.first_keyframe, body.keyframes);
    let ends = phase_after(steps + 1u, body.first_keyframe, body.keyframes);
    let before = pose_in(starts, body.first_keyframe, body.keyframes);
    let after = pose_in(ends, body.first_keyframe, body.keyframes);
    // Poses of a body that deforms.
    let left = shape_in(starts, body.first_keyframe, body.keyframes);
    let reached = shape_in(ends, body.first_keyframe, body.keyframes);
    let deforms = body.pose_values > 0u;
    let half = (reached.index + body.half) & 1u;
    var grid = body.grid;
    grid.first += half * body.pose_values;
    // A step that passes a pose makes the rest of the move to there.
    let passes = left.index < reached.index;
    let moved = vec2f(select(0.0, 1.0 - left.part, passes), reached.part - select(left.part, 0.0, passes));
    return Placed(
        body.center + after.translation, body.radius, body.low, body.inradius, body.high, body.friction,
        body.center + before.translation,
        // Exactly the identity where the body does not turn: a body at rest wakes no hair.
        select(normalize(product(after.rotation, conjugate(before.rotation))), vec4f(0.0, 0.0, 0.0, 1.0),
            all(before.rotation == after.rotation)),
        normalize(product(after.rotation, body.rotation)), grid, body.grid.first + (1u - half) * body.pose_values,
        select(0.0, reached.part, deforms), select(vec2f(0.0), moved, deforms),
    );
}

// The surface seen from a point.
struct Surface {
    normal: vec3f,         // unit vector out of the body
    distance: f32,         // distance of the point from the surface, negative inside [m]
}

fn surface(body: Placed, x: vec3f) -> Surface {
    return near(body, x - body.center, vec3f(0.0));
}

// The surface seen from the place `base + way` [m], with `base` relative to the body's center. A short `way` enters
// with its own rounding error, not with that of the sum: hair at rest does not tremble.
fn near(body: Placed, base: vec3f, way: vec3f) -> Surface {
    let back = conjugate(body.rotation);
    let own = rotate(back, base);
    let own_way = rotate(back, way);
    var seen: Surface;
    if is_mesh(body) { seen = surface_of_grid(body, own, own_way); } else { seen = surface_of_box(body, own, own_way); }
    return Surface(rotate(body.rotation, seen.normal), seen.distance);
}

// Distance from the surface about a box, and its gradient, at `x + way`, in the body's own axes.
fn surface_of_box(body: Placed, x: vec3f, way: vec3f) -> Surface {
    let none = vec3f(0.0);
    // From the box to the start and to the end of the way.
    let first = max(x - body.high, none) - max(body.low - x, none);
    let above = (x - body.high) + way;
    let below = (body.low - x) - way;
    let last = max(above, none) - max(below, none);
    let moved = select(last - first, way, first * last > none);
    let r = length(first + moved);
    if r > 1e-6 * body.radius {
        return Surface((first + moved) / r,
            (length(first) - body.radius) + dot(moved, 2.0 * first + moved) / (length(first) + r));
    }
    // In the box the nearest side counts; of sides that are equally near, one across the longest.
    let beyond = max(below, above);
    let sign = select(vec3f(1.0), vec3f(-1.0), below > above);
    if beyond.y >= max(beyond.x, beyond.z) { return Surface(vec3f(0.0, sign.y, 0.0), beyond.y - body.radius); }
    if beyond.z >= beyond.x { return Surface(vec3f(0.0, 0.0, sign.z), beyond.z - body.radius); }
    return Surface(vec3f(sign.x, 0.0, 0.0), beyond.x - body.radius);
}

fn is_mesh(body: Placed) -> bool {
    return MESHES && body.grid.counts.x > 0u;
}

// Distance from the surface of a grid, and its unit gradient, at `x + way`. Beyond the grid the distance is the least
// that the distance at the grid's side allows.
fn surface_of_grid(body: Placed, x: vec3f, way: vec3f) -> Surface {
    let grid = body.grid;
    let last = vec3f(grid.counts - 1u);
    let place = (x - grid.origin) / grid.spacing;
    var cell = floor(place);
    var part = (place - cell) + way / grid.spacing;
    cell += floor(part);
    part -= floor(part);
    let held = clamp(cell, vec3f(0.0), last - 1.0);
    let inside = clamp(part + (cell - held), vec3f(0.0), vec3f(1.0));
    let beyond = grid.spacing * ((cell - held) + (part - inside));
    cell = held;
    part = inside;
    let seat = vec3u(cell);
    let row = grid.counts.x;
    let layer = row * grid.counts.y;
    let i = seat.z * layer + seat.y * row + seat.x;
    // Four edges along x: of both y at the lower z, of both y at the upper z.
    let near = vec4f(at_node(body, i), at_node(body, i + row), at_node(body, i + layer),
        at_node(body, i + layer + row));
    let far = vec4f(at_node(body, i + 1u), at_node(body, i + row + 1u), at_node(body, i + layer + 1u),
        at_node(body, i + layer + row + 1u));
    let along_x = mix(near, far, part.x);
    let slope_x = mix((far - near).xz, (far - near).yw, part.y);
    let along_y = mix(along_x.xz, along_x.yw, part.y);
    let slope_y = along_x.yw - along_x.xz;
    let gradient = vec3f(mix(slope_x.x, slope_x.y, part.z), mix(slope_y.x, slope_y.y, part.z), along_y.y - along_y.x);
    let distance = mix(along_y.x, along_y.y, part.z);
    // Where the interpolated gradient vanishes the normal is +y, as good as any.
    let steep = length(gradient) > 1e-6 * grid.spacing;
    let normal = select(vec3f(0.0, 1.0, 0.0), gradient / length(gradient), steep);
    if all(beyond == vec3f(0.0)) { return Surface(normal, distance); }
    // The nearest point of the surface is on the other side of the plane through `inside`, across the way from there.
    let out = beyond + distance * select(vec3f(0.0), normal, beyond == vec3f(0.0));
    return Surface(normalize(out), length(vec4f(beyond, distance)));
}

// Signed distance at a node of a body's grid [m].
fn at_node(body: Placed, node: u32) -> f32 {
    let before = distances[body.grid.first + node];
    if !DEFORMS { return before; }
    // To the bit where the body does not deform.
    return before + body.part * (distances[body.next + node] - before);
}

// How far the body's surface near a place has moved in the step by deforming [m]; `x` is relative to the center, after
// the step.
fn deformed(body: Placed, x: vec3f) -> vec3f {
    if !DEFORMS || all(body.moved == vec2f(0.0)) { return vec3f(0.0); }
    let grid = body.grid;
    let last = vec3f(grid.counts - 1u);
    let place = clamp((rotate(conjugate(body.rotation), x) - grid.origin) / grid.spacing, vec3f(0.0), last);
    let cell = min(floor(place), last - 1.0);
    let part = place - cell;
    let nodes = grid.counts.x * grid.counts.y * grid.counts.z;
    var sum = vec3f(0.0);
    for (var k = 0u; k < 8u; k++) {
        let corner = vec3u(k & 1u, (k >> 1u) & 1u, k >> 2u);
        let seat = vec3u(cell) + corner;
        let weights = select(1.0 - part, part, corner == vec3u(1u));
        let i = nodes + 3u * ((seat.z * grid.counts.y + seat.y) * grid.counts.x + seat.x);
        sum += weights.x * weights.y * weights.z
            * (body.moved.x * move_at(grid.first + i) + body.moved.y * move_at(body.next + i));
    }
    return rotate(body.rotation, sum);
}

fn move_at(i: u32) -> vec3f {
    return vec3f(distances[i], distances[i + 1u], distances[i + 2u]);
}

// How far the body's own point that is at `x` after the step has moved in it [m].
fn surface_move(body: Placed, x: vec3f) -> vec3f {
    let arm = x - body.center;
    return (body.center - body.center_before) + (arm - rotate(conjugate(body.turn), arm)) + deformed(body, arm);
}

// The change, in a step, of a place that the body carries along, seen from its center: `gap` is where it is before.
fn swing(body: Placed, gap: vec3f) -> vec3f {
    let turned = turned_by(body.turn, gap);
    return turned + deformed(body, gap + turned);
}

// Where a step carries the body's own point that is at `x` before it.
fn carried_on(body: Placed, x: vec3f) -> vec3f {
    let gap = x - body.center_before;
    return body.center + (gap + swing(body, gap));
}

// Largest gradient of the distance: of a trilinear one 1 along each axis.
fn steepest(body: Placed) -> f32 {
    return select(1.0, 1.7320508, is_mesh(body));
}
