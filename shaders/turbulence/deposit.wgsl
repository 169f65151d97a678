// Carries what the filter sums to the nodes of its grid, and the volume with it.
//
//   D_n = sum_j f_j B(x_j/h_g - n),  B the product of three B-splines, f from `weigh`
//
// A gather in a fixed order: an invocation makes 4 x 2 x 2 nodes from the rows of cells that reach them. Particles are sorted
// into the cells between the nodes.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, status::frozen, mesh::{Mesh, Spline, spline_of, b_spline, node_index},
};

// Nodes that an invocation makes along each axis: four along x have their weights in one vec4f.
const BLOCK: vec3i = vec3i(4, 2, 2);

@group(0) @binding(2) var<uniform>             mesh:            Mesh;
@group(0) @binding(3) var<storage, read>       cell_start:      array<u32>;
@group(0) @binding(4) var<storage, read>       sorted_position: array<vec4f>;
@group(0) @binding(5) var<storage, read>       flow:            array<vec4f>;   // xyz: V (v - U) [m^4/s]; w: V [m^3]
@group(0) @binding(6) var<storage, read_write> deposited:       array<vec4f>;   // D: xyz [m^4/s]; w [m^3]

// Sums for the row of four nodes along x at one of two y and two z: a column per component, a row per node.
var<private> sum_00: mat4x4f;
var<private> sum_10: mat4x4f;
var<private> sum_01: mat4x4f;
var<private> sum_11: mat4x4f;

// Adds what a particle carries, `t` spacings from the block's first node.
fn add(spline: Spline, carried: vec4f, t: vec3f) {
    let along = b_spline(spline, vec4f(t.x, t.x - 1.0, t.x - 2.0, t.x - 3.0));
    let across = b_spline(spline, vec4f(t.y, t.y - 1.0, t.z, t.z - 1.0));
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
    let blocks = (nodes + BLOCK - 1) / BLOCK;
    let b = i32(invocation(id, groups));
    let row = b / blocks.x;
    let layer = row / blocks.y;
    if layer >= blocks.z || frozen() { return; }
    let block = BLOCK * vec3i(b - row * blocks.x, row - layer * blocks.y, layer);
    let per_spacing = 1.0 / mesh.spacing;

    let spline = spline_of(mesh.order);
    let reach = i32(ceil(spline.half));   // cells on each side of a node that reach it
    let first = block - reach;
    let last = block + BLOCK + reach - 1;   // the end: the cell before it still reaches a node

    // One loop over the particles of all rows: a row has few, and with a loop each all lanes would wait for the fullest of theirs.
    var place = first;   // of the next cell to read, which may be in an image of the box
    var corner = vec3f(0.0);
    var e = 0u;
    var end = 0u;
    loop {
        if e == end {
            if place.z == last.z { break; }
            // A row is read in runs of cells that end where the box repeats.
            let turn = select(select(vec3i(0), nodes, place >= nodes), -nodes, place < vec3i(0));
            let home = place - turn;
            let run = min(last.x - place.x, nodes.x - home.x);
            let cell = node_index(home, nodes);
            e = cell_start[cell];
            end = cell_start[cell + u32(run)];
            corner = vec3f(block - turn);
            place.x += run;
            if place.x == last.x { place = vec3i(first.x, place.y + 1, place.z); }
            if place.y == last.y { place = vec3i(first.x, first.y, place.z + 1); }
        }
        if e < end {
            add(spline, flow[e], per_spacing * sorted_position[e].xyz - corner);
            e++;
        }
    }
    write(block, nodes, sum_00);
    write(block + vec3i(0, 1, 0), nodes, sum_10);
    write(block + vec3i(0, 0, 1), nodes, sum_01);
    write(block + vec3i(0, 1, 1), nodes, sum_11);
}
