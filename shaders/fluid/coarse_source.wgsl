// Source of the coarse grid: the divergence of each air particle, in the order of cells, and where the
// particle is. Where air is too dense there are more particles to say so, which is taken out; where air is missing only
// compression counts.
//
// The grid is solved for a box full of air, which sends two thirds of a layer of sources on a sphere outward and one
// half on a cylinder or a plane: 1.5 and 2 times the wall's part would be right if no iterations followed. It counts
// 1.25 times.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, status::frozen, mesh::Mesh, pressure::{Stress, THIN},
    body::BODIES,
    wall::Wall,
};

@group(0) @binding(2) var<uniform>             mesh:            Mesh;
@group(0) @binding(3) var<storage, read>       sorted:          array<u32>;
@group(0) @binding(4) var<storage, read>       sorted_position: array<vec4f>;
@group(0) @binding(5) var<storage, read>       stress:          array<Stress>;
@group(0) @binding(6) var<storage, read>       density:         array<f32>;            // rho / rho_0
// xyz: place in node spacings; w: s/max(1, theta) [1/s]
@group(0) @binding(7) var<storage, read_write> deposit_source:         array<vec4f>;
@group(0) @binding(8) var<storage, read>       wall:            array<Wall>;
@group(0) @binding(9) var<storage, read>       new_velocity:    array<vec4f>;

const WALL: f32 = 1.25;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let e = invocation(id, groups);
    if (e >= params.particles - params.hair_points) | frozen() { return; }
    let i = sorted[e];
    var source = stress[i].divergence;
    if BODIES {
        let beside = wall[i];
        source -= (WALL - 1.0) * beside.weight * (dot(new_velocity[i].xyz, beside.normal) - beside.speed);
    }
    source /= max(1.0, density[i]);
    if density[i] < THIN { source = max(source, 0.0); }
    deposit_source[e] = vec4f(sorted_position[e].xyz / mesh.spacing, source);
}
