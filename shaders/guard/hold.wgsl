// A strand that got a velocity that is not finite ends this step at rest, and is reset in the next as one whose solve failed
// (`rods/finish`).
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, rod::{Strand, Health, BAD},
    share::{Stretch, owner_of, worker_of, stretch_of, least_shared},
    status::{frozen, count_bad_strand, finite3, BY_HOLD, NO_POINT},
};

@group(0) @binding(2) var<storage, read>       strands:        array<Strand>;
@group(0) @binding(3) var<storage, read_write> health:         array<Health>;
@group(0) @binding(4) var<storage, read_write> final_velocity: array<vec4f>;

// The first point of a stretch whose velocity is not finite.
fn lost(strand: Strand, own: Stretch) -> u32 {
    for (var k = own.begin; k < own.end; k++) {
        if !finite3(final_velocity[strand.first_point + k].xyz) { return strand.first_point + k; }
    }
    return NO_POINT;
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let at = invocation(id, groups);
    let s = owner_of(at);
    if (s >= params.strands) | frozen() { return; }
    let strand = strands[s];
    let own = stretch_of(strand.points, worker_of(at));
    let point = least_shared(lost(strand, own));
    if point == NO_POINT { return; }
    for (var k = own.begin; k < own.end; k++) {
        final_velocity[strand.first_point + k] = vec4f(0.0);
    }
    if (worker_of(at) > 0u) | (health[s].found.bad != 0u) { return; }
    health[s].found.bad = BAD;
    count_bad_strand(point, BY_HOLD);
}
