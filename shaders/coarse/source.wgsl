// What the coarse grid is to take out: the divergence of each air particle, in the order of cells. Where air is too dense
// there are more particles to say so, which is taken out; where air is missing only compression counts.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, cells::is_air, status::frozen, pressure::{Stress, THIN},
};

@group(0) @binding(2) var<storage, read>       sorted:  array<u32>;
@group(0) @binding(3) var<storage, read>       stress:  array<Stress>;
@group(0) @binding(4) var<storage, read>       density: array<f32>;     // rho / rho_0
@group(0) @binding(5) var<storage, read_write> flow:    array<vec4f>;   // x: s/max(1, theta) [1/s]

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let e = invocation(id, groups);
    if e >= params.particles || frozen() { return; }
    let i = sorted[e];
    var source = 0.0;
    if is_air(i) { source = stress[i].divergence / max(1.0, density[i]); }
    if density[i] < THIN { source = max(source, 0.0); }
    flow[e] = vec4f(source, 0.0, 0.0, 0.0);
}
