// Carries what the filter sums to the nodes of its grid, and the volume with it.
//
//   D_n = sum_j f_j B(x_j/h_g - n),  B the product of three B-splines, f from `weigh`
//
// A gather in a fixed order: an invocation makes 4 x 2 x 2 nodes from the rows of cells that reach them. Particles may be sorted
// into any cells that fill the box; a grid finer than those would read many particles in vain.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, status::frozen,
    mesh::{Mesh, half_width, b_spline, node_in_box, node_index},
};

// Nodes that an invocation makes along each axis: four along x have their weights in one vec4f.
const BLOCK: vec3i = vec3i(4, 2, 2);

@group(0) @binding(2) var<uniform>             mesh:          Mesh;
@group(0) @binding(3) var<storage, read>       cell_start:    array<u32>;
@group(0) @binding(4) var<storage, read>       sorted_position: array<vec4f>;
@group(0) @binding(5) var<storage, read>       flow:          array<vec4f>;   // xyz: V (v - U) [m^4/s]; w: V [m^3]
@group(0) @binding(6) var<storage, read_write> deposited:     array<vec4f>;   // D: xyz [m^4/s]; w [m^3]

// Sums for the row of four nodes along x at one of two y and two z: a column per component, a row per node.
var<private> sum_00: mat4x4f;
var<private> sum_10: mat4x4f;
var<private> sum_01: mat4x4f;
var<private> sum_11: mat4x4f;

// Adds the particle of entry `e`. `corner` is the block's first node, in spacings, as seen from the image of the box.
fn add(e: u32, corner: vec3f) {
    let t = sorted_position[e].xyz / mesh.spacing - corner;
    let along = b_spline(mesh.order, vec4f(t.x, t.x - 1.0, t.x - 2.0, t.x - 3.0));
    let across = b_spline(mesh.order, vec4f(t.y, t.y - 1.0, t.z, t.z - 1.0));
    let f = flow[e];
    let part = mat4x4f(f.x * along, f.y * along, f.z * along, f.w * along);
    sum_00 += across.x * across.z * part;
    sum_10 += across.y * across.z * part;
    sum_01 += across.x * across.w * part;
    sum_11 += across.y * across.w * part;
}

fn write(node: vec3i, sum: mat4x4f) {
    if node.y >= mesh.nodes.y || node.z >= mesh.nodes.z { return; }
    let rows = transpose(sum);
    write_node(node, rows[0]);
    write_node(node + vec3i(1, 0, 0), rows[1]);
    write_node(node + vec3i(2, 0, 0), rows[2]);
    write_node(node + vec3i(3, 0, 0), rows[3]);
}

fn write_node(node: vec3i, value: vec4f) {
    if node.x < mesh.nodes.x { deposited[node_index(node, mesh.nodes)] = value; }
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let blocks = (mesh.nodes + BLOCK - 1) / BLOCK;
    let b = i32(invocation(id, groups));
    if b >= blocks.x * blocks.y * blocks.z || frozen() { return; }
    let block = BLOCK * vec3i(b % blocks.x, b / blocks.x % blocks.y, b / (blocks.x * blocks.y));

    let half = half_width(mesh.order);
    let scale = mesh.spacing / params.cell_size;   // cells from node to node
    let first = vec3i(floor((vec3f(block) - half) * scale));
    let last = vec3i(ceil((vec3f(block + BLOCK - 1) + half) * scale)) - 1;
    for (var z = first.z; z <= last.z; z++) {
        for (var y = first.y; y <= last.y; y++) {
            // The row is read in runs of cells that end where the box repeats.
            var x = first.x;
            while x <= last.x {
                let home = node_in_box(vec3i(x, y, z), params.cells);
                let run = min(last.x + 1 - x, params.cells.x - home.x);
                let cell = node_index(home, params.cells);
                let end = cell_start[cell + u32(run)];
                let boxes = (vec3i(x, y, z) - home) / params.cells;
                let corner = vec3f(block - boxes * mesh.nodes);
                for (var e = cell_start[cell]; e < end; e++) { add(e, corner); }
                x += run;
            }
        }
    }
    write(block, sum_00);
    write(block + vec3i(0, 1, 0), sum_10);
    write(block + vec3i(0, 0, 1), sum_01);
    write(block + vec3i(0, 1, 1), sum_11);
}
