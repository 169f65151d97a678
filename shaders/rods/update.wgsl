// Hair goes where its rods took it, with the velocity of that move; and the condition of each strand: its stretch is
// recorded, its consecutive steps of over-strain and of rest are counted. A strand that is not finite, or of which a
// segment has become a thousand times too long, is held where it was for this step, so that it spoils no neighbour, and
// is reset in the next. If `forcing/reset` was left out, the strand may have been invalid before the step: the step
// freezes, and is replayed with the passes that recover strands.
import package::common::{
    params::{params, PARTICLES}, dispatch::{invocation, WORKGROUP}, integration::{KINEMATIC, rate}, place::placed,
    rest::{RESTING_STEPS, STILL_TURN}, validity::FAR,
    rod::{
        Strand, Segment, RodStrand, RodPoint, RodSegment, FREE, SLEEPS, STRAINED_STEPS, strained_steps, ROOT_HELD,
        FAILED,
    },
    share::{Range, item_of, lane_of_item, range_of, largest_shared, least_shared, any_shared},
    status::{
        status, frozen, freeze, count, count_bad_strand, finite, finite3, finite4, OVER_STRAINED, UNSOLVED_STEP,
        UNRECOVERED_STRAND, BY_UPDATE, NO_POINT,
    },
};

@group(0) @binding(2) var<storage, read>       strands:      array<Strand>;
@group(0) @binding(3) var<storage, read>       segments:     array<Segment>;
@group(0) @binding(4) var<storage, read_write> rod_strands:  array<RodStrand>;
@group(0) @binding(5) var<storage, read_write> rod_points:   array<RodPoint>;
@group(0) @binding(6) var<storage, read_write> rod_segments: array<RodSegment>;
@group(0) @binding(7) var<storage, read_write> predicted:    array<vec4f>;
@group(0) @binding(8) var<storage, read_write> new_velocity: array<vec4f>;

// Whether the invocation's part of a strand is near the place where the strand became still, as of the step's start,
// which includes contacts and viscosity. With the model PARTICLES, which keeps no history of pushes, the part must not
// be pushed either. A strand with a free root never rests: it may drift however slowly.
fn resting(strand: Strand, own: Range) -> bool {
    if (strand.joints & ROOT_HELD) == 0u { return false; }
    for (var k = own.begin; k < own.end; k++) {
        let point = rod_points[strand.first_point + k];
        let pushed = params.model == PARTICLES
            && length(point.impulse_change) > strand.still_acceleration * params.step;
        if pushed || !(length(point.rest_drift) <= strand.still_way) { return false; }
        if k + 1u == strand.points { continue; }
        if !(length(rod_segments[strand.first_segment + k].rest_drift) <= STILL_TURN) { return false; }
    }
    return true;
}

// Of a range of points: the largest |l/l0 - 1|, and the first point that is not finite.
struct Measured {
    stretch: f32,
    lost: u32,
}

fn measure(strand: Strand, own: Range) -> Measured {
    var measured = Measured(0.0, NO_POINT);
    var before = rod_points[strand.first_point + own.before];
    for (var k = own.before; k < own.end; k++) {
        let here = rod_points[strand.first_point + k];
        var whole = finite3(here.displacement);
        if k > own.before {
            let j = strand.first_segment + k - 1u;
            let chord = (here.start.xyz - before.start.xyz) + (here.remainder - before.remainder)
                + (here.displacement - before.displacement);
            whole = whole & finite4(rod_segments[j].frame);
            measured.stretch = max(measured.stretch, abs(length(chord) / segments[j].rest_length - 1.0));
        }
        if measured.lost == NO_POINT && !whole { measured.lost = strand.first_point + k; }
        before = here;
    }
    return Measured(largest_shared(measured.stretch), least_shared(measured.lost));
}

// Holds the strand where it was as the step began; its loads are 0.
fn hold(strand: Strand, own: Range) {
    for (var k = own.begin; k < own.end; k++) {
        let p = strand.first_point + k;
        rod_points[p].force = vec3f(0.0);
        rod_points[p].resistance = 0.0;
        rod_points[p].external_dv = vec3f(0.0);
        rod_points[p].displacement = vec3f(0.0);
        rod_points[p].scheme = KINEMATIC;
        if k + 1u == strand.points { continue; }
        let j = strand.first_segment + k;
        rod_segments[j].frame = rod_segments[j].start;
        rod_segments[j].scheme = KINEMATIC;
    }
}

// Averages `external_dv` of a strand that was still for `steps` consecutive steps over these, or over the last
// RESTING_STEPS: the strand trembles, and so does its drag. After a step in which it was not still, the drift from
// which rest is measured starts at 0.
fn rest(strand: Strand, own: Range, steps: u32) {
    let part = 1.0 - 1.0 / f32(clamp(steps, 1u, RESTING_STEPS));
    for (var k = own.begin; k < own.end; k++) {
        let p = strand.first_point + k;
        if steps > 0u {
            rod_points[p].external_dv -= part * rod_points[p].impulse_change;
            continue;
        }
        rod_points[p].rest_drift = vec3f(0.0);
        if k + 1u < strand.points { rod_segments[strand.first_segment + k].rest_drift = vec3f(0.0); }
    }
}

fn go(strand: Strand, own: Range, tip_displacement: vec3f) {
    for (var k = own.begin; k < own.end; k++) {
        let p = strand.first_point + k;
        let point = rod_points[p];
        let place = placed(point.start.xyz, point.remainder, point.displacement);
        let velocity = rate(point.displacement, point.previous_move, point.scheme);
        // A tip that is held goes where it is held, to the bit.
        let held = (k > 0u) & (point.inverse_mass == 0.0);
        predicted[p] = vec4f(select(place, point.start.xyz + tip_displacement, held), point.start.w);
        new_velocity[p] = vec4f(select(velocity, tip_displacement / params.step, held), 0.0);
        rod_points[p].before = point.velocity;
    }
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let at = invocation(id, groups);
    let s = item_of(at);
    let is_leader = lane_of_item(at) == 0u;   // for the strand
    // An invalid strand freezes the step from here on; the invocations that share a strand go on or return together.
    if (s >= params.strands) | any_shared(frozen()) { return; }
    let strand = strands[s];
    let own = range_of(strand.points, lane_of_item(at));
    let rod = rod_strands[s];
    var condition = rod.condition;
    let measured = measure(strand, own);
    if measured.lost != NO_POINT || !finite(measured.stretch) || measured.stretch >= FAR {
        if status.inspected == 0u { freeze(UNRECOVERED_STRAND); }
        hold(strand, own);
        condition.failed = FAILED;
        condition.bdf2_ready = 0u;
        if is_leader { count_bad_strand(min(measured.lost, strand.first_point + strand.points - 1u), BY_UPDATE); }
    } else {
        condition.strained = strained_steps(condition.strained, measured.stretch);
        if params.sleep != 0u && condition.resting != SLEEPS {
            condition.resting = select(0u, min(condition.resting, SLEEPS - 2u) + 1u,
                !any_shared(!resting(strand, own)));
            rest(strand, own, condition.resting);
        }
        if is_leader {
            atomicMax(&status.stretch, bitcast<u32>(measured.stretch));
            if condition.strained == STRAINED_STEPS { count(OVER_STRAINED); }
            if (params.direct_rods != 0u && rod.state == FREE) || rod.comes_out != 0u { count(UNSOLVED_STEP); }
        }
    }
    go(strand, own, rod.tip_displacement);
    if is_leader { rod_strands[s].condition = condition; }
}
