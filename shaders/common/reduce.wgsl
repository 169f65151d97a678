// Sums in a fixed order: over the terms of a lane, over a workgroup, and over workgroups, in a second pass
// (`reduce/total`). Up to eight sums are made at once.
//
// Each of the workgroup's first eight lanes adds its own sum and those of every eighth lane after it, in this order;
// then these eight sums are added in pairs. On a software adapter (`software`) the first eight invocations make the
// terms of all lanes: it runs eight at once in any case, and takes long to compile a pass with a barrier.
import package::common::{dispatch::WORKGROUP, lanes::LANES};

const TERMS: u32 = 16u;   // terms of a lane, in a sum over particles

// Invocations that make terms. Each makes those of the lane of its own number and, if there are more lanes than
// invocations, those of every lane that is a multiple of this number farther.
@if(software) const WORKERS: u32 = LANES;
@if(!software) const WORKERS: u32 = WORKGROUP;

// one of each workgroup of the first pass
@group(0) @binding(21) var<storage, read_write> partial_sum: array<mat2x4f>;

@if(!software) var<workgroup> sums: array<mat2x4f, WORKGROUP>;

// Sum of the `own` of every invocation of the workgroup; only invocation 0 may use it.
@if(!software)
fn total(local: u32, own: mat2x4f) -> mat2x4f {
    sums[local] = own;
    workgroupBarrier();
    for (var lane = local + LANES; (lane < WORKGROUP) & (local < LANES); lane += LANES) { sums[local] += sums[lane]; }
    workgroupBarrier();
    for (var reach = LANES / 2u; reach > 0u; reach /= 2u) {
        if local < reach { sums[local] += sums[local + reach]; }
        workgroupBarrier();
    }
    return sums[0];
}
@if(software)
fn total(local: u32, own: mat2x4f) -> mat2x4f {
    var all = own;
    all += shown_by_lane(all, 4u);
    all += shown_by_lane(all, 2u);
    return all + shown_by_lane(all, 1u);
}

@if(software)
fn shown_by_lane(sums: mat2x4f, other: u32) -> mat2x4f {
    return mat2x4f(subgroupShuffleXor(sums[0], other), subgroupShuffleXor(sums[1], other));
}
