// Velocities from positions. Air: its own plus what the density constraint moved it by; hair: the whole move.
import package::common::{params::params, dispatch::{invocation, WORKGROUP}, cells::is_air, status::frozen};

@group(0) @binding(2) var<storage, read>       position:     array<vec4f>;
@group(0) @binding(3) var<storage, read>       predicted:    array<vec4f>;
@group(0) @binding(4) var<storage, read>       correction:   array<vec4f>;
@group(0) @binding(5) var<storage, read_write> new_velocity: array<vec4f>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = invocation(id, groups);
    if i >= params.particles || frozen() { return; }
    if is_air(i) {
        new_velocity[i] += vec4f(correction[i].xyz / params.step, 0.0);
    } else {
        new_velocity[i] = vec4f((predicted[i].xyz - position[i].xyz) / params.step, 0.0);
    }
}
