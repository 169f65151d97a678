// Sums in a fixed order: over the terms of an invocation, over a workgroup (`common/terms.wgsl`), and over workgroups, in a second
// pass (`sums/total`). Up to eight sums are made at once.
import package::common::dispatch::WORKGROUP;

const TERMS: u32 = 16u;   // terms of an invocation, in a sum over particles

@group(0) @binding(21) var<storage, read_write> partial_sum: array<mat2x4f>;   // one of each workgroup of the first pass

var<workgroup> sums: array<mat2x4f, WORKGROUP>;

// Sum of what every lane brings; only lane 0 may use it.
fn total(lane: u32, own: mat2x4f) -> mat2x4f {
    sums[lane] = own;
    workgroupBarrier();
    for (var reach = WORKGROUP / 2u; reach > 0u; reach /= 2u) {
        if lane < reach { sums[lane] += sums[lane + reach]; }
        workgroupBarrier();
    }
    return sums[0];
}
