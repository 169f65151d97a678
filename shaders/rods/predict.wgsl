// Hair points fall freely with what drag gives them, damped: v* = (v + dv + g dt)/(1 + c dt). A move that a rod could not follow is capped and counted.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, matter::inverse_mass,
    status::{frozen, count, MOVE_CAPPED},
};

@group(0) @binding(3) var<storage, read>       position:      array<vec4f>;   // xyz [m], w: volume [m^3]
@group(0) @binding(4) var<storage, read>       velocity:      array<vec4f>;
@group(0) @binding(5) var<storage, read>       rest_position: array<vec4f>;   // w: largest move in a step [m]
@group(0) @binding(6) var<storage, read>       drag_change:   array<vec4f>;   // m/s, 0 where the air is particles
@group(0) @binding(7) var<storage, read_write> predicted:     array<vec4f>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let p = invocation(id, groups);
    if p >= params.hair_points || frozen() { return; }
    var shift = vec3f(0.0);
    if inverse_mass[p] > 0.0 {
        let v = (velocity[p].xyz + drag_change[p].xyz + params.step * params.gravity) / (1.0 + params.damping * params.step);
        shift = params.step * v;
        let far = length(shift);
        if far > rest_position[p].w {
            shift *= rest_position[p].w / far;
            count(MOVE_CAPPED);
        }
    }
    predicted[p] = position[p] + vec4f(shift, 0.0);
}
