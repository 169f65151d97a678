// Carries the divergence of air to the nodes of the coarse grid, r, from the cells of the neighbour search. Many lanes
// share a block of nodes: there are few blocks, and thousands of particles reach each. A software adapter is busy with
// fewer.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, status::frozen, mesh::node_index,
    deposit::{mesh, block_of, deposit, Part, BLOCK},
};

@if(subgroups && !software) const SHARE: u32 = 64u;   // lanes that share a block,
@if(!subgroups || software) const SHARE: u32 = 16u;
@if(subgroups && !software) const ALONG: u32 = 8u;    // and that share a row of cells
@if(!subgroups || software) const ALONG: u32 = 16u;
const NODES: u32 = 16u;                               // of a block

// xyz: place in spacings; w: s [1/s], from `fluid/coarse_source`
@group(0) @binding(4) var<storage, read>       deposit_source: array<vec4f>;
@group(0) @binding(5) var<storage, read_write> coarse:  array<f32>;            // r [1/s]

// Sums for the rows of four nodes along x at one of two y and two z.
var<private> sum_00: vec4f;
var<private> sum_10: vec4f;
var<private> sum_01: vec4f;
var<private> sum_11: vec4f;
var<private> source: f32;
var<workgroup> sums: array<vec4f, 4 * WORKGROUP>;   // by lane, then by row of nodes

fn bring(e: u32) -> vec3f {
    let one = deposit_source[e];
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

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let nodes = mesh.nodes;
    let block = block_of(invocation(id, groups) / SHARE);
    let part = lane % SHARE;
    let own = Part(part / ALONG, SHARE / ALONG, part % ALONG, ALONG);
    if (block.z < nodes.z) & !frozen() { deposit(block, params.cells, own); }
    sums[4u * lane] = sum_00;
    sums[4u * lane + 1u] = sum_10;
    sums[4u * lane + 2u] = sum_01;
    sums[4u * lane + 3u] = sum_11;
    workgroupBarrier();
    // The first lanes add up a node each.
    let along = i32(part) % BLOCK.x;
    let row = i32(part) / BLOCK.x;
    let node = block + vec3i(along, row % BLOCK.y, row / BLOCK.y);
    if (part >= NODES) | any(node >= nodes) | frozen() { return; }
    let first = lane - part;
    var sum = 0.0;
    for (var other = first; other < first + SHARE; other++) { sum += sums[4u * other + part / 4u][part % 4u]; }
    coarse[node_index(node, nodes)] = sum;
}
