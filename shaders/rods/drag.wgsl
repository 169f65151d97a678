// Lift and drag of the air on hair points, as a force and a resistance that the rods take implicitly. Per segment, u
// the air relative to it, u_n across it, t along it, A = 2 r l n:
//
//   k_n = 1/2 rho A (|u_n| + 10 (2r/nu)^(-2/3) |u_n|^(1/3))   C_d = 1 + 10 Re^(-2/3) (White, Viscous Fluid Flow)
//   k_t = 1/2 rho A 5.4 sqrt(nu |u_n|/(2r))
//       laminar skin friction of an oblique cylinder (Taylor 1952)
//   D = k_n (1 - t t^T) + k_t t t^T,  F = 1/2 rho A C_l |u_n| (t x u)
//
// A point takes half of each segment at it; D_n is the larger eigenvalue of D:
//
//   force = D (u - v) + D_n v + F,  resistance = D_n
//       both times min(1, 1/(dt G D_n)), where air and hair near the point would have one velocity after the step
//
// BDF2 takes them at extrapolated places x + dt (3/2 v_n - 1/2 v_(n-1)), and with 2 v_n - v_(n-1); Euler at x and v_n.
// The drag that BDF2 extrapolates grows into a flutter from dt w D_n = 0.39 on: such a strand takes Euler.
//
// The drag's direction is that of the segment as the step begins. Where the air passes by more than some lengths of the
// strand in a step, that would throw segments to and fro: there k_t goes to k_n.
//
// Air that was sampled has been slowed by the fibre itself, as by a porous strip (Taylor 1944): from s |u_n| to |u_n|,
// with s = 1 + k_n/(2 rho b l n |u_n|). So k_n is s k_n(s |u_n|) there.
import package::common::{
    params::{params, PARTICLES}, dispatch::{invocation, WORKGROUP}, rod::{Strand, Segment, RodStrand, RodPoint},
    integration::{EULER, BDF2}, cells::{cell_of, in_box}, air::{Sampled, THIN}, wind::mean_wind,
    share::{Range, item_of, lane_of_item, range_of, largest_shared}, status::{frozen, count_many, EXCHANGE_LIMITED},
};

@group(0) @binding(2) var<storage, read>       strands:     array<Strand>;
@group(0) @binding(3) var<storage, read>       segments:    array<Segment>;
@group(0) @binding(4) var<storage, read>       sampled:     array<Sampled>;
@group(0) @binding(5) var<storage, read_write> rod_points:  array<RodPoint>;
@group(0) @binding(6) var<storage, read_write> rod_strands: array<RodStrand>;

const FORM: f32 = 10.0;       // of C_d
const FRICTION: f32 = 5.4;
const SLOWEST: f32 = 1e-12;      // m/s: powers of 0 are not portable
const WAKE: f32 = 1.3;           // kernel radii: b, fitted to fixed strands of 10 to 1000 fibres
// most that a fibre is taken to have slowed the air at it: below 1 cm/s there is no wake
const OWN_WAKE: f32 = 1.1;
const STORMY: f32 = 1.0 / 3.0;   // dt w D_n
const LENGTHS: f32 = 8.0;        // of the strand, that the air passes by in a step: beyond, its drag has no direction

// Drag of a segment, half of it on each of its points: D = across (1 - t t^T) + along t t^T.
struct Load {
    tangent: vec3f,    // t
    across: f32,       // kg/s
    along: f32,        // kg/s
    force: vec3f,      // N, F
}

// A point where the drag is taken.
struct Ahead {
    position: vec3f,
    velocity: vec3f,
}

fn nothing() -> Load {
    return Load(vec3f(0.0), 0.0, 0.0, vec3f(0.0));
}

// D_n.
fn largest_of(load: Load) -> f32 {
    return max(load.across, load.along);
}

// D v.
fn drag_on(load: Load, v: vec3f) -> vec3f {
    return load.across * v + (load.along - load.across) * dot(load.tangent, v) * load.tangent;
}

fn ahead(p: u32, scheme: u32) -> Ahead {
    let point = rod_points[p];
    let x = point.start.xyz;
    if scheme != BDF2 { return Ahead(x, point.velocity); }
    return Ahead(x + params.step * (1.5 * point.velocity - 0.5 * point.before), 2.0 * point.velocity - point.before);
}

fn air_at(p: u32) -> Sampled {
    if params.sampled != 0u { return sampled[p]; }
    return Sampled(vec3f(0.0), 0.0, mean_wind(), 0.0);
}

fn load(segment: Segment, strand_length: f32, a: Ahead, b: Ahead, air_a: Sampled, air_b: Sampled) -> Load {
    if params.model == PARTICLES && in_box(cell_of(0.5 * (a.position + b.position))) { return nothing(); }
    let edge = b.position - a.position;
    let l = length(edge);
    if l <= 0.0 { return nothing(); }
    let t = edge / l;
    let u = 0.5 * (air_a.wind + air_b.wind) - 0.5 * (a.velocity + b.velocity);
    let speed = max(length(u - dot(u, t) * t), SLOWEST);
    let width = 2.0 * segment.radius;
    let viscosity = params.kinematic_viscosity;
    let form = FORM * pow(viscosity / width, 2.0 / 3.0);
    let filled = 0.5 * (min(air_a.filled, THIN) + min(air_b.filled, THIN)) / THIN;
    let wake = filled * 0.25 * width * (1.0 + form * pow(speed, -2.0 / 3.0)) / (WAKE * params.kernel_radius);
    let slowed = min(1.0 + wake, OWN_WAKE);
    let pressure = 0.5 * params.air_density * width * l * segment.fibres;   // over the square of a speed
    let free = slowed * speed;
    let normal = pressure * slowed * (free + form * pow(free, 1.0 / 3.0));
    let skin = pressure * FRICTION * sqrt(viscosity * speed / width);
    let tangential = mix(normal, skin, min(1.0, LENGTHS * strand_length / (params.step * max(length(u), SLOWEST))));
    return Load(t, 0.5 * normal, 0.5 * tangential, 0.5 * pressure * params.lift * speed * cross(t, u));
}

// The loads of a range, added to the forces on its points where `write`; returns the largest dt w R.
fn drag(strand: Strand, own: Range, scheme: u32, write: bool) -> f32 {
    var worst = 0.0;
    var limited = 0u;
    var before = nothing();
    var here: Ahead;
    var air: Sampled;
    // A point is due when the segment behind it is known, which needs the next point.
    for (var next = own.before; next <= own.end; next++) {
        let ahead_of = strand.first_point + min(next, strand.points - 1u);
        let there = ahead(ahead_of, scheme);
        let air_there = air_at(ahead_of);
        var after = nothing();
        if (next > own.before) & (next < strand.points) {
            after = load(segments[strand.first_segment + next - 1u], strand.length, here, there, air, air_there);
        }
        if next > own.begin {
            let p = strand.first_point + next - 1u;
            let largest = largest_of(before) + largest_of(after);
            let part = params.step * air.give * largest;
            let left = 1.0 / max(part, 1.0);
            worst = max(worst, params.step * rod_points[p].inverse_mass * left * largest);
            if write {
                limited += u32(part > 1.0);
                let wind = air.wind - here.velocity;
                let force = drag_on(before, wind) + drag_on(after, wind) + largest * here.velocity + before.force
                    + after.force;
                rod_points[p].force += left * force;
                rod_points[p].resistance += left * largest;
            }
        }
        before = after;
        here = there;
        air = air_there;
    }
    count_many(EXCHANGE_LIMITED, limited);
    return worst;
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let at = invocation(id, groups);
    let s = item_of(at);
    if (s >= params.strands) | frozen() { return; }
    let strand = strands[s];
    let own = range_of(strand.points, lane_of_item(at));
    var scheme = rod_strands[s].scheme;
    // Once, or with BDF2 twice: first it looks, then it writes. The call stands here once, as drivers inline it.
    var looks = scheme == BDF2;
    loop {
        let worst = largest_shared(drag(strand, own, scheme, !looks));
        if !looks { break; }
        looks = false;
        if worst > STORMY {
            scheme = EULER;
            if lane_of_item(at) == 0u { rod_strands[s].scheme = EULER; }
        }
    }
}
