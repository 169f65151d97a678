// A strand that the direct solver tore (too stiff for its step and its segments: f32 does not resolve the system) is left to
// Gauss-Seidel, which is inexact but tears nothing: back to its free move, nothing held. The others are done.
import package::common::{
    params::{params, TWO_WAY, MEAN_WIND}, dispatch::{invocation, WORKGROUP}, quaternion::{product, rotation},
    rod::{Strand, RodStrand, RodPoint, RodSegment, FREE, SOLVED}, status::{frozen, count, RESCUED_STEP},
};

@group(0) @binding(2) var<storage, read>       strands:      array<Strand>;
@group(0) @binding(3) var<storage, read_write> rod_strands:  array<RodStrand>;
@group(0) @binding(4) var<storage, read_write> rod_points:   array<RodPoint>;
@group(0) @binding(5) var<storage, read_write> rod_segments: array<RodSegment>;

const LOST: f32 = 1.0;   // |C + alpha mu| of stretch-shear from which the direct solver has lost a strand

// What free moves are measured from: the root, or their mean where that is free.
fn base(strand: Strand, rod: RodStrand) -> vec3f {
    if rod_points[strand.first_point].inverse_mass == 0.0 { return rod.root_travel; }
    var sum = vec3f(0.0);
    for (var k = 0u; k < strand.points; k++) { sum += rod_points[strand.first_point + k].free; }
    return sum / f32(strand.points);
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let s = invocation(id, groups);
    if s >= params.strands || frozen() || rod_strands[s].state != FREE { return; }
    if rod_strands[s].misfit < LOST {
        rod_strands[s].state = SOLVED;
        return;
    }
    let strand = strands[s];
    let origin = base(strand, rod_strands[s]);
    // Free moves of calm strands were not capped there.
    let drags = params.model == TWO_WAY || params.model == MEAN_WIND;
    for (var k = 0u; k < strand.points; k++) {
        let p = strand.first_point + k;
        let way = rod_points[p].free - origin;
        let far = length(way);
        let capped = drags && rod_points[p].inverse_mass > 0.0 && far > rod_points[p].largest;
        rod_points[p].travel = select(rod_points[p].free, origin + (rod_points[p].largest / far) * way, capped);
    }
    for (var k = 0u; k < strand.points - 1u; k++) {
        let j = strand.first_segment + k;
        rod_segments[j].frame = normalize(product(rotation(rod_segments[j].free), rod_segments[j].start));
        rod_segments[j].force = vec3f(0.0);
        rod_segments[j].moment = vec3f(0.0);
    }
    count(RESCUED_STEP);
}
