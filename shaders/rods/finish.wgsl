// Health of each strand after its solve: a non-finite one is held where it was for this step (so that it spoils no
// neighbour) and reset in the next; stretch is recorded; over-strain and rest are counted, steps on end. Where the direct solver
// has not solved a strand, which more Newton steps or `rods/rescue` would do, the step freezes, and is taken again with these.
import package::common::{
    params::{params, PARTICLES}, dispatch::{invocation, WORKGROUP}, integration::PUT,
    rest::{STILL_STEPS, STILL_TURN},
    rod::{Strand, Segment, RodStrand, RodPoint, RodSegment, Health, FREE, SOLVED, LEFT, SLEEPS, STRAINED_STEPS, strained_steps,
        ROOT_HELD, MISFIT, GROWTH, EASED, BAD, SPOILT, unsolved},
    status::{status, frozen, freeze, count, count_bad_strand, finite, finite3, finite4, OVER_STRAINED, UNMENDED_STRAND, BY_FINISH,
        NO_POINT},
};

@group(0) @binding(2) var<storage, read>       strands:      array<Strand>;
@group(0) @binding(3) var<storage, read>       segments:     array<Segment>;
@group(0) @binding(4) var<storage, read>       rod_strands:  array<RodStrand>;
@group(0) @binding(5) var<storage, read_write> rod_points:   array<RodPoint>;
@group(0) @binding(6) var<storage, read_write> rod_segments: array<RodSegment>;
@group(0) @binding(7) var<storage, read_write> health:       array<Health>;

fn hold(strand: Strand) {
    for (var k = 0u; k < strand.points; k++) {
        let p = strand.first_point + k;
        rod_points[p].force = vec3f(0.0);
        rod_points[p].resistance = 0.0;
        rod_points[p].outside = vec3f(0.0);
        rod_points[p].travel = vec3f(0.0);
        rod_points[p].scheme = PUT;
    }
    for (var k = 0u; k < strand.points - 1u; k++) {
        rod_segments[strand.first_segment + k].frame = rod_segments[strand.first_segment + k].start;
        rod_segments[strand.first_segment + k].scheme = PUT;
    }
}

// Multipliers of Gauss-Seidel are none that the direct solver could start from.
fn forget(strand: Strand) {
    for (var k = 0u; k < strand.points - 1u; k++) {
        rod_segments[strand.first_segment + k].force = vec3f(0.0);
        rod_segments[strand.first_segment + k].moment = vec3f(0.0);
    }
}

// Where it became still when the step began: by then contacts and viscosity have had their say. With the model PARTICLES, whose
// pushes nothing remembers, it must not be pushed either. A strand that nothing holds may drift as slowly as it will.
fn still(strand: Strand) -> bool {
    if (strand.joints & ROOT_HELD) == 0u { return false; }
    for (var k = 0u; k < strand.points; k++) {
        let point = rod_points[strand.first_point + k];
        let pushed = params.model == PARTICLES && length(point.push) > strand.still_acceleration * params.step;
        if pushed || !(length(point.strayed) <= strand.still_way) { return false; }
    }
    for (var k = 0u; k < strand.points - 1u; k++) {
        if !(length(rod_segments[strand.first_segment + k].strayed) <= STILL_TURN) { return false; }
    }
    return true;
}

// What acts from outside on a strand at rest is taken as a mean over the last steps in which it was still, about STILL_STEPS:
// the strand trembles, and so does its drag.
fn remember(strand: Strand, steps: u32) {
    for (var k = 0u; k < strand.points; k++) {
        let p = strand.first_point + k;
        rod_points[p].outside -= (1.0 - 1.0 / f32(min(steps, STILL_STEPS))) * rod_points[p].push;
    }
}

// From here on the strand may become still.
fn settle(strand: Strand) {
    for (var k = 0u; k < strand.points; k++) { rod_points[strand.first_point + k].strayed = vec3f(0.0); }
    for (var k = 0u; k < strand.points - 1u; k++) { rod_segments[strand.first_segment + k].strayed = vec3f(0.0); }
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let s = invocation(id, groups);
    if (s >= params.strands) | frozen() { return; }
    let rod = rod_strands[s];
    let more_would_solve = (rod.state == FREE) & ((params.direct_rods & params.few_newton_steps) != 0u);
    if more_would_solve | unsolved(rod) {
        freeze(UNMENDED_STRAND);
        return;
    }
    let strand = strands[s];
    var stretch = 0.0;
    var before = rod_points[strand.first_point].travel;
    var lost = select(strand.first_point, NO_POINT, finite3(before));   // the first point that is not finite
    for (var k = 0u; k < strand.points - 1u; k++) {
        let segment = rod_segments[strand.first_segment + k];
        let after = rod_points[strand.first_point + k + 1u].travel;
        let l = length(segment.chord + after - before);
        if lost == NO_POINT && !(finite3(after) && finite4(segment.frame)) { lost = strand.first_point + k + 1u; }
        before = after;
        stretch = max(stretch, abs(l / segments[strand.first_segment + k].rest_length - 1.0));
    }
    if lost != NO_POINT || !finite(stretch) {
        hold(strand);
        health[s].found.bad = BAD;
        health[s].found.reach = 0.0;
        // One that was spoilt when the step began is counted.
        if health[s].committed.bad != SPOILT { count_bad_strand(min(lost, strand.first_point + strand.points - 1u), BY_FINISH); }
        return;
    }
    atomicMax(&status.max_stretch, bitcast<u32>(stretch));

    var found = health[s].found;
    found.strained = strained_steps(found.strained, stretch);
    if found.strained == STRAINED_STEPS { count(OVER_STRAINED); }
    // The direct solver got nowhere near: Euler does, from its free move.
    if !(rod.misfit <= MISFIT) {
        found.calm = 0u;
        found.still = 0u;
        // It was put: the next step asks less of it.
        if rod.far != 0u && rod.state == SOLVED { found.reach *= select(-EASED, EASED / GROWTH, found.reach < 0.0); }
    }
    if rod.state == select(FREE, LEFT, params.direct_rods != 0u) { forget(strand); }
    if params.sleep != 0u && found.still != SLEEPS {
        found.still = select(0u, min(found.still, SLEEPS - 2u) + 1u, still(strand));
        if found.still == 0u { settle(strand); } else { remember(strand, found.still); }
    }
    health[s].found = found;
}
