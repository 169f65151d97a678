// Health of each strand after its solve: stretch is recorded; over-strain and rest are counted, steps on end. A strand that is not finite,
// or of which a segment has become a thousand times too long, is held where it was for this step, so that it spoils no neighbour, and is
// reset in the next. If nobody looked at the strands when the step began, it may have been lost already: the step freezes, and is taken
// again with the passes that mend strands. So it is where the direct solver has not solved a strand, or has yet to solve it once more, which
// more Newton steps or `rods/rescue` would do.
import package::common::{
    params::{params, PARTICLES}, dispatch::{invocation, WORKGROUP}, integration::PUT,
    rest::{STILL_STEPS, STILL_TURN}, sound::FAR,
    rod::{Strand, Segment, RodStrand, RodPoint, RodSegment, Health, FREE, FITTED, SOLVED, LEFT, SLEEPS, STRAINED_STEPS, strained_steps,
        ROOT_HELD, MISFIT, GROWTH, EASED, BAD, SPOILT, misses, unsolved},
    share::{Stretch, owner_of, worker_of, stretch_of, largest_shared, least_shared, any_shared},
    status::{status, frozen, freeze, count, count_bad_strand, finite, finite3, finite4, OVER_STRAINED, UNMENDED_STRAND, BY_FINISH,
        NO_POINT},
};

@group(0) @binding(2) var<storage, read>       strands:      array<Strand>;
@group(0) @binding(3) var<storage, read>       segments:     array<Segment>;
@group(0) @binding(4) var<storage, read>       rod_strands:  array<RodStrand>;
@group(0) @binding(5) var<storage, read_write> rod_points:   array<RodPoint>;
@group(0) @binding(6) var<storage, read_write> rod_segments: array<RodSegment>;
@group(0) @binding(7) var<storage, read_write> health:       array<Health>;

// Where it became still when the step began: by then contacts and viscosity have had their say. With the model PARTICLES, whose
// pushes nothing remembers, it must not be pushed either. A strand that nothing holds may drift as slowly as it will.
fn still(strand: Strand, own: Stretch) -> bool {
    if (strand.joints & ROOT_HELD) == 0u { return false; }
    for (var k = own.begin; k < own.end; k++) {
        let point = rod_points[strand.first_point + k];
        let pushed = params.model == PARTICLES && length(point.push) > strand.still_acceleration * params.step;
        if pushed || !(length(point.strayed) <= strand.still_way) { return false; }
        if k + 1u == strand.points { continue; }
        if !(length(rod_segments[strand.first_segment + k].strayed) <= STILL_TURN) { return false; }
    }
    return true;
}

// How a strand ends the step.
struct Outcome {
    holds: bool,        // it stands where it was, and felt nothing
    forgets: bool,      // its multipliers are set to 0: the direct solver cannot start from those of Gauss-Seidel
    still_steps: u32,   // steps on end in which it was still, or 0. What acts from outside on a strand at rest is taken as a mean over
                        // them, or over the last STILL_STEPS: the strand trembles, and so does its drag
    settles: bool,      // from here on it may become still
}

fn end_step(strand: Strand, own: Stretch, outcome: Outcome) {
    let part = 1.0 - 1.0 / f32(clamp(outcome.still_steps, 1u, STILL_STEPS));
    for (var k = own.begin; k < own.end; k++) {
        let p = strand.first_point + k;
        if outcome.holds {
            rod_points[p].force = vec3f(0.0);
            rod_points[p].resistance = 0.0;
            rod_points[p].travel = vec3f(0.0);
            rod_points[p].scheme = PUT;
        }
        if outcome.holds | (outcome.still_steps > 0u) {
            rod_points[p].outside = select(rod_points[p].outside - part * rod_points[p].push, vec3f(0.0), outcome.holds);
        }
        if outcome.settles { rod_points[p].strayed = vec3f(0.0); }
        if k + 1u == strand.points { continue; }
        let j = strand.first_segment + k;
        if outcome.holds {
            rod_segments[j].frame = rod_segments[j].start;
            rod_segments[j].scheme = PUT;
        }
        if outcome.forgets {
            rod_segments[j].force = vec3f(0.0);
            rod_segments[j].moment = vec3f(0.0);
        }
        if outcome.settles { rod_segments[j].strayed = vec3f(0.0); }
    }
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let at = invocation(id, groups);
    let s = owner_of(at);
    let speaks = worker_of(at) == 0u;   // for the strand
    // Strands that are not solved freeze the step from here on, and all of those that share a strand stay or leave.
    if (s >= params.strands) | any_shared(frozen()) { return; }
    let rod = rod_strands[s];
    let more_would_solve = ((rod.state == FREE) | (rod.state == FITTED)) & ((params.direct_rods & params.few_newton_steps) != 0u);
    if more_would_solve | unsolved(rod) {
        freeze(UNMENDED_STRAND);
        return;
    }
    let strand = strands[s];
    let own = stretch_of(strand.points, worker_of(at));
    var stretch = 0.0;
    var before = vec3f(0.0);
    var lost = NO_POINT;   // the first point that is not finite
    for (var k = own.before; k < own.end; k++) {
        let after = rod_points[strand.first_point + k].travel;
        var whole = finite3(after);
        if k > own.before {
            let segment = rod_segments[strand.first_segment + k - 1u];
            let l = length(segment.chord + after - before);
            whole = whole & finite4(segment.frame);
            stretch = max(stretch, abs(l / segments[strand.first_segment + k - 1u].rest_length - 1.0));
        }
        if lost == NO_POINT && !whole { lost = strand.first_point + k; }
        before = after;
    }
    var found = health[s].found;
    stretch = largest_shared(stretch);
    lost = least_shared(lost);
    let holds = lost != NO_POINT || !finite(stretch) || stretch >= FAR;
    var outcome = Outcome(holds, false, 0u, false);
    if holds {
        if status.inspected == 0u { freeze(UNMENDED_STRAND); }
        found.bad = BAD;
        found.reach = 0.0;
        // One that was spoilt when the step began is counted.
        if speaks & (health[s].committed.bad != SPOILT) { count_bad_strand(min(lost, strand.first_point + strand.points - 1u), BY_FINISH); }
    } else {
        if speaks { atomicMax(&status.stretch, bitcast<u32>(stretch)); }
        found.strained = strained_steps(found.strained, stretch);
        if speaks & (found.strained == STRAINED_STEPS) { count(OVER_STRAINED); }
        // The direct solver got nowhere near: Euler does, from its free move.
        if !(rod.misfit <= MISFIT) {
            found.calm = 0u;
            found.still = 0u;
            // It was put: the next step asks less of it.
            if rod.far != 0u && rod.state == SOLVED && misses(rod) { found.reach *= select(-EASED, EASED / GROWTH, found.reach < 0.0); }
        }
        outcome.forgets = rod.state == select(FREE, LEFT, params.direct_rods != 0u);
        if params.sleep != 0u && found.still != SLEEPS {
            found.still = select(0u, min(found.still, SLEEPS - 2u) + 1u, !any_shared(!still(strand, own)));
            outcome.still_steps = found.still;
            outcome.settles = found.still == 0u;
        }
    }
    end_step(strand, own, outcome);
    if speaks { health[s].found = found; }
}
