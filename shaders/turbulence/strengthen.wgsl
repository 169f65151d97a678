// Gives the air the change of velocity by all bands, less the mean change where momentum is conserved.
import package::common::{params::params, dispatch::{invocation, WORKGROUP}, status::frozen, mean::taken_out};

@group(0) @binding(2) var<storage, read>       confinement:       array<vec4f>;
@group(0) @binding(3) var<storage, read>       confinement_total: array<vec4f>;   // its sum (`reduce/changes`)
@group(0) @binding(4) var<storage, read_write> new_velocity:      array<vec4f>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = params.hair_points + invocation(id, groups);
    if (i >= params.particles) | frozen() { return; }
    new_velocity[i] += confinement[i] - vec4f(taken_out(confinement_total[0].xyz), 0.0);
}
