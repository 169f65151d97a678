// Cosserat rods by Gauss-Seidel with compliance (Kugelstadt & Schoemer 2016; Macklin et al. 2016 for the compliance).
//
//   joint k:    C = Im(conj(q_(k-1)) q_k) - s Im(rest),  dC = A (theta_k - theta_(k-1)),
//       A = 1/2 (p_w - [p_v]x) R_(k-1)^T
//   segment k:  C = (x_(k+1) - x_k)/l - d3(q_k),         dC = (dx_(k+1) - dx_k)/l + [d3]x theta_k
//   (J W J^T + a) dlambda = -C - a lambda,  a = alpha (1 + c dt)/dt^2,  in the material frame
//
// One invocation per strand, root to tip. A dispatch takes `rod_sweeps` sweeps; multipliers start at 0 (`rods/predict`)
// and persist over all sweeps of a step, so that it does not matter how these are cut into dispatches. a =
// alpha/response: forces times the square of the step. J W J^T of a segment is diagonal in its own frame; of a joint it
// is w/4 (I - p_v p_v^T) for a unit p.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, status::frozen,
    quaternion::{product, conjugate, rotate, tangent, turned}, integration::response, load::damping_of,
    symmetric::{applied, dyad, inverse_of},
    rod::{Strand, Segment, RodStrand, RodPoint, RodSegment, FREE, ROOT_JOINT},
};

@group(0) @binding(2) var<storage, read>       strands:      array<Strand>;
@group(0) @binding(3) var<storage, read>       segments:     array<Segment>;
@group(0) @binding(4) var<storage, read>       rod_strands:  array<RodStrand>;
@group(0) @binding(5) var<storage, read_write> rod_points:   array<RodPoint>;
@group(0) @binding(6) var<storage, read_write> rod_segments: array<RodSegment>;

// Bend-twist of the joint before segment k: `before` is the frame it hangs on. Returns dlambda turned into the world.
fn bend_twist(k: u32, before: vec4f, before_inverse_inertia: f32) -> vec3f {
    let segment = segments[k];
    let p = product(conjugate(before), rod_segments[k].frame);
    let same = dot(p, segment.rest_rotation) >= 0.0;
    let constraint = p.xyz - select(-segment.rest_rotation.xyz, segment.rest_rotation.xyz, same);
    let compliance = segment.bend_compliance / response(params.damping, rod_segments[k].scheme);
    let w = 0.25 * (before_inverse_inertia + segment.inverse_inertia);
    let v = p.xyz;
    var m = dyad(-w, v);
    m.diagonal += w + compliance;
    let lambda = rod_segments[k].bend;
    let change = -applied(inverse_of(m), constraint + compliance * lambda);
    rod_segments[k].bend = lambda + change;
    // A^T change = 1/2 R_(k-1) (p_w change + p_v x change)
    return 0.5 * rotate(before, p.w * change + cross(v, change));
}

// The inverse mass of a point. Multipliers are forces times the response of frames; a point that more resists moves by
// less.
fn yielding(point: RodPoint) -> f32 {
    if point.resistance == 0.0 { return point.inverse_mass; }
    return point.inverse_mass * (response(damping_of(point), point.scheme) / response(params.damping, point.scheme));
}

fn stretch_shear(k: u32, point: u32) {
    let segment = segments[k];
    let q = rod_segments[k].frame;
    let start = rod_points[point].displacement;
    let end = rod_points[point + 1u].displacement;
    let start_mass = yielding(rod_points[point]);
    let end_mass = yielding(rod_points[point + 1u]);
    let gap = rod_points[point + 1u].start.xyz - rod_points[point].start.xyz;
    let chord = gap + (rod_points[point + 1u].remainder - rod_points[point].remainder) + end - start;
    let constraint = rotate(conjugate(q), chord / segment.rest_length) - vec3f(0.0, 0.0, 1.0);
    let compliance = segment.stretch_compliance / response(params.damping, rod_segments[k].scheme);
    let along = (start_mass + end_mass) / (segment.rest_length * segment.rest_length);
    let matrix = vec3f(along) + vec3f(segment.inverse_inertia, segment.inverse_inertia, 0.0) + compliance;
    let lambda = rod_segments[k].stretch;
    var change = -(constraint + compliance * lambda) / matrix;
    change = select(vec3f(0.0), change, matrix > vec3f(0.0));
    rod_segments[k].stretch = lambda + change;
    let pull = rotate(q, change);
    rod_points[point].displacement = start - start_mass / segment.rest_length * pull;
    rod_points[point + 1u].displacement = end + end_mass / segment.rest_length * pull;
    rod_segments[k].frame = turned(q, -segment.inverse_inertia * cross(tangent(q), pull));
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let s = invocation(id, groups);
    if (s >= params.strands) | frozen() { return; }
    if rod_strands[s].state != FREE { return; }
    let strand = strands[s];
    let first = strand.first_segment;
    let last = first + strand.points - 1u;
    for (var sweep = 0u; sweep < params.rod_sweeps; sweep++) {
        for (var k = first; k < last; k++) {
            if k > first || (strand.joints & ROOT_JOINT) != 0u {
                var before = rod_strands[s].root_frame;
                var before_inverse_inertia = 0.0;
                if k > first {
                    before = rod_segments[k - 1u].frame;
                    before_inverse_inertia = segments[k - 1u].inverse_inertia;
                }
                let turn = bend_twist(k, before, before_inverse_inertia);
                if k > first { rod_segments[k - 1u].frame = turned(before, -before_inverse_inertia * turn); }
                rod_segments[k].frame = turned(rod_segments[k].frame, segments[k].inverse_inertia * turn);
            }
            stretch_shear(k, strand.first_point + k - first);
        }
    }
}
