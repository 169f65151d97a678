// Lists, for every cluster, the particles that are nearer than the kernel radius to any of its own
// (`common/list.wgsl`), in the order of cells.
//
// Air meets air through the periodic faces; air and hair, hair and hair meet directly. The status has the number of
// elements that the step needs, even beyond the end of a list that is too short: the step is then frozen, and the host
// grows the list to that number.
import package::common::{
    params::{params, TWO_WAY}, dispatch::{invocation, WORKGROUP}, cells::{wrap, home_of, box_bucket},
    page::of_page, list::{BATCHES, NOBODY, NONE, IMAGE_BITS, FRAME_BITS, FAR, elements_of, heads},
    lanes::{
        Near, LANES, lane_of, publish, from_lane, keep, kept, first_of_eight, lane_barrier, joined, votes, turned,
        bits_of_all, largest_of_all,
        largest_in_workgroup,
    },
    status::{status, freeze, NEIGHBOUR_OVERFLOW},
};

@group(0) @binding(2) var<storage, read>       cell_start:      array<u32>;
@group(0) @binding(3) var<storage, read>       sorted:          array<u32>;
@group(0) @binding(4) var<storage, read>       sorted_position: array<vec4f>;
// of each cluster: its first entry in cell order, and the end of its entries
@group(0) @binding(5) var<storage, read>       members:         array<vec2u>;
@group(0) @binding(6) var<storage, read_write> neighbour_list:  array<vec4u>;
@group(0) @binding(7) var<storage, read_write> page_ends:       array<atomic<u32>>;

const CLUSTERS: u32 = 8u; // of a workgroup
const ROWS: u32 = 9u;                      // of cells around a cluster
const TURNS: u32 = 3u;                     // boxes that a row may reach into: the one before, its own, the one behind
const OWN: u32 = 0u;                       // kinds: the cluster's own, the other one
const OTHER: u32 = 1u;
// number from which on the last row is kept: of each row 2 kinds of 3 ranges are kept
const LAST: u32 = 6u;
// candidates of a cluster that are kept while searching; with more it is searched again
const HELD: u32 = 168u;

// A candidate: 8 bits, cluster particles it neighbours; its offset in its range; the range's number. 0: none.
const PLACE_BITS: u32 = 8u;
const RANGE_BITS: u32 = 27u;
// entries of a range; a longer one freezes the step, as a list does that is too long for 32 bits
const PLACES: u32 = 524288u;

// A range is the entries, in cell order, of a row of cells in one of the periodic boxes that the row
// reaches into: the first, and the end. Its number is the number of the box times ROWS plus that of the row. A lane
// keeps the ranges of the row with its own number, and every lane keeps those of the last row.

// words of a cluster: HELD candidates, and a word per lane that takes the writes that are not kept
const KEEPS: u32 = 176u;

var<workgroup> held: array<u32, CLUSTERS * KEEPS>;

var<private> local: u32;           // place in the workgroup
var<private> lane: u32;            // 0 to 7, in the cluster
var<private> reach: f32;           // m^2, square of the kernel radius
var<private> own: array<vec3f, 8>; // positions of the cluster's particles [m]
var<private> low: vec3f;           // the least box around them, where they are in the box of air [m]
var<private> high: vec3f;
var<private> members_of: vec2u;   // entries of the cluster itself: the first, and the end
var<private> full: vec2u;         // of each kind, bit by bit, the ranges that are not empty
var<private> frame: vec3i;        // box shift: boxes by which the cluster is moved to meet others
var<private> found: u32;          // candidates so far
var<private> middle: u32;         // candidate from which on they are of the other kind
var<private> window: u32;         // candidate from which on they are kept
var<private> element: u32;        // of the list, which the invocation fills
var<private> filled: u32;         // batches of the element that are full
var<private> meets: u32;          // neighbours of the invocation's particle in them, a byte for each
var<private> crowded: bool;       // a range is too long for the offset of a candidate

fn cluster_in_workgroup() -> u32 {
    return local / LANES;
}

// Notes the ranges to be searched, of both kinds, in a row next to the cluster's own; they are kept under the numbers
// from `first` on.
fn look_ahead(home: vec3i, row: u32, first: u32, air: bool) {
    let cells = params.cells;
    let line = home.yz + step_of(row);
    let side = params.cell_size.yz * vec2f(line);
    let gap = max(max(side - high.yz, low.yz - side - params.cell_size.yz), vec2f(0.0));
    let left = reach - dot(gap, gap);
    let half = sqrt(max(left, 0.0));
    let start = i32(floor((low.x - half) / params.cell_size.x));
    let end = select(start, i32(floor((high.x + half) / params.cell_size.x)) + 1, left > 0.0);
    // A neighbour that is met directly is met once.
    let along = vec3i(start, end, min(end, start + cells.x));
    let at = select(select(line, line - cells.yz, line >= cells.yz), line + cells.yz, line < vec2i(0));
    let bucket = box_bucket(vec3i(0, at));
    note(0u, row, first, along, bucket, air);
    note(1u, row, first, along, bucket, air);
    note(2u, row, first, along, bucket, air);
}

// Notes the ranges to be searched in one of the boxes that a row reaches into.
fn note(turn: u32, row: u32, first: u32, along: vec3i, bucket: u32, air: bool) {
    let cells = params.cells.x;
    let span = bucket + vec3u(clamp(along - (i32(turn) - 1) * cells, vec3i(0), vec3i(cells)));
    let of_air = vec2u(cell_start[span.x], cell_start[select(span.z, span.y, air)]);
    let hair = select(vec2u(0u), params.box_cells + span.xz, params.hair_points > 0u);
    let of_hair = vec2u(cell_start[hair.x], cell_start[hair.y]);
    let own_kind = select(of_hair, of_air, air);
    let other_kind = select(of_air, of_hair, air);
    keep(local, first + TURNS * OWN + turn, own_kind);
    keep(local, first + TURNS * OTHER + turn, other_kind);
    let some = vec2<bool>(own_kind.y > own_kind.x, other_kind.y > other_kind.x);
    full |= select(vec2u(0u), vec2u(1u << (turn * ROWS + row)), some);
}

// Range number `which` of a kind, from the lane that keeps it: first entry and end.
fn range_of(kind: u32, which: u32) -> vec2u {
    let turn = turn_of(which);
    let row = which - ROWS * turn;
    let near = select(kept_in(turn, TURNS * OWN, row % LANES), kept_in(turn, TURNS * OTHER, row % LANES),
        kind == OTHER);
    let last = select(kept_in(turn, LAST + TURNS * OWN, lane), kept_in(turn, LAST + TURNS * OTHER, lane),
        kind == OTHER);
    return select(near, last, row == LANES);
}

fn kept_in(turn: u32, first: u32, by: u32) -> vec2u {
    let near = select(kept(first, by), kept(first + 1u, by), turn == 1u);
    return select(near, kept(first + 2u, by), turn == 2u);
}

// The box of a range: its number over ROWS, for up to 27.
fn turn_of(which: u32) -> u32 {
    return (which * 57u) >> 9u;
}

// Whole-box offset of the particles of a range to the image that is searched.
fn turns_of(home: vec3i, which: u32, periodic: bool) -> vec3i {
    let turn = turn_of(which);
    return select(vec3i(0), vec3i(i32(turn) - 1, turns_of_row(home, step_of(which - ROWS * turn))), periodic);
}

fn turns_of_row(home: vec3i, step: vec2i) -> vec2i {
    let row = home.yz + step;
    return select(select(vec2i(0), vec2i(1), row >= params.cells.yz), vec2i(-1), row < vec2i(0));
}

// The step from the cluster's row to the row number `row`.
fn step_of(row: u32) -> vec2i {
    let third = (row * 11u) >> 5u;   // row / 3 of up to 9
    return vec2i(i32(row - 3u * third), i32(third)) - 1;
}

// Which of the cluster's particles are nearer than the kernel radius, bit by bit.
fn met_by(at: vec3f) -> u32 {
    return near(0u, at) | near(1u, at) | near(2u, at) | near(3u, at) | near(4u, at) | near(5u, at) | near(6u, at)
        | near(7u, at);
}

fn near(other: u32, at: vec3f) -> u32 {
    let gap = own[other] - at;
    return select(0u, 1u << (lane ^ other), dot(gap, gap) < reach);
}

// Keeps a candidate.
fn take(entry: u32, hit: bool) {
    let bits = votes(local, hit);
    let place = found + countOneBits(bits & ((1u << lane) - 1u)) - window;
    // Every invocation writes: a branch that one of them takes by chance costs more than the write.
    held[cluster_in_workgroup() * KEEPS + select(HELD + lane, place, hit && place < HELD)] = entry;
    found += countOneBits(bits);
}

// Fills up the last batch of a part with candidates 0, which become NOBODY.
fn fill(ends: bool) {
    let over = found & (LANES - 1u);
    take(0u, ends && over > 0u && lane >= over);
}

// Position of the particle of an entry; of any particle from the end of the entry's range on.
fn position_of(entry: u32, end: u32) -> vec3f {
    return sorted_position[select(0u, entry, entry < end)].xyz;
}

// Looks for particles of a kind.
fn search(home: vec3i, kind: u32, periodic: bool) {
    var left = bits_of_all(local, select(full.x, full.y, kind == OTHER));
    while left > 0u {
        let which = firstTrailingBit(left);
        left &= left - 1u;
        let near = range_of(kind, which);
        let batches = largest_of_all(local, (near.y - near.x + LANES - 1u) / LANES);
        let turns = turns_of(home, which, periodic);
        let image = params.box_size * vec3f(turns);
        crowded |= near.y - near.x > PLACES;
        // A particle is not its own neighbour; its periodic image may be.
        let itself = select(members_of, vec2u(0u), any(turns != vec3i(0)));
        var e = near.x + lane;
        // A GPU reads the next batch while it looks at this one.
        @if(!software) var coming = position_of(e, near.y);
        for (var b = 0u; b < batches; b++) {
            let there = e < near.y;
            @if(software) let at = position_of(e, near.y) + image;
            @if(!software) let at = coming + image;
            @if(!software) coming = position_of(e + LANES, near.y);
            var mask = select(0u, met_by(at), there);
            mask &= select(0xffffffffu, ~(1u << (e - itself.x)), e >= itself.x && e < itself.y);
            take(mask | ((e - near.x) << PLACE_BITS) | (which << RANGE_BITS), mask != 0u);
            e += LANES;
        }
    }
}

// Looks for both kinds; returns the number of entries of the first part.
fn search_all(home: vec3i, air: bool) -> u32 {
    found = 0u;
    for (var kind = OWN; kind <= OTHER; kind++) {
        search(home, kind, air && kind == OWN);
        fill(kind == OTHER || params.model == TWO_WAY);
        if kind == OWN { middle = found; }
    }
    return select(found, middle, params.model == TWO_WAY);
}

// Copies the kept candidates to the cluster's groups in the list: `own_kind` of them are in the first part.
fn copy(groups: u32, own_kind: u32, home: vec3i, air: bool, used: bool) {
    let from_here = cluster_in_workgroup() * KEEPS;
    let end = largest_of_all(local, min(HELD, max(found, window) - window));
    let own_batches = own_kind / LANES;
    let batches = found / LANES;
    if window == 0u {
        element = groups + lane - LANES;
        filled = BATCHES;
    }
    for (var n = 0u; n < end; n += LANES) {
        let entry = window + n + lane;
        let there = used && entry < found;
        let word = select(0u, held[from_here + n + lane], there);
        let nobody = (word & 255u) == 0u;
        let which = word >> RANGE_BITS;
        let others = entry >= middle;
        let at = range_of(select(OWN, OTHER, others), which).x + ((word >> PLACE_BITS) & (PLACES - 1u));
        let seen = vec3u(turns_of(home, which, air && !others) + vec3i(1) - frame);
        let mark = (seen.x | (seen.y << 2u) | (seen.z << 4u)) << IMAGE_BITS;
        let bits = turned(local, word & 255u);
        // The groups of both parts follow one another.
        let batch = (window + n) / LANES;
        let begins = (filled == BATCHES) | (batch == own_batches);
        element += select(0u, LANES, begins);
        filled = select(filled, 0u, begins);
        meets = select(meets, 0u, begins) | (bits << (8u * filled));
        if there {
            neighbour_list[element][filled] = select(sorted[select(at, 0u, nobody)] | mark, NOBODY, nobody);
            if (filled == BATCHES - 1u) | (batch + 1u == own_batches) | (batch + 1u == batches) {
                neighbour_list[element].w = meets;
            }
        }
        filled++;
    }
}

// Where so many elements of the list begin; 0 where they do not fit.
fn room_for(length: u32) -> u32 {
    let begin = atomicAdd(&page_ends[params.page], length);
    atomicMax(&status.neighbours, begin + length);
    if begin + length < length {
        // The sum has passed 32 bits. Later clusters may overwrite the list, since the step is frozen.
        atomicAdd(&status.neighbour_carries, 1u);
    }
    let fits = length <= params.neighbour_capacity && begin <= params.neighbour_capacity - length;
    if !fits { freeze(NEIGHBOUR_OVERFLOW); }
    return select(0u, begin, fits);
}

// Whether the step froze before its list was made. In a step frozen by a list that is too short, the other clusters
// still add the length that they need.
fn frozen_before_list() -> bool {
    return (status.ended != 0u) | ((atomicLoad(&status.causes) & ~NEIGHBOUR_OVERFLOW) != 0u);
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) index: u32,
    @if(subgroups) @builtin(subgroup_invocation_id) in_subgroup: u32,
) {
    local = index;
    lane = lane_of(local);
    @if(subgroups) first_of_eight = in_subgroup - lane;
    @if(!subgroups) first_of_eight = local - lane;
    reach = params.kernel_radius * params.kernel_radius;
    let place = invocation(id, groups);
    let c = of_page(place) / LANES;
    var entries = vec2u(0u);
    if (c < params.clusters) & !frozen_before_list() { entries = members[c]; }
    members_of = entries;
    let e = entries.x + lane;
    let there = e < entries.y;
    let position = sorted_position[select(entries.x, e, there)];
    let air = position.w > 0.0;
    let inside = wrap(position.xyz);
    publish(local, Near(0u, select(vec3f(FAR), position.xyz, there), 0.0, vec4f(inside, 0.0), vec4f()));
    var near = from_lane(0u);
    own[0] = near.at; low = near.value.xyz; high = low;
    near = from_lane(1u); own[1] = near.at; low = min(low, near.value.xyz); high = max(high, near.value.xyz);
    near = from_lane(2u); own[2] = near.at; low = min(low, near.value.xyz); high = max(high, near.value.xyz);
    near = from_lane(3u); own[3] = near.at; low = min(low, near.value.xyz); high = max(high, near.value.xyz);
    near = from_lane(4u); own[4] = near.at; low = min(low, near.value.xyz); high = max(high, near.value.xyz);
    near = from_lane(5u); own[5] = near.at; low = min(low, near.value.xyz); high = max(high, near.value.xyz);
    near = from_lane(6u); own[6] = near.at; low = min(low, near.value.xyz); high = max(high, near.value.xyz);
    near = from_lane(7u); own[7] = near.at; low = min(low, near.value.xyz); high = max(high, near.value.xyz);

    let used = entries.x < entries.y;
    let through = high + params.kernel_radius >= params.box_size;
    frame = select(vec3i(0), vec3i(1), through & (low >= vec3f(params.kernel_radius)) & vec3<bool>(air));
    if !used {
        low = vec3f(FAR);
        high = vec3f(-FAR);
    }
    let home = home_of(sorted_position[entries.x].xyz);
    look_ahead(home, lane, 0u, air);
    look_ahead(home, LANES, LAST, air);
    var first = 0u;
    var searches = 1u;
    for (var k = 0u; k < searches; k++) {
        lane_barrier();
        window = HELD * k;
        let own_kind = search_all(home, air);
        lane_barrier();
        if k == 0u {
            searches = (largest_in_workgroup(local, found) + HELD - 1u) / HELD;
            let batches = vec2u(own_kind, found - own_kind) / LANES;
            if lane == 0u {
                if crowded {
                    atomicAdd(&status.neighbour_carries, 1u);
                    freeze(NEIGHBOUR_OVERFLOW);
                }
                if used { first = room_for(elements_of(batches.x) + elements_of(batches.y)); }
            }
            first = joined(local, first);
            if place < heads() {
                let moved = vec3u(frame) << vec3u(FRAME_BITS, FRAME_BITS + 1u, FRAME_BITS + 2u);
                let particle = sorted[select(entries.x, e, there)] | select(NONE, 0u, there);
                let head = vec4u(particle, first, batches | vec2u(moved.x | moved.y | moved.z, 0u));
                neighbour_list[place] = select(vec4u(0u), head, first > 0u);
            }
        }
        copy(first, own_kind, home, air, first > 0u);
    }
}
