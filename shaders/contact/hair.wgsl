// Hair points stay out of bodies, with Coulomb friction (Macklin et al. 2014, Unified particle physics, eq. 24).
//
//   The way of a point in this step, seen from the body, ends at the plane that touches the body where the way enters it:
//   however far the point goes, it does not come out behind a thin body. The part of the way along the plane is shortened
//   by up to mu times the depth that the point would have had behind the plane.
//
//            start          A point that starts inside is pushed out by no more than RECOVERY allows in a step: it comes
//               \           out slowly, not at the speed of its whole depth in one step.
//   ------.------*--- plane
//       /   body  \\ depth
//
// The pass goes through all bodies in order, twice, for points between two bodies.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, matter::inverse_mass, owner::{strands, strand_of},
    body::{Placed, PUSHED, ROUNDS, surface, carried, entry}, status::frozen,
};

@group(0) @binding(3) var<storage, read>       position:  array<vec4f>;
@group(0) @binding(5) var<storage, read>       placed:    array<Placed>;
@group(0) @binding(6) var<storage, read_write> predicted: array<vec4f>;
@group(0) @binding(7) var<storage, read_write> touched:   array<atomic<u32>>;   // bits of each strand: PUSHED, MOVED

const TOUCH: f32 = 1e-6;      // push that counts as a touch [lengths of the strand]; hair at rest on a body is off by rounding
const RECOVERY: f32 = 0.2;   // speed at which a point that starts inside comes out [m/s]: slow enough not to throw the strand

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
