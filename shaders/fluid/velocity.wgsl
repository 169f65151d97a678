// Velocity of air: its own, and the density constraint's move over dt; the move is set to 0.
import package::common::{params::params, dispatch::{invocation, WORKGROUP}, status::frozen};

@group(0) @binding(2) var<storage, read_write> correction:   array<vec4f>;
@group(0) @binding(3) var<storage, read_write> new_velocity: array<vec4f>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = params.hair_points + invocation(id, groups);
    if (i >= params.particles) | frozen() { return; }
    new_velocity[i] += vec4f(correction[i].xyz / params.step, 0.0);
    correction[i] = vec4f(0.0);
}
