// Roots go with the triangles that they are bound to: where a clamp is to be at the step's end, before the motion of
// its body. Triangles go from pose to pose, evenly between two.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, quaternion::{product, frame_of}, motion::{phase_after, shape_in},
    rod::{Strand, Root}, bond::{Bond, Corners}, status::{status, frozen},
};

@group(0) @binding(2) var<storage, read>       strands:      array<Strand>;
@group(0) @binding(3) var<storage, read>       bonds:        array<Bond>;
// of each strand in every other pose, then in those between
@group(0) @binding(4) var<storage, read>       bond_corners: array<Corners>;
@group(0) @binding(5) var<storage, read_write> root_targets: array<Root>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let s = invocation(id, groups);
    if (s >= params.strands) | frozen() { return; }
    let bond = bonds[s];
    if bond.bound == 0u { return; }
    let strand = strands[s];
    let phase = phase_after(status.step + 1u, strand.first_keyframe, strand.keyframes);
    let shape = shape_in(phase, strand.first_keyframe, strand.keyframes);
    let half = shape.index & 1u;
    let before = bond_corners[half * params.strands + s];
    let after = bond_corners[(1u - half) * params.strands + s];
    let a = mix(before.a, after.a, shape.part);
    let first = mix(before.b, after.b, shape.part) - a;
    let second = mix(before.c, after.c, shape.part) - a;
    let across = cross(first, second);
    if all(across == vec3f(0.0)) { return; }   // a triangle without an area has no frame
    let along = normalize(first);
    let normal = normalize(across);
    let frame = frame_of(mat3x3f(along, cross(normal, along), normal));
    root_targets[s].position = strand.center + a + bond.place.x * first + bond.place.y * second + bond.place.z * normal;
    root_targets[s].frame = normalize(product(frame, bond.frame));
}
