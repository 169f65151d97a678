// Air flows around bodies. A particle that is nearer to a surface than its parcel allows, which is half a spacing, is
// moved out by the nearest way and loses its velocity toward the surface; along the surface air slips freely.
//
// The move itself gives no velocity: air that a density correction or a turning body has left inside would be shot out.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, body::{Placed, ROUNDS, surface, surface_move}, status::frozen,
};

@group(0) @binding(2) var<storage, read>       placed:       array<Placed>;
@group(0) @binding(3) var<storage, read>       correction:   array<vec4f>;   // m; `fluid/velocity` makes velocity of it
@group(0) @binding(4) var<storage, read_write> predicted:    array<vec4f>;
@group(0) @binding(5) var<storage, read_write> new_velocity: array<vec4f>;

const CLEARANCE: f32 = 0.5;   // least distance of a particle from a surface, its parcel's half width [particle spacings]

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = params.hair_points + invocation(id, groups);
    if (i >= params.particles) | frozen() { return; }
    var x = predicted[i].xyz;
    let corrected = select(vec3f(0.0), correction[i].xyz / params.step, i < params.constrained);
    var v = new_velocity[i].xyz + corrected;
    let clearance = CLEARANCE * params.spacing;
    let bodies = arrayLength(&placed);
    for (var k = 0u; k < ROUNDS * bodies; k++) {
        let body = placed[k % bodies];
        let near = surface(body, x);
        let gap = near.distance - clearance;
        if gap >= 0.0 { continue; }
        x -= gap * near.normal;
        let into = dot(near.normal, v - surface_move(body, x) / params.step);
        v -= min(into, 0.0) * near.normal;
    }
    predicted[i] = vec4f(x, predicted[i].w);
    new_velocity[i] = vec4f(v - corrected, 0.0);
}
