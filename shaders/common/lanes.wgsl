// Eight invocations side by side show one another what each of them has read: by subgroup operations, or through the workgroup's
// memory on a device whose subgroups may have fewer than eight lanes, or that has none. Invocations are taken to be numbered in
// a subgroup as they are in the workgroup, which drivers do where workgroups have one dimension.
import package::common::dispatch::WORKGROUP;

const LANES: u32 = 8u;             // invocations that work together, and particles of a cluster

// A particle as others meet it.
struct Near {
    index: u32,      // of the particle, or NOBODY of the neighbour list
    met_by: u32,     // bit by bit, which of the eight it is a neighbour of
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
fn show(local: u32, near: Near) {
    shown = near;
}
@if(!subgroups)
fn show(local: u32, near: Near) {
    workgroupBarrier();
    shown_at = local;
    all_shown[local] = near;
    workgroupBarrier();
}

// What another of the eight has shown: of the lane whose number differs in the bits of `other`.
@if(subgroups)
fn shown_by(other: u32) -> Near {
    return Near(
        subgroupShuffleXor(shown.index, other),
        subgroupShuffleXor(shown.met_by, other),
        subgroupShuffleXor(shown.at, other),
        subgroupShuffleXor(shown.volume, other),
        subgroupShuffleXor(shown.value, other),
        subgroupShuffleXor(shown.more, other),
    );
}
@if(!subgroups)
fn shown_by(other: u32) -> Near {
    return all_shown[shown_at ^ other];
}

// A bit for each of the eight: whether it says yes.
@if(subgroups)
fn votes(local: u32, yes: bool) -> u32 {
    var bits = u32(yes) << lane_of(local);
    bits |= subgroupShuffleXor(bits, 1u);
    bits |= subgroupShuffleXor(bits, 2u);
    return bits | subgroupShuffleXor(bits, 4u);
}
@if(!subgroups)
fn votes(local: u32, yes: bool) -> u32 {
    workgroupBarrier();
    all_counts[local] = u32(yes);
    workgroupBarrier();
    let first = local - lane_of(local);
    var bits = 0u;
    for (var k = 0u; k < LANES; k++) { bits |= all_counts[first + k] << k; }
    return bits;
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
