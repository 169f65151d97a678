// Deposits: sums over particles at the nodes of a grid, each particle weighed by a window.
//
//   D_n = sum_j f_j B(x_j/h_g - n),  B the product of a window along each axis
//
// A gather in a fixed order: a block of nodes is made from the rows of cells that reach it, by one lane or by some that
// share it. Particles may be sorted into any cells that fill the box; a grid finer than those would read many particles
// in vain. A pass reads a particle in `bring`, which returns its place in spacings, and adds the particle's values to
// its sums in `add`.
import package::common::mesh::{Mesh, Window, weights, window_of, node_index};
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

// The cells that reach a block are those from the first to the end, along each axis.
fn first_cell(block: vec3i, cells: vec3i, window: Window) -> vec3i {
    return vec3i(floor((vec3f(block) - window.half) * (vec3f(cells) / vec3f(mesh.nodes))));
}

fn end_cell(block: vec3i, cells: vec3i, window: Window) -> vec3i {
    return vec3i(ceil((vec3f(block + BLOCK - 1) + window.half) * (vec3f(cells) / vec3f(mesh.nodes))));
}

// Part of a block for one of the lanes that share it: of the runs of cells every `runs_apart`th from its own on, and
// of their particles every `particles_apart`th.
struct Part {
    run: u32,
    runs_apart: u32,
    particle: u32,
    particles_apart: u32,
}

// The quotient of two whole numbers, rounded down, from the inverse of the second. Half a unit more keeps the rounding
// of the inverse away from whole quotients, for numbers up to a million.
@if(subgroups && !software)
fn quotient(number: i32, inverse: f32) -> i32 {
    return i32(floor((f32(number) + 0.5) * inverse));
}

// Adds a lane's part of the particles that reach a block. There are `cells` in the box along each axis. A row of cells
// is read in runs that end where the box repeats; on a GPU a lane finds its own by their numbers.
@if(subgroups && !software)
fn deposit(block: vec3i, cells: vec3i, part: Part) {
    let nodes = mesh.nodes;
    let window = window_of(mesh.window);
    let first = first_cell(block, cells, window);
    let last = end_cell(block, cells, window);

    let per_box = 1.0 / vec3f(cells);
    let first_image = quotient(first.x, per_box.x);
    let runs = quotient(last.x - 1, per_box.x) + 1 - first_image;   // of a row
    let rows = last.yz - first.yz;
    let per_row = 1.0 / f32(runs);
    let per_layer = 1.0 / f32(rows.x);
    var run = i32(part.run);
    // One loop over the particles of all runs: a run may have few, and with a loop each all lanes would wait for the
    // fullest of theirs.
    var seen = vec3f(0.0);   // the block's first node, from the image of the box that the run is in
    var e = 0u;
    var end = 0u;
    loop {
        if e >= end {
            if run >= runs * rows.x * rows.y { break; }
            let row = quotient(run, per_row);
            let layer = quotient(row, per_layer);
            let y = first.y + row - layer * rows.x;
            let z = first.z + layer;
            let image = vec3i(first_image + run - row * runs, quotient(y, per_box.y), quotient(z, per_box.z));
            let home = vec3i(first.x, y, z) - image * cells;
            let begin = node_index(vec3i(max(home.x, 0), home.yz), cells);
            let length = min(last.x - image.x * cells.x, cells.x) - max(home.x, 0);
            e = cell_start[begin] + part.particle;
            end = cell_start[begin + u32(length)];
            seen = vec3f(block - image * nodes);
            run += i32(part.runs_apart);
        }
        if e < end {
            let t = bring(e) - seen;
            add(weights(window, vec4f(t.x, t.x - 1.0, t.x - 2.0, t.x - 3.0)),
                weights(window, vec4f(t.y, t.y - 1.0, t.z, t.z - 1.0)));
            e += part.particles_apart;
        }
    }
}

// The same for a lane that takes all runs (`run` is 0 and `runs_apart` 1), which is cheaper for it: from each run it
// goes on to the next.
@if(!subgroups || software)
fn deposit(block: vec3i, cells: vec3i, part: Part) {
    let nodes = mesh.nodes;
    let window = window_of(mesh.window);
    let first = first_cell(block, cells, window);
    let last = end_cell(block, cells, window);

    // The next cell to read, in the box and counted from the first, and the block's first node as seen from its image
    // of the box.
    let image = vec3i(floor(vec3f(first) / vec3f(cells)));
    let home = first - image * cells;
    let start = block - image * nodes;
    var cell = home;
    var corner = start;
    var place = first;
    // One loop over the particles of all rows: a row may have few, and with a loop each all lanes would wait for the
    // fullest of theirs.
    var seen = vec3f(0.0);
    var e = 0u;
    var end = 0u;
    loop {
        if e >= end {
            if place.z == last.z { break; }
            // A row is read in runs of cells that end where the box repeats.
            let run = min(last.x - place.x, cells.x - cell.x);
            let begin = node_index(cell, cells);
            e = cell_start[begin] + part.particle;
            end = cell_start[begin + u32(run)];
            seen = vec3f(corner);
            place.x += run;
            cell.x = 0;
            corner.x -= nodes.x;
            if place.x == last.x {
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
            add(weights(window, vec4f(t.x, t.x - 1.0, t.x - 2.0, t.x - 3.0)),
                weights(window, vec4f(t.y, t.y - 1.0, t.z, t.z - 1.0)));
            e += part.particles_apart;
        }
    }
}
