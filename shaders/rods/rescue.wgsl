// A strand that the direct solver did not solve in its steps. One that is carried far (`RodStrand.far`) goes with its root as it is, and
// feels nothing in this step; if nothing holds it, it goes on as a whole with its momentum. Another that it tore (too stiff for its step
// and its segments: f32 does not resolve the system) is left to Gauss-Seidel, which is inexact but tears nothing: back to its free move,
// nothing held. Others are done.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, quaternion::{product, rotation}, integration::{EULER, PUT},
    rod::{Strand, RodStrand, RodPoint, RodSegment, FREE, SOLVED, LEFT, ROOT_HELD, TIP_HELD, unsolved},
    status::{frozen, count, RESCUED_STEP},
};

@group(0) @binding(2) var<storage, read>       strands:      array<Strand>;
@group(0) @binding(3) var<storage, read_write> rod_strands:  array<RodStrand>;
@group(0) @binding(4) var<storage, read_write> rod_points:   array<RodPoint>;
@group(0) @binding(5) var<storage, read_write> rod_segments: array<RodSegment>;

// The mean velocity of a strand that nothing holds, by mass.
fn mean_velocity(strand: Strand) -> vec3f {
    var momentum = vec3f(0.0);
    var mass = 0.0;
    for (var k = 0u; k < strand.points; k++) {
        let point = rod_points[strand.first_point + k];
        mass += 1.0 / point.inverse_mass;
        momentum += point.velocity / point.inverse_mass;
    }
    return momentum / mass;
}

fn put(strand: Strand, rod: RodStrand) {
    let loose = (strand.joints & (ROOT_HELD | TIP_HELD)) == 0u;
    var way = rod.root_travel;
    if loose { way = params.step * mean_velocity(strand); }
    for (var k = 0u; k < strand.points; k++) {
        let p = strand.first_point + k;
        rod_points[p].force = vec3f(0.0);
        rod_points[p].resistance = 0.0;
        rod_points[p].outside = vec3f(0.0);
        rod_points[p].travel = select(way, rod_points[p].free, rod_points[p].inverse_mass == 0.0);
        rod_points[p].scheme = select(PUT, EULER, loose);
    }
    for (var k = 0u; k < strand.points - 1u; k++) {
        let j = strand.first_segment + k;
        rod_segments[j].frame = rod_segments[j].start;
        rod_segments[j].scheme = PUT;
    }
}

fn release(strand: Strand) {
    for (var k = 0u; k < strand.points; k++) {
        let p = strand.first_point + k;
        rod_points[p].travel = rod_points[p].free;
    }
    for (var k = 0u; k < strand.points - 1u; k++) {
        let j = strand.first_segment + k;
        rod_segments[j].frame = normalize(product(rotation(rod_segments[j].free), rod_segments[j].start));
    }
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let s = invocation(id, groups);
    if (s >= params.strands) | frozen() { return; }
    let rod = rod_strands[s];
    if rod.state != FREE { return; }
    if !unsolved(rod) {
        rod_strands[s].state = SOLVED;
        return;
    }
    let strand = strands[s];
    for (var k = 0u; k < strand.points - 1u; k++) {
        let j = strand.first_segment + k;
        rod_segments[j].force = vec3f(0.0);
        rod_segments[j].moment = vec3f(0.0);
    }
    if rod.far != 0u {
        put(strand, rod);
        rod_strands[s].state = SOLVED;
    } else {
        release(strand);
        rod_strands[s].state = LEFT;
    }
    count(RESCUED_STEP);
}
