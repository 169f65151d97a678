// Lift and drag of the mean wind on segments (Wilson et al. 2014), where there is no air to push them: everywhere
// without air particles, else outside the box. Per segment, u the wind relative to it, u_n across it, A = 2 r l n:
//
//   k_n = 1/2 rho A (|u_n| + 10 (2r/nu)^(-2/3) |u_n|^(1/3))   C_d = 1 + 10 Re^(-2/3) (White, Viscous Fluid Flow)
//   k_t = 1/2 rho A 5.4 sqrt(nu |u_n|/(2r))                   laminar skin friction of an oblique cylinder (Taylor 1952)
//   D = k_n (1 - t t^T) + k_t t t^T,  F = 1/2 rho A C_l |u_n| (t x u)
//
// A point takes half of each segment at it, with D and F of the step before: (1 + dt w D) dv = dt w (D (U - v) + F).
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, matter::inverse_mass, rod::{Strand, Segment},
    cells::{cell_of, in_box}, status::frozen, wind::mean_wind,
};

@group(0) @binding(3) var<storage, read>       strands:     array<Strand>;
@group(0) @binding(4) var<storage, read>       segments:    array<Segment>;
@group(0) @binding(5) var<storage, read>       position:    array<vec4f>;
@group(0) @binding(6) var<storage, read>       velocity:    array<vec4f>;
@group(0) @binding(7) var<storage, read_write> drag_change: array<vec4f>;   // m/s, of this step

const FORM: f32 = 10.0;       // of C_d
const FRICTION: f32 = 5.4;
const SLOWEST: f32 = 1e-12;   // m/s: powers of 0 are not portable

struct Load {
    matrix: mat3x3f,   // kg/s
    force: vec3f,      // N
}

fn nothing() -> Load {
    return Load(mat3x3f(), vec3f(0.0));
}

fn load(segment: Segment, a: u32, wind: vec3f) -> Load {
    let b = a + 1u;
    if params.box_cells > 0u && in_box(cell_of(0.5 * (position[a].xyz + position[b].xyz))) { return nothing(); }
    let edge = position[b].xyz - position[a].xyz;
    let l = length(edge);
    if l <= 0.0 { return nothing(); }
    let t = edge / l;
    let u = wind - 0.5 * (velocity[a].xyz + velocity[b].xyz);
    let across = max(length(u - dot(u, t) * t), SLOWEST);
    let width = 2.0 * segment.radius;
    let pressure = 0.5 * params.air_density * width * l * segment.fibres;   // over the square of a speed
    let viscosity = params.kinematic_viscosity;
    let normal = pressure * (across + FORM * pow(viscosity / width, 2.0 / 3.0) * pow(across, 1.0 / 3.0));
    let tangential = pressure * FRICTION * sqrt(viscosity * across / width);
    let along = mat3x3f(t.x * t, t.y * t, t.z * t);
    let one = mat3x3f(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 1.0, 0.0), vec3f(0.0, 0.0, 1.0));
    return Load(
        0.5 * (normal * one + (tangential - normal) * along),
        0.5 * pressure * params.lift * across * cross(t, u),
    );
}

// x of m x = right, m symmetric and positive definite.
fn solve(m: mat3x3f, right: vec3f) -> vec3f {
    let a = cross(m[1], m[2]);
    let b = cross(m[2], m[0]);
    let c = cross(m[0], m[1]);
    return vec3f(dot(a, right), dot(b, right), dot(c, right)) / dot(m[0], a);
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let s = invocation(id, groups);
    if s >= params.strands || frozen() { return; }
    let strand = strands[s];
    let wind = mean_wind();
    var before = nothing();
    for (var k = 0u; k < strand.points; k++) {
        let p = strand.first_point + k;
        var after = nothing();
        if k + 1u < strand.points { after = load(segments[strand.first_segment + k], p, wind); }
        let scale = params.step * inverse_mass[p];
        let drag = before.matrix + after.matrix;
        let one = mat3x3f(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 1.0, 0.0), vec3f(0.0, 0.0, 1.0));
        let push = drag * (wind - velocity[p].xyz) + before.force + after.force;
        drag_change[p] = vec4f(solve(one + scale * drag, scale * push), 0.0);
        before = after;
    }
}
