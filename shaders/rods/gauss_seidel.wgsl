// Cosserat rods by Gauss-Seidel with compliance (Kugelstadt & Schoemer 2016; Macklin et al. 2016 for the compliance).
//
//   joint k:    C = Im(conj(q_(k-1)) q_k) - s Im(rest),  dC = A (theta_k - theta_(k-1)),  A = 1/2 (p_w - [p_v]x) R_(k-1)^T
//   segment k:  C = (x_(k+1) - x_k)/l - d3(q_k),         dC = (dx_(k+1) - dx_k)/l + [d3]x theta_k
//   (J W J^T + a) dlambda = -C - a lambda,  a = alpha (1 + c dt)/dt^2,  in the material frame
//
// One invocation per strand, root to tip. A dispatch takes `rod_sweeps` sweeps; multipliers start at 0 (`turn`) and persist
// over all sweeps of a step, so that it does not matter how these are cut into dispatches.
// J W J^T of a segment is diagonal in its own frame; of a joint it is w/4 (I - p_v p_v^T) for a unit p.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, status::frozen,
    quaternion::{product, conjugate, rotate, tangent, turned},
    rod::{Strand, Segment, Multipliers}, matter::inverse_mass,
};

@group(0) @binding(3) var<storage, read>       strands:               array<Strand>;
@group(0) @binding(4) var<storage, read>       segments:              array<Segment>;
@group(0) @binding(5) var<storage, read_write> predicted:             array<vec4f>;
@group(0) @binding(6) var<storage, read_write> predicted_orientation: array<vec4f>;
@group(0) @binding(7) var<storage, read_write> multipliers:           array<Multipliers>;

// Compliance of a step per compliance: (1 + c dt)/dt^2. Implicit damping divides every force's share of the velocity by
// 1 + c dt; `predict` does it for gravity, this for the rod's own forces.
fn softening() -> f32 {
    return (1.0 + params.damping * params.step) / (params.step * params.step);
}

// x of M x = b, M symmetric positive definite, by the adjugate.
fn solve(m: mat3x3f, b: vec3f) -> vec3f {
    let c0 = cross(m[1], m[2]);
    let c1 = cross(m[2], m[0]);
    let c2 = cross(m[0], m[1]);
    return vec3f(dot(c0, b), dot(c1, b), dot(c2, b)) / dot(m[0], c0);
}

// Bend-twist of the joint before segment k: `before` is the frame it hangs on. Returns dlambda turned into the world.
fn bend_twist(k: u32, before: vec4f, before_inverse_inertia: f32) -> vec3f {
    let segment = segments[k];
    let p = product(conjugate(before), predicted_orientation[k]);
    let same = dot(p, segment.rest_rotation) >= 0.0;
    let constraint = p.xyz - select(-segment.rest_rotation.xyz, segment.rest_rotation.xyz, same);
    let compliance = segment.bend_compliance * softening();
    let w = 0.25 * (before_inverse_inertia + segment.inverse_inertia);
    // Scaled by w, so that the determinant stays in the range of f32.
    let v = p.xyz;
    var m = mat3x3f(-v.x * v, -v.y * v, -v.z * v);
    m[0].x += 1.0 + compliance.x / w;
    m[1].y += 1.0 + compliance.y / w;
    m[2].z += 1.0 + compliance.z / w;
    let lambda = multipliers[k].bend.xyz;
    let change = solve(m, -(constraint + compliance * lambda) / w);
    multipliers[k].bend = vec4f(lambda + change, 0.0);
    // A^T change = 1/2 R_(k-1) (p_w change + p_v x change)
    return 0.5 * rotate(before, p.w * change + cross(v, change));
}

fn stretch_shear(k: u32, point: u32) {
    let segment = segments[k];
    let q = predicted_orientation[k];
    let start = predicted[point];
    let end = predicted[point + 1u];
    let start_mass = inverse_mass[point];
    let end_mass = inverse_mass[point + 1u];
    let constraint = rotate(conjugate(q), (end.xyz - start.xyz) / segment.rest_length) - vec3f(0.0, 0.0, 1.0);
    let compliance = segment.stretch_compliance * softening();
    let along = (start_mass + end_mass) / (segment.rest_length * segment.rest_length);
    let matrix = vec3f(along) + vec3f(segment.inverse_inertia, segment.inverse_inertia, 0.0) + compliance;
    let lambda = multipliers[k].stretch.xyz;
    var change = -(constraint + compliance * lambda) / matrix;
    change = select(vec3f(0.0), change, matrix > vec3f(0.0));
    multipliers[k].stretch = vec4f(lambda + change, 0.0);
    let pull = rotate(q, change);
    predicted[point] = start - vec4f(start_mass / segment.rest_length * pull, 0.0);
    predicted[point + 1u] = end + vec4f(end_mass / segment.rest_length * pull, 0.0);
    predicted_orientation[k] = turned(q, -segment.inverse_inertia * cross(tangent(q), pull));
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let s = invocation(id, groups);
    if s >= params.strands || frozen() { return; }
    let strand = strands[s];
    let last = strand.first_segment + strand.points - 1u;
    for (var sweep = 0u; sweep < params.rod_sweeps; sweep++) {
        for (var k = strand.first_segment; k < last; k++) {
            var before = strand.root_frame;
            var before_inverse_inertia = 0.0;
            if k > strand.first_segment {
                before = predicted_orientation[k - 1u];
                before_inverse_inertia = segments[k - 1u].inverse_inertia;
            }
            let turn = bend_twist(k, before, before_inverse_inertia);
            if k > strand.first_segment {
                predicted_orientation[k - 1u] = turned(before, -before_inverse_inertia * turn);
            }
            predicted_orientation[k] = turned(predicted_orientation[k], segments[k].inverse_inertia * turn);
            stretch_shear(k, strand.first_point + k - strand.first_segment);
        }
    }
}
