// Eight invocations side by side show one another what each of them has read: by subgroup operations, or through the
// workgroup's memory on a device whose subgroups may have fewer than eight lanes, or that has none. Invocations are
// taken to be numbered in a subgroup as they are in the workgroup, which drivers do where workgroups have one
// dimension.
//
// Software adapters (`software`) run the lanes of a subgroup instruction by instruction: what one has written the
// others read without a barrier. A single barrier there makes all variables of a pass live in memory.
import package::common::dispatch::WORKGROUP;

const LANES: u32 = 8u;             // invocations that work together, and particles of a cluster

// A particle as its cluster reads it for all eight.
struct Near {
    index: u32,      // of the particle
    at: vec3f,       // m, where it is as seen from whoever meets it
    volume: f32,     // m^3
    value: vec4f,    // what the pass needs of it,
    more: vec4f,     // and more of that
}

// Place of an invocation among the eight.
fn lane_of(local: u32) -> u32 {
    return local & (LANES - 1u);
}

@if(subgroups) var<private> shown: Near;

@if(!subgroups) var<workgroup> all_shown: array<Near, WORKGROUP>;
@if(!subgroups) var<workgroup> all_counts: array<u32, WORKGROUP>;
@if(!subgroups) var<workgroup> one_for_all: u32;
@if(!subgroups) var<private> shown_at: u32;

// Shows the other seven what this invocation has. Every invocation of the workgroup calls it, from the same place.
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

// Value that another of the eight has published: of the lane whose number differs in the bits of `other`.
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

// Values that each of the eight keeps for the others, by number.
const KEPT: u32 = 12u;

// its number in the subgroup, or in the workgroup; a pass sets it before it asks for what is kept
var<private> first_of_eight: u32;

@if(subgroups) var<private> keeps: array<vec2u, KEPT>;
@if(!subgroups) var<workgroup> all_keeps: array<array<vec2u, KEPT>, WORKGROUP>;

// Keeps a value, by a number that is a constant. All eight keep theirs before any asks for one, and `lane_barrier` in
// between.
@if(subgroups)
fn keep(local: u32, number: u32, value: vec2u) {
    keeps[number] = value;
}
@if(!subgroups)
fn keep(local: u32, number: u32, value: vec2u) {
    all_keeps[local][number] = value;
}

// A value that one of the eight keeps. Every invocation of the workgroup asks, from the same place.
@if(subgroups)
fn kept(number: u32, lane: u32) -> vec2u {
    return subgroupShuffle(keeps[number], first_of_eight + lane);
}
@if(!subgroups)
fn kept(number: u32, lane: u32) -> vec2u {
    return all_keeps[first_of_eight + lane][number];
}

// Makes writes of each of the eight to the workgroup's memory visible to the other seven. Every invocation
// of the workgroup calls it, from the same place.
@if(software)
fn lane_barrier() {}
@if(!software)
fn lane_barrier() {
    workgroupBarrier();
}

// Every bit that any of the eight has.
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

// A bit for each of the eight: whether it says yes.
fn votes(local: u32, yes: bool) -> u32 {
    return joined(local, u32(yes) << lane_of(local));
}

// Turns a square of bits: bit k of the byte that an invocation gets is the bit with its own number of what another of
// the eight has, of the one whose place differs in the bits of k.
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

// Every bit that any of those that work in step with this invocation has.
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

// The largest of the counts of all that work in step with this invocation.
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

// The largest of the counts of a workgroup, or of all that work in step where no barrier needs more. A pass asks once.
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
