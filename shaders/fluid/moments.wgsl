// Density, and the matrix that makes the kernel's gradients exact for a linear field whatever the disorder of the
// particles (Randles & Libersky 1996):
//
//   theta_i = rho_i/rho_0 = sum_j V_j W,  self included
//   B_i = (0.02 - sum_j V_j grad_i W (x) (x_i - x_j))^-1;  identity where det < LEAST or trace B > LARGEST
//   a_i = w_i |sum_j V_j B_i grad_i W|^2 + sum_j w_j V_j^2 |B_i grad_i W|^2 + alpha        w inverse mass, 1 for air
//
// A body's wall adds its part (`common/wall.wgsl`): Psi to theta, 2 P phi n n^T to the matrix, -k n to the first sum, k
// = 2 P n . B n.
//
// Also writes the stress lambda B/V of the pressure of the step before.
import package::common::{
    params::params, dispatch::WORKGROUP, lanes::Near, sph_kernels::poly6_factor, pairs::Pair,
    clusters::{take_particle, has_none, of_flow, meet_own_kind},
    pressure::{Pressed, Gradients, Stress, allowed, share_of},
    body::BODIES, wall::{Wall, density_beyond},
    symmetric::{Symmetric, adjugate_of, applied, applied_to_columns, determinant, dyad, plus, scaled},
};

const FLOOR: f32 = 0.02;      // added to the matrix before it is inverted
const LEAST: f32 = 0.15;      // determinant below which it is not inverted
const LARGEST: f32 = 6.0;     // trace of B above which it is not taken

@group(0) @binding(3) var<storage, read>       predicted: array<vec4f>;   // xyz [m], w: volume [m^3]
@group(0) @binding(4) var<storage, read>       pressed:   array<Pressed>;
@group(0) @binding(5) var<storage, read_write> density:   array<f32>;     // rho / rho_0
@group(0) @binding(6) var<storage, read_write> gradients: array<Gradients>;
@group(0) @binding(7) var<storage, read_write> stress:    array<Stress>;
@group(0) @binding(8) var<storage, read_write> wall:      array<Wall>;

var<private> theta: f32;
var<private> sum: vec3f;
// Sum over neighbours of weights times gap (x) gap: xx, yy, zz; then yz, zx, xy.
var<private> moment: vec3f;
var<private> moment_off: vec3f;
var<private> square: vec3f;       // sum_j w_j V_j^2 grad W (x) grad W
var<private> square_off: vec3f;

fn load_neighbour(j: u32) -> Near {
    let other = predicted[j];
    return Near(j, other.xyz, other.w, vec4f(share_of(j)), vec4f());
}

fn accumulate(other: Pair) {
    let gap = other.gap;
    let slope = other.volume * other.slope;   // V_j grad_i W is this times the gap
    theta += other.volume * other.kernel;
    sum += slope * gap;
    let diagonal = gap * gap;
    let off_diagonal = gap.yzx * gap.zxy;
    moment -= slope * diagonal;
    moment_off -= slope * off_diagonal;
    let weighed = other.value.x * slope * slope;
    square += weighed * diagonal;
    square_off += weighed * off_diagonal;
}

// The inverse of a matrix, or 1.
fn corrected(m: Symmetric) -> Symmetric {
    let adjugate = adjugate_of(m);
    let size = determinant(m, adjugate);
    let inverse = scaled(1.0 / size, adjugate);
    // A value that is not a number stays one.
    let is_none = (size < LEAST) | (inverse.diagonal.x + inverse.diagonal.y + inverse.diagonal.z > LARGEST);
    return Symmetric(
        select(inverse.diagonal, vec3f(1.0), is_none), select(inverse.off_diagonal, vec3f(0.0), is_none),
    );
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let i = take_particle(of_flow(id, groups), local);
    let own = predicted[i];
    moment = vec3f(FLOOR);
    theta = own.w * poly6_factor();
    meet_own_kind(own.xyz);
    if has_none() { return; }
    var moments = Symmetric(moment, moment_off);
    var seen = Wall();
    if BODIES {
        seen = wall[i];
        theta += density_beyond(seen.distance);
        moments = plus(moments, dyad(2.0 * seen.weight * max(seen.distance, 0.0), seen.normal));
    }
    let b = corrected(moments);
    var turned = applied(b, sum);
    if BODIES {
        let k = 2.0 * seen.weight * dot(seen.normal, applied(b, seen.normal));
        turned -= k * seen.normal;
        wall[i].weight = k;
    }
    // The trace of B times the matrix of squares times B.
    let squares = Symmetric(square, square_off);
    let columns = mat3x3f(
        vec3f(b.diagonal.x, b.off_diagonal.zy), vec3f(b.off_diagonal.z, b.diagonal.y, b.off_diagonal.x),
        vec3f(b.off_diagonal.yx, b.diagonal.z),
    );
    let answers = applied_to_columns(squares, columns);
    let others = dot(columns[0], answers[0]) + dot(columns[1], answers[1]) + dot(columns[2], answers[2]);
    let response = share_of(i) * dot(turned, turned) + others + params.density_softening / params.air_inverse_mass;
    density[i] = theta;
    gradients[i] = Gradients(b.diagonal, response, b.off_diagonal);
    let pressure = allowed(pressed[i].pressure, theta) / own.w;
    stress[i] = Stress(pressure * b.diagonal, 0.0, pressure * b.off_diagonal, pressure);
}
