// A strand that became non-finite in the step before goes back to its rest pose at the root, at rest.
//
// The one pass that writes committed state before the last. It looks at nothing else than committed state, so it does the
// same in every step behind a frozen one and in every replay.
import package::common::{params::params, dispatch::{invocation, WORKGROUP}, rod::{Strand, Health, BAD}};

@group(0) @binding(2) var<storage, read>       strands:          array<Strand>;
@group(0) @binding(3) var<storage, read>       health:           array<Health>;
@group(0) @binding(4) var<storage, read>       rest_position:    array<vec4f>;
@group(0) @binding(5) var<storage, read>       rest_orientation: array<vec4f>;
@group(0) @binding(6) var<storage, read_write> position:         array<vec4f>;
@group(0) @binding(7) var<storage, read_write> velocity:         array<vec4f>;
@group(0) @binding(8) var<storage, read_write> orientation:      array<vec4f>;
@group(0) @binding(9) var<storage, read_write> angular_velocity: array<vec4f>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let s = invocation(id, groups);
    if s >= params.strands { return; }
    if (health[s].committed & BAD) == 0u { return; }
    let strand = strands[s];
    for (var k = 0u; k < strand.points; k++) {
        let p = strand.first_point + k;
        position[p] = vec4f(rest_position[p].xyz, position[p].w);
        velocity[p] = vec4f(0.0);
    }
    for (var k = strand.first_segment; k < strand.first_segment + strand.points - 1u; k++) {
        orientation[k] = rest_orientation[k];
        angular_velocity[k] = vec4f(0.0);
    }
}
