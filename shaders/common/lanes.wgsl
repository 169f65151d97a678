// The eight invocations of a cluster exchange the neighbours that each of them has read: by subgroup operations, or
// through the workgroup's memory on a device whose subgroups may have fewer than eight lanes, or that has none.
// Invocations are taken to be numbered in a subgroup as they are in the workgroup, which drivers do where workgroups
// have one dimension.
//
// Software adapters (`software`) run the lanes of a subgroup instruction by instruction: a lane reads without a barrier
// values that another has written. A single barrier there makes all variables of a pass live in memory.
import package::common::dispatch::WORKGROUP;

const LANES: u32 = 8u;             // invocations that work together, and particles of a cluster

// A neighbour as one lane reads it for all eight lanes of the cluster.
struct Near {
    index: u32,      // of the particle
    at: vec3f,       // m, position of the periodic image that is the neighbour
    volume: f32,     // m^3
    value: vec4f,    // values of the particle that the pass needs,
    more: vec4f,     // and more of them
}

// Lane of an invocation, 0 to 7.
fn lane_of(local: u32) -> u32 {
    return local & (LANES - 1u);
}

@if(subgroups) var<private> shown: Near;

@if(!subgroups) var<workgroup> all_shown: array<Near, WORKGROUP>;
@if(!subgroups) var<workgroup> all_counts: array<u32, WORKGROUP>;
@if(!subgroups) var<workgroup> one_for_all: u32;
@if(!subgroups) var<private> shown_at: u32;

// Publishes this lane's neighbour to the other seven lanes. Every invocation of the workgroup calls it, from the same
// place.
@if(subgroups)
fn publish(local: u32, near: Near) {
    shown = near;
}
@if(!subgroups)
fn publish(local: u32, near: Near) {
    workgroupBarrier();
    shown_at = local;
    all_shown[local] = near;
    workgroupBarrier();
}

// Neighbour that lane own ^ other has published.
@if(subgroups)
fn from_lane(other: u32) -> Near {
    return Near(
        subgroupShuffleXor(shown.index, other),
        subgroupShuffleXor(shown.at, other),
        subgroupShuffleXor(shown.volume, other),
        subgroupShuffleXor(shown.value, other),
        subgroupShuffleXor(shown.more, other),
    );
}
@if(!subgroups)
fn from_lane(other: u32) -> Near {
    return all_shown[shown_at ^ other];
}

// Number of values that each lane keeps for the others.
const KEPT: u32 = 12u;

// number of lane 0 in the subgroup, or in the workgroup; a pass sets it before it calls `kept`
var<private> first_of_eight: u32;

@if(subgroups) var<private> keeps: array<vec2u, KEPT>;
@if(!subgroups) var<workgroup> all_keeps: array<array<vec2u, KEPT>, WORKGROUP>;

// Keeps a value under a number that is a constant. All eight lanes keep theirs before any calls `kept`, with
// `lane_barrier` in between.
@if(subgroups)
fn keep(local: u32, number: u32, value: vec2u) {
    keeps[number] = value;
}
@if(!subgroups)
fn keep(local: u32, number: u32, value: vec2u) {
    all_keeps[local][number] = value;
}

// Value that a lane has kept. Every invocation of the workgroup calls it, from the same place.
@if(subgroups)
fn kept(number: u32, lane: u32) -> vec2u {
    return subgroupShuffle(keeps[number], first_of_eight + lane);
}
@if(!subgroups)
fn kept(number: u32, lane: u32) -> vec2u {
    return all_keeps[first_of_eight + lane][number];
}

// Makes writes of each lane to the workgroup's memory visible to the other seven. Every invocation of the workgroup
// calls it, from the same place.
@if(software)
fn lane_barrier() {}
@if(!software)
fn lane_barrier() {
    workgroupBarrier();
}

// Bitwise or over the eight lanes.
@if(subgroups)
fn joined(local: u32, own: u32) -> u32 {
    var bits = own;
    bits |= subgroupShuffleXor(bits, 1u);
    bits |= subgroupShuffleXor(bits, 2u);
    return bits | subgroupShuffleXor(bits, 4u);
}
@if(!subgroups)
fn joined(local: u32, own: u32) -> u32 {
    workgroupBarrier();
    all_counts[local] = own;
    workgroupBarrier();
    let first = local - lane_of(local);
    var bits = 0u;
    for (var k = 0u; k < LANES; k++) { bits |= all_counts[first + k]; }
    return bits;
}

// One bit per lane: its `yes`.
fn votes(local: u32, yes: bool) -> u32 {
    return joined(local, u32(yes) << lane_of(local));
}

// Transposes the 8 x 8 bits that eight lanes hold, one row each; bit k of the result comes from lane own ^ k.
@if(subgroups)
fn turned(local: u32, bits: u32) -> u32 {
    let lane = lane_of(local);
    var byte = (bits >> lane) & 1u;
    byte |= ((subgroupShuffleXor(bits, 1u) >> lane) & 1u) << 1u;
    byte |= ((subgroupShuffleXor(bits, 2u) >> lane) & 1u) << 2u;
    byte |= ((subgroupShuffleXor(bits, 3u) >> lane) & 1u) << 3u;
    byte |= ((subgroupShuffleXor(bits, 4u) >> lane) & 1u) << 4u;
    byte |= ((subgroupShuffleXor(bits, 5u) >> lane) & 1u) << 5u;
    byte |= ((subgroupShuffleXor(bits, 6u) >> lane) & 1u) << 6u;
    byte |= ((subgroupShuffleXor(bits, 7u) >> lane) & 1u) << 7u;
    return byte;
}
@if(!subgroups)
fn turned(local: u32, bits: u32) -> u32 {
    workgroupBarrier();
    all_counts[local] = bits;
    workgroupBarrier();
    let lane = lane_of(local);
    var byte = 0u;
    for (var k = 0u; k < LANES; k++) {
        byte |= ((all_counts[local ^ k] >> lane) & 1u) << k;
    }
    return byte;
}

// Bitwise or over the subgroup, or over the workgroup without subgroups.
@if(subgroups)
fn bits_of_all(local: u32, bits: u32) -> u32 {
    return subgroupOr(bits);
}
@if(!subgroups)
fn bits_of_all(local: u32, bits: u32) -> u32 {
    workgroupBarrier();
    all_counts[local] = bits;
    workgroupBarrier();
    if local == 0u {
        var all = 0u;
        for (var k = 0u; k < WORKGROUP; k++) { all |= all_counts[k]; }
        one_for_all = all;
    }
    return workgroupUniformLoad(&one_for_all);
}

// Largest count of the subgroup, or of the workgroup without subgroups.
@if(subgroups)
fn largest_of_all(local: u32, count: u32) -> u32 {
    return subgroupMax(count);
}
@if(!subgroups)
fn largest_of_all(local: u32, count: u32) -> u32 {
    workgroupBarrier();
    all_counts[local] = count;
    workgroupBarrier();
    if local == 0u {
        var largest = 0u;
        for (var k = 0u; k < WORKGROUP; k++) { largest = max(largest, all_counts[k]); }
        one_for_all = largest;
    }
    return workgroupUniformLoad(&one_for_all);
}

@if(subgroups && !software) var<workgroup> most: atomic<u32>;
@if(subgroups && !software) var<workgroup> all_most: u32;

// Largest count of the workgroup, or of the subgroup where no barrier needs more. A pass calls it once.
@if(subgroups && !software)
fn largest_in_workgroup(local: u32, count: u32) -> u32 {
    atomicMax(&most, count);
    workgroupBarrier();
    if local == 0u { all_most = atomicLoad(&most); }
    return workgroupUniformLoad(&all_most);
}
@if(!subgroups || software)
fn largest_in_workgroup(local: u32, count: u32) -> u32 {
    return largest_of_all(local, count);
}
