// Lists, for every particle, the particles that are nearer than the kernel radius: by kinds (`Near`), each in the order of cells.
//
// Air meets air through the periodic faces; air and hair, hair and hair meet directly. The status sums the number of
// entries that the step needs, even beyond the end of a list that is too short: the step is then frozen, and the host
// grows the list to that number.
import package::common::{
    params::{params, TWO_WAY}, dispatch::{invocation, WORKGROUP}, near::Near,
    cells::{cell_of, air_cell_of, in_box, turns_of, box_bucket, hashed_bucket},
    owner::{strands, strand_of}, status::{status, frozen_before},
};

@group(0) @binding(2) var<storage, read>       cell_start:      array<u32>;
@group(0) @binding(3) var<storage, read>       sorted:          array<u32>;
@group(0) @binding(5) var<storage, read>       sorted_position: array<vec4f>;
@group(0) @binding(6) var<storage, read_write> neighbour_range: array<Near>;
@group(0) @binding(7) var<storage, read_write> neighbour_list:  array<u32>;

const HELD: u32 = 64u;   // entries kept while searching: air at rest has 26, and a particle with more than 64 is searched twice

var<private> own_entry: u32;
var<private> own: vec4f;
var<private> strand: vec2u;      // its strand's first point, and the end of the strand's points; air has none
var<private> found: vec3u;       // of each kind, in the order of `Near`
var<private> held: array<u32, HELD>;
var<private> writing: bool;      // second search: straight into the list
var<private> places: vec3u;      // in the list, where each kind begins

fn all_found() -> u32 {
    return found.x + found.y + found.z;
}

// An entry is kept, or written where its kind stands.
fn take(j: u32, air: bool) {
    let other = params.model == TWO_WAY && air != (own.w > 0.0);
    let joined = j >= strand.x && j < strand.y;
    let kind = vec3u(u32(!other && !joined), u32(joined), u32(other));
    if writing {
        neighbour_list[dot(kind, places + found)] = j;
    } else if all_found() < HELD {
        held[all_found()] = j;
    }
    found += kind;
}

// Looks at entries of cells in the box; `image` moves them by whole boxes, and only air meets an image.
fn look(begin: u32, end: u32, image: vec3f, imaged: bool) {
    let reach = params.kernel_radius * params.kernel_radius;
    let here = own.xyz - image;
    for (var e = begin; e < end; e++) {
        let other = sorted_position[e];
        let gap = here - other.xyz;
        if dot(gap, gap) < reach && e != own_entry && (other.w > 0.0 || !imaged) {
            take(sorted[e], other.w > 0.0);
        }
    }
}

// Looks at hair in a cell outside the box, with which other cells may share the bucket.
fn look_outside(cell: vec3i) {
    let bucket = hashed_bucket(cell);
    let reach = params.kernel_radius * params.kernel_radius;
    for (var e = cell_start[bucket]; e < cell_start[bucket + 1u]; e++) {
        let other = sorted_position[e];
        let gap = own.xyz - other.xyz;
        if dot(gap, gap) < reach && e != own_entry && all(cell_of(other.xyz) == cell) {
            take(sorted[e], false);
        }
    }
}

fn search() {
    found = vec3u(0u);
    let air = own.w > 0.0;
    var home = cell_of(own.xyz);
    if air { home = air_cell_of(own.xyz); }
    for (var z = -1; z <= 1; z++) {
        for (var y = -1; y <= 1; y++) {
            let row = home + vec3i(-1, y, z);
            if in_box(row) && in_box(row + vec3i(2, 0, 0)) {
                // Three cells in a row are neighbours in memory too.
                let bucket = box_bucket(row);
                look(cell_start[bucket], cell_start[bucket + 3u], vec3f(0.0), false);
                continue;
            }
            for (var x = 0; x <= 2; x++) {
                let cell = row + vec3i(x, 0, 0);
                if in_box(cell) {
                    let bucket = box_bucket(cell);
                    look(cell_start[bucket], cell_start[bucket + 1u], vec3f(0.0), false);
                    continue;
                }
                if air {
                    let turns = turns_of(cell);
                    let bucket = box_bucket(cell - turns * params.cells);
                    look(cell_start[bucket], cell_start[bucket + 1u], params.box_size * vec3f(turns), true);
                }
                look_outside(cell);
            }
        }
    }
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    own_entry = invocation(id, groups);
    if own_entry >= params.particles || frozen_before() { return; }
    own = sorted_position[own_entry];
    let i = sorted[own_entry];
    strand = vec2u(0u);
    if params.model == TWO_WAY && own.w == 0.0 {
        let whose = strands[strand_of(i)];
        strand = vec2u(whose.first_point, whose.first_point + whose.points);
    }

    writing = false;
    search();
    let total = all_found();
    let first = atomicAdd(&status.neighbours, total);
    if first + total < total {
        // The sum has passed 32 bits. What a later range overwrites does not matter: the step is frozen.
        atomicAdd(&status.neighbour_carries, 1u);
    }
    if total > params.neighbour_capacity || first > params.neighbour_capacity - total {
        neighbour_range[i] = Near(0u, 0u, 0u, 0u);
        return;
    }
    places = first + vec3u(0u, found.x, found.x + found.y);
    neighbour_range[i] = Near(first, places.y, places.z, first + total);
    writing = true;
    if total > HELD {
        search();
        return;
    }
    found = vec3u(0u);
    for (var n = 0u; n < total; n++) {
        take(held[n], held[n] >= params.hair_points);
    }
}
