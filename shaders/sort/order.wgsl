// Orders the entries of each cell by particle index, so that sums over neighbours have the same bits every time. A
// particle's place is the number of smaller indices in its cell.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, cells::{bucket_of, is_air, wrap}, status::frozen,
};

@group(0) @binding(2) var<storage, read>       predicted:       array<vec4f>;
@group(0) @binding(3) var<storage, read>       cell_start:      array<u32>;
@group(0) @binding(4) var<storage, read>       scattered:       array<u32>;
@group(0) @binding(5) var<storage, read_write> sorted:          array<u32>;
// xyz: position [m]; w: 1 for air, 0 for hair
@group(0) @binding(6) var<storage, read_write> sorted_position: array<vec4f>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let entry = invocation(id, groups);
    if (entry >= params.particles - params.first_sorted) | frozen() { return; }
    let i = scattered[entry];
    let position = predicted[i].xyz;
    let bucket = bucket_of(i, position);
    let begin = cell_start[bucket];
    var place = begin;
    for (var e = begin; e < cell_start[bucket + 1u]; e++) {
        place += u32(scattered[e] < i);
    }
    sorted[place] = i;
    let air = is_air(i);
    sorted_position[place] = vec4f(select(position, wrap(position), air), f32(air));
}
