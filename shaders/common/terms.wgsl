// The first pass of a sum over air: a partial sum of each workgroup. A pass computes a particle's term in `term`.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, reduce::{partial_sum, total, TERMS, WORKERS},
};
import package::pass::term;

fn sum_terms(id: vec3u, groups: vec3u, local: u32, group: vec3u) {
    @if(software) if local >= WORKERS { return; }
    let all_of_them = groups.x * groups.y * WORKGROUP;
    var own = mat2x4f();
    for (var lane = local; lane < WORKGROUP; lane += WORKERS) {
        var i = params.hair_points + invocation(id, groups) + lane - local;
        var of_lane = mat2x4f();
        for (var k = 0u; k < TERMS && i < params.particles; k++) {
            of_lane += term(i);
            i += all_of_them;
        }
        own += of_lane;
    }
    let all = total(local, own);
    let g = group.y * groups.x + group.x;
    if local == 0u && g < arrayLength(&partial_sum) { partial_sum[g] = all; }
}
