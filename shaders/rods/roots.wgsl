// Where the clamps go in this step: a part of the way to their targets, all of it in the last substep. A root that jumps
// farther than its strand is long is teleported. A strand whose clamp does not move may sleep.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, quaternion::{product, conjugate, rotation, rotation_vector},
    rod::{Strand, RodStrand, Root, FREE, TELEPORTED, ASLEEP}, status::{status, frozen},
};

@group(0) @binding(2) var<storage, read>       strands:      array<Strand>;
@group(0) @binding(3) var<storage, read>       root_targets: array<Root>;
@group(0) @binding(4) var<storage, read>       clamps:       array<Root>;   // as they stand
@group(0) @binding(5) var<storage, read_write> rod_strands:  array<RodStrand>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let s = invocation(id, groups);
    if s >= params.strands || frozen() { return; }
    let held = clamps[s];
    let goal = root_targets[s];
    let way = goal.position - held.position;
    let turn = rotation_vector(product(goal.frame, conjugate(held.frame)));
    let jumps = length(way) > strands[s].length;
    let left = params.substeps - status.step % params.substeps;   // substeps of this time step
    let part = select(1.0 / f32(left), 1.0, jumps);
    let still = all(way == vec3f(0.0)) && all(held.frame == goal.frame);
    var rod: RodStrand;
    rod.root_travel = part * way;
    rod.root_turn = select(rotation(part * turn), vec4f(0.0, 0.0, 0.0, 1.0), still);
    rod.root_frame = select(normalize(product(rod.root_turn, held.frame)), held.frame, still);
    rod.state = select(select(FREE, ASLEEP, still && params.sleep != 0u), TELEPORTED, jumps);
    rod_strands[s] = rod;
}
