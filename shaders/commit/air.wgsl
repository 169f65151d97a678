// Commits air in the order of cells, so that its order in memory follows the box: positions, velocities, and the stable
// id in each slot.
import package::common::{params::params, dispatch::{invocation, WORKGROUP}, cells::wrap, status::frozen};

@group(0) @binding(2) var<storage, read>       sorted:         array<u32>;
@group(0) @binding(3) var<storage, read>       air_id_before:  array<u32>;
@group(0) @binding(4) var<storage, read>       predicted:      array<vec4f>;
@group(0) @binding(5) var<storage, read>       final_velocity: array<vec4f>;
@group(0) @binding(6) var<storage, read_write> position:       array<vec4f>;
@group(0) @binding(7) var<storage, read_write> velocity:       array<vec4f>;
@group(0) @binding(8) var<storage, read_write> air_id:         array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let slot = invocation(id, groups);
    if (slot >= params.particles - params.hair_points) | frozen() { return; }
    let i = sorted[slot];
    let x = predicted[i];
    position[params.hair_points + slot] = vec4f(wrap(x.xyz), x.w);
    velocity[params.hair_points + slot] = final_velocity[i];
    air_id[slot] = air_id_before[i - params.hair_points];
}
