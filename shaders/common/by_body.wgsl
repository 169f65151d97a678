// The first pass of a sum for each body: partial sums of CHUNKS workgroups, in a fixed order. A pass computes a term
// for a body in `term`.
import package::common::{dispatch::WORKGROUP, reduce::{partial_sum, total, WORKERS}};
import package::pass::term;

const CHUNKS: u32 = 64u;   // partial sums of a body

fn sum_by_body(terms: u32, groups: vec3u, local: u32, group: vec3u) {
    @if(software) if local >= WORKERS { return; }
    let g = group.y * groups.x + group.x;
    let body = g / CHUNKS;
    var own = mat2x4f();
    if g < arrayLength(&partial_sum) {
        for (var lane = local; lane < WORKGROUP; lane += WORKERS) {
            var of_lane = mat2x4f();
            for (var i = g % CHUNKS * WORKGROUP + lane; i < terms; i += CHUNKS * WORKGROUP) {
                of_lane += term(i, body);
            }
            own += of_lane;
        }
    }
    let all = total(local, own);
    if local == 0u && g < arrayLength(&partial_sum) { partial_sum[g] = all; }
}
