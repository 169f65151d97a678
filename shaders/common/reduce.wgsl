// Sums over a workgroup, in a fixed order.
import package::common::dispatch::WORKGROUP;

var<workgroup> sums: array<vec3f, WORKGROUP>;

// Sum of what every lane brings; only lane 0 may use it.
fn total(lane: u32, own: vec3f) -> vec3f {
    sums[lane] = own;
    workgroupBarrier();
    for (var reach = WORKGROUP / 2u; reach > 0u; reach /= 2u) {
        if lane < reach { sums[lane] += sums[lane + reach]; }
        workgroupBarrier();
    }
    return sums[0];
}
