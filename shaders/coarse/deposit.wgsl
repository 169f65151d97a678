// Carries the divergence of air to the nodes of the coarse grid.
//
//   r_n = sum_j phi_n(x_j) s_j       phi_n: product of a quadratic B-spline per axis, s from `source`
//
// A gather in a fixed order: an invocation makes 4 x 2 x 2 nodes from the rows of cells that reach them. Particles may be sorted
// into any cells that fill the box; a grid finer than those would read many particles in vain.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, status::frozen, mesh::{Mesh, node_in_box, node_index}, coarse::quadratic,
};

// Nodes that an invocation makes along each axis: four along x have their weights in one vec4f.
const BLOCK: vec3i = vec3i(4, 2, 2);

@group(0) @binding(2) var<uniform>             mesh:       Mesh;
@group(0) @binding(3) var<storage, read>       cell_start: array<u32>;
@group(0) @binding(4) var<storage, read>       brought:    array<vec4f>;   // xyz: place in spacings; w: s [1/s]
@group(0) @binding(5) var<storage, read_write> coarse:     array<f32>;     // r [1/s]

// Sums for the rows of four nodes along x at one of two y and two z.
var<private> sum_00: vec4f;
var<private> sum_10: vec4f;
var<private> sum_01: vec4f;
var<private> sum_11: vec4f;

// Adds what a particle brings, `t` spacings from the block's first node.
fn add(source: f32, t: vec3f) {
    let along = source * quadratic(vec4f(t.x, t.x - 1.0, t.x - 2.0, t.x - 3.0));
    let across = quadratic(vec4f(t.y, t.y - 1.0, t.z, t.z - 1.0));
    sum_00 += across.x * across.z * along;
    sum_10 += across.y * across.z * along;
    sum_01 += across.x * across.w * along;
    sum_11 += across.y * across.w * along;
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
    let blocks = (nodes + BLOCK - 1) / BLOCK;
    let b = i32(invocation(id, groups));
    if b >= blocks.x * blocks.y * blocks.z || frozen() { return; }
    let block = BLOCK * vec3i(b % blocks.x, b / blocks.x % blocks.y, b / (blocks.x * blocks.y));

    let cells = params.cells;
    let scale = mesh.spacing / params.cell_size;   // cells from node to node
    let first = vec3i(floor((vec3f(block) - 1.5) * scale));
    let last = vec3i(ceil((vec3f(block + BLOCK - 1) + 1.5) * scale)) - 1;
    // The cell in the box, and the block's first node as seen from the image of the box that the cell is in.
    let home = node_in_box(first, cells);
    let start = block - (first - home) / cells * nodes;
    var cell = home;
    var corner = start;
    for (var z = first.z; z <= last.z; z++) {
        cell.y = home.y;
        corner.y = start.y;
        for (var y = first.y; y <= last.y; y++) {
            let row = cells.x * (cell.y + cells.y * cell.z);
            // The row is read in runs of cells that end where the box repeats.
            cell.x = home.x;
            corner.x = start.x;
            var left = last.x + 1 - first.x;
            while left > 0 {
                let run = min(left, cells.x - cell.x);
                let end = cell_start[row + cell.x + run];
                for (var e = cell_start[row + cell.x]; e < end; e++) {
                    let one = brought[e];
                    add(one.w, one.xyz - vec3f(corner));
                }
                left -= run;
                cell.x = 0;
                corner.x -= nodes.x;
            }
            cell.y++;
            if cell.y == cells.y {
                cell.y = 0;
                corner.y -= nodes.y;
            }
        }
        cell.z++;
        if cell.z == cells.z {
            cell.z = 0;
            corner.z -= nodes.z;
        }
    }
    write(block, nodes, sum_00);
    write(block + vec3i(0, 1, 0), nodes, sum_10);
    write(block + vec3i(0, 0, 1), nodes, sum_01);
    write(block + vec3i(0, 1, 1), nodes, sum_11);
}
