// Carries what the filter sums to the nodes of its grid, D, and the volume with it. Particles are sorted into the cells between the
// nodes.
import package::common::{
    dispatch::{invocation, WORKGROUP}, status::frozen, mesh::node_index, deposit::{mesh, block_of, deposit},
};

@group(0) @binding(4) var<storage, read>       sorted_position: array<vec4f>;
@group(0) @binding(5) var<storage, read>       flow:            array<vec4f>;   // xyz: V (v - U) [m^4/s]; w: V [m^3], from `weigh`
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

fn write(node: vec3i, nodes: vec3i, sum: mat4x4f) {
    if node.y >= nodes.y || node.z >= nodes.z { return; }
    let rows = transpose(sum);
    write_node(node, nodes, rows[0]);
    write_node(node + vec3i(1, 0, 0), nodes, rows[1]);
    write_node(node + vec3i(2, 0, 0), nodes, rows[2]);
    write_node(node + vec3i(3, 0, 0), nodes, rows[3]);
}

fn write_node(node: vec3i, nodes: vec3i, value: vec4f) {
    if node.x < nodes.x { deposited[node_index(node, nodes)] = value; }
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let nodes = mesh.nodes;
    let block = block_of(invocation(id, groups));
    if (block.z >= nodes.z) | frozen() { return; }
    per_spacing = 1.0 / mesh.spacing;
    deposit(block, nodes, 0u, 1u);
    write(block, nodes, sum_00);
    write(block + vec3i(0, 1, 0), nodes, sum_10);
    write(block + vec3i(0, 0, 1), nodes, sum_01);
    write(block + vec3i(0, 1, 1), nodes, sum_11);
}
