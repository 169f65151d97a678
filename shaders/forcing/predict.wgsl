// Air moves with its velocity and the wind's change; it leaves the box through one face and enters through the other.
import package::common::{params::params, dispatch::{invocation, WORKGROUP}, cells::wrap, status::frozen};

@group(0) @binding(2) var<storage, read>       position:     array<vec4f>;   // xyz [m], w: volume [m^3]
@group(0) @binding(3) var<storage, read>       velocity:     array<vec4f>;   // m/s
@group(0) @binding(4) var<storage, read>       wind_change:  array<vec4f>;   // m/s
@group(0) @binding(5) var<storage, read_write> predicted:    array<vec4f>;
@group(0) @binding(6) var<storage, read_write> new_velocity: array<vec4f>;
// m, move by the density constraint
@group(0) @binding(7) var<storage, read_write> correction:   array<vec4f>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = params.hair_points + invocation(id, groups);
    if (i >= params.particles) | frozen() { return; }
    let v = velocity[i].xyz + wind_change[i].xyz;
    new_velocity[i] = vec4f(v, 0.0);
    predicted[i] = vec4f(wrap(position[i].xyz + params.step * v), position[i].w);
    correction[i] = vec4f(0.0);
}
