// Air flows around bodies. A particle that is nearer to a surface than its clearance is moved out by the nearest way
// and loses its velocity toward the surface. The move adds no velocity: otherwise a turning body would shoot out air
// that it sweeps over.
//
// Within a spacing the surface holds air back, by a stress of 1/2 C_f rho |v_t|^2 on a layer of one spacing:
//
//   v_t *= exp(-1/2 C_f |v_t| dt/d)                v_t: along the surface, relative to it
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, clearance::{cleared, wall_of}, wall::{Wall, NEAR},
    status::{status, frozen},
};

@group(0) @binding(2) var<storage, read_write> predicted:    array<vec4f>;
@group(0) @binding(3) var<storage, read_write> new_velocity: array<vec4f>;
@group(0) @binding(4) var<storage, read_write> wall:         array<Wall>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = params.hair_points + invocation(id, groups);
    if (i >= params.particles) | frozen() { return; }
    let constrained = i < params.constrained;
    // Solver pbf has no pressure, and its air no wall yet.
    if !constrained && wall[i].distance > NEAR * params.spacing { return; }
    let found = cleared(predicted[i].xyz, true);
    let near = found.near;
    var slip = new_velocity[i].xyz - near.velocity;
    let before = slip;
    if found.moved { slip -= min(0.0, dot(near.normal, slip)) * near.normal; }
    if near.distance < params.spacing {
        let along = slip - dot(slip, near.normal) * near.normal;
        slip -= (1.0 - exp(-0.5 * params.skin_friction * length(along) * params.step / params.spacing)) * along;
    }
    predicted[i] = vec4f(found.x, predicted[i].w);
    new_velocity[i] += vec4f(slip - before, 0.0);
    if near.distance < params.kernel_radius {
        atomicMax(&status.path_beside, bitcast<u32>(length(slip) * params.step / params.spacing));
    }
    if constrained { wall[i] = wall_of(near, 0.0); }
    wall[i].impulse += before - slip;
}
