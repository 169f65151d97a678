// Totals the partial sums that the pass before has left (`common/terms.wgsl`), in a fixed order. All sums over air are totalled by this
// one text; who needs a mean makes it of the total.
import package::common::{dispatch::WORKGROUP, reduce::{partial_sum, total}};

@group(0) @binding(2) var<storage, read_write> totals: array<vec4f>;   // two: the eight sums

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(local_invocation_id) lane: vec3u) {
    var own = mat2x4f();
    for (var g = lane.x; g < arrayLength(&partial_sum); g += WORKGROUP) { own += partial_sum[g]; }
    let all = total(lane.x, own);
    if lane.x > 0u { return; }
    totals[0] = all[0];
    totals[1] = all[1];
}
