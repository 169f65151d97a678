// Deposits: sums over particles at the nodes of a grid, each particle weighed by a window.
//
//   D_n = sum_j f_j B(x_j/h_g - n),  B the product of a window along each axis
//
// A gather in a fixed order: a block of nodes is made from the rows of cells that reach it, by one lane or by some that share each row.
// Particles may be sorted into any cells that fill the box; a grid finer than those would read many particles in vain. A pass reads a
// particle in `bring`, which returns its place in spacings, and adds what it has read to its sums in `add`.
import package::common::mesh::{Mesh, weights, window_of, node_index};
import package::pass::{bring, add};

// Nodes of a block along each axis: four along x have their weights in one vec4f.
const BLOCK: vec3i = vec3i(4, 2, 2);

@group(0) @binding(2) var<uniform>       mesh:       Mesh;
@group(0) @binding(3) var<storage, read> cell_start: array<u32>;

// The first node of the block of this number. Beyond the last block its z is not among the nodes.
fn block_of(number: u32) -> vec3i {
    let blocks = (mesh.nodes + BLOCK - 1) / BLOCK;
    let row = i32(number) / blocks.x;
    let layer = row / blocks.y;
    return BLOCK * vec3i(i32(number) - row * blocks.x, row - layer * blocks.y, layer);
}

// What one of the lanes that share a block takes of it: every `rows_apart`th row of cells from its own on, and of a row's particles every
// `particles_apart`th.
struct Part {
    row: u32,
    rows_apart: u32,
    particle: u32,
    particles_apart: u32,
}

// Adds a lane's part of the particles that reach a block. There are `cells` in the box along each axis.
fn deposit(block: vec3i, cells: vec3i, part: Part) {
    let nodes = mesh.nodes;
    let window = window_of(mesh.order);
    let scale = vec3f(cells) / vec3f(nodes);   // cells from node to node
    let first = vec3i(floor((vec3f(block) - window.half) * scale));
    let last = vec3i(ceil((vec3f(block + BLOCK - 1) + window.half) * scale));   // the end: the cell before it still reaches a node

    // The next cell to read, in the box and counted from the first, and the block's first node as seen from its image of the box.
    let image = vec3i(floor(vec3f(first) / vec3f(cells)));
    let home = first - image * cells;
    let start = block - image * nodes;
    var cell = home;
    var corner = start;
    var place = first;
    var rows_left = part.row;   // until the next one of the lane's
    // One loop over the particles of all rows: a row may have few, and with a loop each all lanes would wait for the fullest of theirs.
    var seen = vec3f(0.0);
    var e = 0u;
    var end = 0u;
    loop {
        if e >= end {
            if place.z == last.z { break; }
            // A row is read in runs of cells that end where the box repeats.
            let run = min(last.x - place.x, cells.x - cell.x);
            let begin = node_index(cell, cells);
            if rows_left == 0u {
                e = cell_start[begin] + part.particle;
                end = cell_start[begin + u32(run)];
                seen = vec3f(corner);
            }
            place.x += run;
            cell.x = 0;
            corner.x -= nodes.x;
            if place.x == last.x {
                rows_left = select(rows_left, part.rows_apart, rows_left == 0u) - 1u;
                place = vec3i(first.x, place.y + 1, place.z);
                cell = vec3i(home.x, cell.y + 1, cell.z);
                corner.x = start.x;
                if cell.y == cells.y {
                    cell.y = 0;
                    corner.y -= nodes.y;
                }
            }
            if place.y == last.y {
                place = vec3i(first.x, first.y, place.z + 1);
                cell = vec3i(home.xy, cell.z + 1);
                corner = vec3i(start.xy, corner.z);
                if cell.z == cells.z {
                    cell.z = 0;
                    corner.z -= nodes.z;
                }
            }
        }
        if e < end {
            let t = bring(e) - seen;
            add(weights(window, vec4f(t.x, t.x - 1.0, t.x - 2.0, t.x - 3.0)), weights(window, vec4f(t.y, t.y - 1.0, t.z, t.z - 1.0)));
            e += part.particles_apart;
        }
    }
}
