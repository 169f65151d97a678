// The first pass of a sum over air: a partial sum of each workgroup. A pass says what a particle brings, in `term`.
import package::common::{params::params, dispatch::{invocation, WORKGROUP}, reduce::{partial_sum, total, TERMS}};
import package::pass::term;

fn sum_terms(id: vec3u, groups: vec3u, lane: u32, group: vec3u) {
    let all_of_them = groups.x * groups.y * WORKGROUP;
    var i = params.hair_points + invocation(id, groups);
    var own = mat2x4f();
    for (var k = 0u; k < TERMS && i < params.particles; k++) {
        own += term(i);
        i += all_of_them;
    }
    let all = total(lane, own);
    let g = group.y * groups.x + group.x;
    if lane == 0u && g < arrayLength(&partial_sum) { partial_sum[g] = all; }
}
