// Sums in a fixed order: over the terms of an invocation, over a workgroup, and over workgroups by a second pass.
import package::common::dispatch::WORKGROUP;

const TERMS: u32 = 16u;   // terms of an invocation, in a sum over particles

var<workgroup> sums: array<vec4f, WORKGROUP>;

// Sum of what every lane brings; only lane 0 may use it.
fn total(lane: u32, own: vec4f) -> vec4f {
    sums[lane] = own;
    workgroupBarrier();
    for (var reach = WORKGROUP / 2u; reach > 0u; reach /= 2u) {
        if lane < reach { sums[lane] += sums[lane + reach]; }
        workgroupBarrier();
    }
    return sums[0];
}
