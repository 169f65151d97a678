// Hair points stay out of bodies, with Coulomb friction (Macklin et al. 2014, Unified particle physics, eq. 24).
//
//   A point's way in this step, seen from the body, ends at the plane that touches the body where the way enters it:
//   however far it goes, it does not come out behind a thin body. What is left along the plane loses up to
//   mu times the depth that it would have had.
//
//            start          Where it starts inside, the plane is no deeper than it is itself: what starts in a body comes
//               \           out slowly, not at the speed of its depth in a step.
//   ------.------*--- plane
//       /   body  \\ depth
//
// Bodies in order, twice, for points between them.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, matter::inverse_mass, rod::Strand,
    body::{Placed, PUSHED, surface, carried, entry}, status::frozen,
};

@group(0) @binding(3) var<storage, read>       position:  array<vec4f>;
@group(0) @binding(4) var<storage, read>       strands:   array<Strand>;
@group(0) @binding(5) var<storage, read>       placed:    array<Placed>;
@group(0) @binding(6) var<storage, read_write> predicted: array<vec4f>;
@group(0) @binding(7) var<storage, read_write> touched:   array<atomic<u32>>;   // per strand

const ROUNDS: u32 = 2u;
const TOUCH: f32 = 1e-6;      // lengths of the strand; what lies on a body is off by rounding
const RECOVERY: f32 = 0.2;   // m/s, of what starts inside

// The strand that a point is of: the last that starts at or before it.
fn strand_of(point: u32) -> u32 {
    var low = 0u;
    var high = params.strands;
    while high - low > 1u {
        let middle = (low + high) / 2u;
        if strands[middle].first_point <= point { low = middle; } else { high = middle; }
    }
    return low;
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let p = invocation(id, groups);
    if p >= params.hair_points || frozen() { return; }
    if inverse_mass[p] == 0.0 { return; }
    var x = predicted[p].xyz;
    let bodies = arrayLength(&placed);
    for (var k = 0u; k < ROUNDS * bodies; k++) {
        let body = placed[k % bodies];
        let start = carried(body, position[p].xyz);
        let part = entry(body, start, x - start);
        if part > 1.0 { continue; }
        let contact = start + part * (x - start);
        let touch = surface(body, contact);
        let depth = min(-touch.distance, RECOVERY * params.step) - dot(touch.normal, x - contact);
        if depth <= 0.0 { continue; }
        x += depth * touch.normal;
        let way = x - start;
        let slide = way - dot(way, touch.normal) * touch.normal;
        let far = length(slide);
        if far > 0.0 { x -= min(body.friction * depth / far, 1.0) * slide; }
    }
    let moved = x - predicted[p].xyz;
    if all(moved == vec3f(0.0)) { return; }
    predicted[p] = vec4f(x, predicted[p].w);
    let s = strand_of(p);
    if length(moved) > TOUCH * strands[s].length { atomicOr(&touched[s], PUSHED); }
}
