// Totals the partial sums of the pass before (`common/terms.wgsl`), in a fixed order. All sums over air are totalled by
// this one pass; a pass that needs a mean divides the total.
import package::common::{dispatch::WORKGROUP, reduce::{partial_sum, total, WORKERS}};

@group(0) @binding(2) var<storage, read_write> totals: array<vec4f>;   // two elements: eight sums

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(local_invocation_id) id: vec3u) {
    let local = id.x;
    @if(software) if local >= WORKERS { return; }
    var own = mat2x4f();
    for (var lane = local; lane < WORKGROUP; lane += WORKERS) {
        var of_lane = mat2x4f();
        for (var g = lane; g < arrayLength(&partial_sum); g += WORKGROUP) { of_lane += partial_sum[g]; }
        own += of_lane;
    }
    let all = total(local, own);
    if local > 0u { return; }
    totals[0] = all[0];
    totals[1] = all[1];
}
