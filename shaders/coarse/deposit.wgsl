// Carries the divergence of air to the nodes of the coarse grid, r, from the cells of the neighbour search.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, status::frozen, mesh::node_index, deposit::{mesh, block_of, deposit},
};

@group(0) @binding(4) var<storage, read>       brought: array<vec4f>;   // xyz: place in spacings; w: s [1/s], from `source`
@group(0) @binding(5) var<storage, read_write> coarse:  array<f32>;     // r [1/s]

// Sums for the rows of four nodes along x at one of two y and two z.
var<private> sum_00: vec4f;
var<private> sum_10: vec4f;
var<private> sum_01: vec4f;
var<private> sum_11: vec4f;
var<private> source: f32;

fn bring(e: u32) -> vec3f {
    let one = brought[e];
    source = one.w;
    return one.xyz;
}

// Weights of four nodes along x; of two along y and two along z.
fn add(along: vec4f, across: vec4f) {
    let part = source * along;
    sum_00 += across.x * across.z * part;
    sum_10 += across.y * across.z * part;
    sum_01 += across.x * across.w * part;
    sum_11 += across.y * across.w * part;
}

fn write(node: vec3i, nodes: vec3i, sum: vec4f) {
    if node.y >= nodes.y || node.z >= nodes.z { return; }
    write_node(node, nodes, sum.x);
    write_node(node + vec3i(1, 0, 0), nodes, sum.y);
    write_node(node + vec3i(2, 0, 0), nodes, sum.z);
    write_node(node + vec3i(3, 0, 0), nodes, sum.w);
}

fn write_node(node: vec3i, nodes: vec3i, value: f32) {
    if node.x < nodes.x { coarse[node_index(node, nodes)] = value; }
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let nodes = mesh.nodes;
    let block = block_of(invocation(id, groups));
    if block.z >= nodes.z || frozen() { return; }
    deposit(block, params.cells);
    write(block, nodes, sum_00);
    write(block + vec3i(0, 1, 0), nodes, sum_10);
    write(block + vec3i(0, 0, 1), nodes, sum_01);
    write(block + vec3i(0, 1, 1), nodes, sum_11);
}
