// Air flows around bodies. A particle that is nearer to a surface than its clearance is moved out by the nearest way and loses its velocity
// toward the surface. The move itself gives no velocity: air that a turning body has left inside would be shot out.
//
// Within a spacing the surface holds air back, by a stress of 1/2 C_f rho |v_t|^2 on a layer of one spacing:
//
//   v_t *= exp(-1/2 C_f |v_t| dt/d)                v_t: along the surface, relative to it
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, cells::wrap, nearest::nearest, wall::{Wall, NEAR, ROUNDS, gap_in}, status::{status, frozen},
};

@group(0) @binding(2) var<storage, read>       correction:   array<vec4f>;   // m; `fluid/velocity` makes velocity of it
@group(0) @binding(3) var<storage, read_write> predicted:    array<vec4f>;
@group(0) @binding(4) var<storage, read_write> new_velocity: array<vec4f>;
@group(0) @binding(5) var<storage, read_write> wall:         array<Wall>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = params.hair_points + invocation(id, groups);
    if (i >= params.particles) | frozen() { return; }
    let at = wrap(predicted[i].xyz);
    var x = at;
    let constrained = i < params.constrained;
    // Solver pbf has no pressure, and its air no wall yet.
    if !constrained && wall[i].distance > NEAR * params.spacing { return; }
    let corrected = select(vec3f(0.0), correction[i].xyz / params.step, constrained);
    var v = new_velocity[i].xyz + corrected;
    var taken = vec3f(0.0);
    var near = nearest(x, false);
    for (var round = 0u; round < ROUNDS; round++) {
        let gap = gap_in(round, near.distance);
        if gap >= 0.0 { break; }
        x -= gap * near.normal;
        near = nearest(x, false);
        let into = min(0.0, dot(near.normal, v - near.velocity));
        v -= into * near.normal;
        taken += into * near.normal;
    }
    if near.distance < params.spacing {
        let slip = v - near.velocity;
        let along = slip - dot(slip, near.normal) * near.normal;
        let held = (1.0 - exp(-0.5 * params.skin_friction * length(along) * params.step / params.spacing)) * along;
        v -= held;
        taken += held;
    }
    predicted[i] += vec4f(x - at, 0.0);
    new_velocity[i] = vec4f(v - corrected, 0.0);
    if near.distance < params.kernel_radius {
        atomicMax(&status.way_beside, bitcast<u32>(length(v - near.velocity) * params.step / params.spacing));
    }
    if constrained { wall[i] = Wall(near.normal, 0.0, vec3f(0.0), near.body, 0.0, near.distance, 0.0); }
    wall[i].taken += taken;
}
