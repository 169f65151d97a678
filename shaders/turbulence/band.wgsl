// The velocity of one band of eddies (eqs. 5 and 6), by direct sum over all images within the cut.
//
//   u_i = gain sum_j f_j (3 - q^2) exp(-q^2/2),  q = |x_i - x_j|/s,  f from `weigh`, self included
//
// A workgroup takes the particles of a block of cells in a row, eight to a lane, so that a particle j that is read
// serves eight sums. One dispatch reads some of the rows of cells around a block, and adds to the sums of earlier
// dispatches.
import package::common::{
    params::params, cells::{cell_of, turns_of, box_bucket}, status::frozen, band::Band,
};

// invocations of a workgroup: with SUMS each it takes the 56 air particles of an average block
const LANES: u32 = 8u;
const SUMS: u32 = 8u;      // sums that a lane makes, one per particle, held as two groups of four
const SHARES: u32 = 4u;    // workgroups of a block: 256 particles at once, more than it holds unless they clump

@group(0) @binding(2) var<uniform>             band:            Band;
@group(0) @binding(3) var<storage, read>       cell_start:      array<u32>;
@group(0) @binding(4) var<storage, read>       sorted:          array<u32>;
@group(0) @binding(5) var<storage, read>       sorted_position: array<vec4f>;
@group(0) @binding(6) var<storage, read>       flow_position:   array<vec4f>;
@group(0) @binding(7) var<storage, read>       flow:            array<vec4f>;
// velocity of the band [m/s]; as published [mm/s]
@group(0) @binding(8) var<storage, read_write> band_velocity:   array<vec4f>;

// Four vectors, component by component.
struct Four { x: vec4f, y: vec4f, z: vec4f }

var<private> near_own: Four;    // positions of the lane's first four particles [m]
var<private> far_own: Four;     // positions of the lane's other four particles [m]
var<private> near_sum: Four;
var<private> far_sum: Four;

fn hat(own: Four, other: vec3f) -> vec4f {
    let x = own.x - other.x;
    let y = own.y - other.y;
    let z = own.z - other.z;
    let squared = x * x + y * y + z * z;
    let q = squared * (1.0 / (band.scale * band.scale));
    return select(vec4f(0.0), (3.0 - q) * exp(-0.5 * q), squared <= vec4f(band.reach * band.reach));
}

fn add(e: u32, image: vec3f) {
    let other = flow_position[e].xyz + image;
    let f = flow[e].xyz;
    let near = hat(near_own, other);
    let far = hat(far_own, other);
    near_sum = Four(near_sum.x + f.x * near, near_sum.y + f.y * near, near_sum.z + f.z * near);
    far_sum = Four(far_sum.x + f.x * far, far_sum.y + f.y * far, far_sum.z + f.z * far);
}

// Adds the air in a number of cells of a row in the box, moved by whole boxes as `image` says.
fn add_row(first: vec3i, cells: i32, image: vec3f) {
    let bucket = box_bucket(first);
    let end = cell_start[bucket + u32(cells)];
    for (var e = cell_start[bucket]; e < end; e++) {
        add(e, image);
    }
}

// Adds the hair in a cell, which may be outside the box: it stands with hair of all cells that are whole boxes away.
fn add_hair(cell: vec3i, home: vec3i) {
    let bucket = params.box_cells + box_bucket(home);
    let end = cell_start[bucket + 1u];
    for (var e = cell_start[bucket]; e < end; e++) {
        if all(cell_of(sorted_position[e].xyz) == cell) { add(e, vec3f(0.0)); }
    }
}

// Adds the row of cells at (y, z) from `begin` up to `end` in x, cut where the box repeats.
fn walk(begin: i32, end: i32, y: i32, z: i32) {
    var x = begin;
    while x < end {
        let turns = turns_of(vec3i(x, y, z));
        let home = vec3i(x, y, z) - turns * params.cells;
        let run = min(end - x, params.cells.x - home.x);
        add_row(home, run, vec3f(turns) * params.box_size);
        let with_hair = select(0, run, (params.published_law != 0u) & (params.hair_points > 0u));
        for (var k = 0; k < with_hair; k++) { add_hair(vec3i(x + k, y, z), home + vec3i(k, 0, 0)); }
        x += run;
    }
}

fn four_from(e: vec4u) -> Four {
    let a = flow_position[e.x];
    let b = flow_position[e.y];
    let c = flow_position[e.z];
    let d = flow_position[e.w];
    return Four(vec4f(a.x, b.x, c.x, d.x), vec4f(a.y, b.y, c.y, d.y), vec4f(a.z, b.z, c.z, d.z));
}

fn write(e: u32, end: u32, sum: vec3f) {
    if e >= end || flow_position[e].w == 0.0 { return; }
    let i = sorted[e];
    let before = select(vec4f(0.0), band_velocity[i], band.first_row > 0);
    band_velocity[i] = before + vec4f(band.gain * sum, 0.0);
}

fn write_four(e: vec4u, end: u32, sum: Four) {
    write(e.x, end, vec3f(sum.x.x, sum.y.x, sum.z.x));
    write(e.y, end, vec3f(sum.x.y, sum.y.y, sum.z.y));
    write(e.z, end, vec3f(sum.x.z, sum.y.z, sum.z.z));
    write(e.w, end, vec3f(sum.x.w, sum.y.w, sum.z.w));
}

@compute @workgroup_size(LANES)
fn main(
    @builtin(workgroup_id) group: vec3u, @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_id) lane: vec3u,
) {
    let workgroup = group.y * groups.x + group.x;
    let block = band.first_block + workgroup / SHARES;
    if (block >= band.end_block) | frozen() { return; }
    let line = i32(block / band.blocks_in_row);
    let home = vec3i(i32(block % band.blocks_in_row) * band.cells_in_block, line % params.cells.y,
        line / params.cells.y);
    let width = min(band.cells_in_block, params.cells.x - home.x);
    let first = cell_start[box_bucket(home)];
    let end = cell_start[box_bucket(home) + u32(max(width, 0))];

    // Particles have moved since they were sorted, by less than a fifth of the kernel radius.
    let reach = (band.reach + 0.2 * params.kernel_radius) / params.cell_size;
    let wide = 2 * band.rows + 1;
    let batches = LANES * SUMS;
    for (var batch = first + workgroup % SHARES * batches; batch < end; batch += SHARES * batches) {
        let near = vec4u(batch + lane.x) + LANES * vec4u(0u, 1u, 2u, 3u);
        let far = near + 4u * LANES;
        near_own = four_from(min(near, vec4u(end - 1u)));
        far_own = four_from(min(far, vec4u(end - 1u)));
        near_sum = Four();
        far_sum = Four();
        for (var row = band.first_row; row < band.end_row; row++) {
            let y = row % wide - band.rows;
            let z = row / wide - band.layers;
            // The gap is how near cells of this row come, in parts of the reach.
            let gap = max(vec2f(abs(vec2i(y, z))) - 1.0, vec2f(0.0)) / reach.yz;
            let left = 1.0 - dot(gap, gap);
            if left <= 0.0 { continue; }
            let half = i32(ceil(reach.x * sqrt(left)));
            walk(home.x - half, home.x + width + half, home.y + y, home.z + z);
        }
        write_four(near, end, near_sum);
        write_four(far, end, far_sum);
    }
}
