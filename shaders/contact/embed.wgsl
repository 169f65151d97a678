// How many points of each strand, from its root on, bodies let be: a strand that is rooted in a body has to rise to the surface first.
//
// From a root that is held at a depth d below a surface, a strand rises by RISE of its length. The points that are nearer to the root than
// d/RISE along the strand are *embedded*: if bodies pushed them out, they would push against the clamp in every step.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, rod::{Strand, Segment, ROOT_HELD},
    body::{Placed, EMBEDDED, surface}, status::frozen,
};

@group(0) @binding(2) var<storage, read>       strands:   array<Strand>;
@group(0) @binding(3) var<storage, read>       segments:  array<Segment>;
@group(0) @binding(4) var<storage, read>       predicted: array<vec4f>;
@group(0) @binding(5) var<storage, read>       placed:    array<Placed>;
@group(0) @binding(6) var<storage, read_write> touched:   array<u32>;   // of each strand, from bit EMBEDDED on

const RISE: f32 = 0.5;   // way to the surface [lengths of the strand]: the sine of 30 degrees

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let s = invocation(id, groups);
    if (s >= params.strands) | frozen() { return; }
    let strand = strands[s];
    if (strand.joints & ROOT_HELD) == 0u { return; }
    var depth = 0.0;
    for (var k = 0u; k < arrayLength(&placed); k++) {
        depth = max(depth, -surface(placed[k], predicted[strand.first_point].xyz).distance);
    }
    var embedded = 0u;
    var along = 0.0;
    while embedded < strand.points && RISE * along < depth {
        along += segments[strand.first_segment + min(embedded, strand.points - 2u)].rest_length;
        embedded++;
    }
    touched[s] |= embedded << EMBEDDED;
}
