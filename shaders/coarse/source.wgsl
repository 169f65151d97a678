// What the coarse grid is to take out: the divergence of each air particle, in the order of cells, and where the particle is. Where
// air is too dense there are more particles to say so, which is taken out; where air is missing only compression counts.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, status::frozen, mesh::Mesh, pressure::{Stress, THIN},
};

@group(0) @binding(2) var<uniform>             mesh:            Mesh;
@group(0) @binding(3) var<storage, read>       sorted:          array<u32>;
@group(0) @binding(4) var<storage, read>       sorted_position: array<vec4f>;
@group(0) @binding(5) var<storage, read>       stress:          array<Stress>;
@group(0) @binding(6) var<storage, read>       density:         array<f32>;     // rho / rho_0
@group(0) @binding(7) var<storage, read_write> brought:         array<vec4f>;   // xyz: place in node spacings; w: s/max(1, theta) [1/s]

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let e = invocation(id, groups);
    if (e >= params.particles - params.hair_points) | frozen() { return; }
    let i = sorted[e];
    var source = stress[i].divergence / max(1.0, density[i]);
    if density[i] < THIN { source = max(source, 0.0); }
    brought[e] = vec4f(sorted_position[e].xyz / mesh.spacing, source);
}
