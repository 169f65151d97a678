// Deposits the terms of the filter's sum on the nodes of its grid, D, and the volume with them. Particles are sorted
// into the cells between the nodes.
import package::common::{
    dispatch::{invocation, WORKGROUP}, status::frozen, mesh::node_index,
    deposit::{mesh, block_of, deposit, Part, BLOCK},
    share::{SHARE, item_of, lane_of_item}, smoothing::next4,
};

@group(0) @binding(4) var<storage, read>       sorted_position: array<vec4f>;
// xyz: V (v - U) [m^4/s]; w: V [m^3], from `turbulence/weigh`
@group(0) @binding(5) var<storage, read>       flow:            array<vec4f>;
@group(0) @binding(6) var<storage, read_write> deposited:       array<vec4f>;   // D: xyz [m^4/s]; w [m^3]

// Sums for the row of four nodes along x at one of two y and two z: a column per component, a row per node.
var<private> sum_00: mat4x4f;
var<private> sum_10: mat4x4f;
var<private> sum_01: mat4x4f;
var<private> sum_11: mat4x4f;
var<private> carried: vec4f;
var<private> per_spacing: vec3f;

fn bring(e: u32) -> vec3f {
    carried = flow[e];
    return per_spacing * sorted_position[e].xyz;
}

// Weights of four nodes along x; of two along y and two along z.
fn add(along: vec4f, across: vec4f) {
    let part = mat4x4f(carried.x * along, carried.y * along, carried.z * along, carried.w * along);
    sum_00 += across.x * across.z * part;
    sum_10 += across.y * across.z * part;
    sum_01 += across.x * across.w * part;
    sum_11 += across.y * across.w * part;
}

// Adds up the sums of the eight lanes that share a block. Each lane gives away half of its sums three times, and keeps
// those of two nodes, which the bits of its number name: the half of a row, y, z.
@if(subgroups && !software)
fn write(block: vec3i, nodes: vec3i, worker: u32) {
    let own = vec3<bool>((vec3u(worker) & vec3u(1u, 2u, 4u)) != vec3u(0u));
    var kept = array(sum_00, sum_10);
    var given = array(sum_01, sum_11);
    if own.z {
        kept = array(sum_01, sum_11);
        given = array(sum_00, sum_10);
    }
    kept[0] += from_lane(given[0], 4u);
    kept[1] += from_lane(given[1], 4u);
    var row = kept[0];
    var other_row = kept[1];
    if own.y {
        row = kept[1];
        other_row = kept[0];
    }
    let values = transpose(row + from_lane(other_row, 2u));
    let first = select(values[0], values[2], own.x) + subgroupShuffleXor(select(values[2], values[0], own.x), 1u);
    let second = select(values[1], values[3], own.x) + subgroupShuffleXor(select(values[3], values[1], own.x), 1u);
    let node = block + select(vec3i(0), vec3i(2, 1, 1), own);
    if all(node < nodes) { deposited[node_index(node, nodes)] = first; }
    if all(node + vec3i(1, 0, 0) < nodes) { deposited[node_index(node, nodes) + 1u] = second; }
}

@if(subgroups && !software)
fn from_lane(sums: mat4x4f, other: u32) -> mat4x4f {
    return mat4x4f(
        subgroupShuffleXor(sums[0], other), subgroupShuffleXor(sums[1], other),
        subgroupShuffleXor(sums[2], other), subgroupShuffleXor(sums[3], other),
    );
}

// Writes the four rows, each time the first of those that are left, and of each its nodes.
@if(!subgroups || software)
fn write(block: vec3i, nodes: vec3i, worker: u32) {
    for (var row = 0; row < 4; row++) {
        let y = block.y + (row & 1);
        let z = block.z + (row >> 1u);
        let end = select(block.x, min(block.x + BLOCK.x, nodes.x), y < nodes.y && z < nodes.z);
        var values = transpose(sum_00);
        for (var x = block.x; x < end; x++) {
            deposited[node_index(vec3i(x, y, z), nodes)] = values[0];
            values = next4(values);
        }
        sum_00 = sum_10;
        sum_10 = sum_01;
        sum_01 = sum_11;
    }
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let nodes = mesh.nodes;
    let at = invocation(id, groups);
    let block = block_of(item_of(at));
    if (block.z >= nodes.z) | frozen() { return; }
    per_spacing = 1.0 / mesh.spacing;
    deposit(block, nodes, Part(lane_of_item(at), SHARE, 0u, 1u));
    write(block, nodes, lane_of_item(at));
}
