// How a strand goes through the step, and where its solver starts.
//
// A strand that was not finite is placed in its rest shape; a teleported one moves as a whole; one at rest without a
// push sleeps. The others are integrated: points and frames get their free moves, and the solver starts where the
// spins turn the frames. There
//
//   x_(k+1) = x_k + (rotation(turn_k) - 1) l d3_k + rotation(turn_k) u_k - u_k
//       u = chord - l d3, in moves since the step's start
//
// so that the strand is whole. A segment that is strained by more than WHOLE as the step begins has been pushed by a
// body, or written by a caller: its frame turns onto its chord, the strain that is left is cut to WHOLE, and the points
// beyond shift along, without a velocity.
import package::common::{
    params::{params, PARTICLES}, dispatch::{invocation, WORKGROUP},
    quaternion::{product, rotate, rotation, tangent, turned_by},
    integration::{KINEMATIC, HOLD, EULER, free_move, response}, rest::RESTING_STEPS, load::damping_of,
    rod::{
        Strand, Segment, RodStrand, RodPoint, RodSegment, SegmentHistory, FREE, SOLVED, TELEPORTED, ASLEEP, SLEEPS,
        PINS, NO_PIN, AT_PLACE, TIP_HELD, WHOLE, TURN, clamped,
    },
    validity::{FAR, FAST, within},
    status::{status, frozen, freeze, count, EULER_STEP, SLEEPING_STEP, TELEPORT, UNRECOVERED_STRAND},
};

@group(0) @binding(2) var<storage, read>       strands:         array<Strand>;
@group(0) @binding(3) var<storage, read>       segments:        array<Segment>;
@group(0) @binding(4) var<storage, read>       orientation:     array<vec4f>;
@group(0) @binding(5) var<storage, read>       segment_history: array<SegmentHistory>;
@group(0) @binding(6) var<storage, read_write> rod_strands:     array<RodStrand>;
@group(0) @binding(7) var<storage, read_write> rod_points:      array<RodPoint>;
@group(0) @binding(8) var<storage, read_write> rod_segments:    array<RodSegment>;

// force on the tip that bends a strand as far as a force on all of it: 3/8 of a beam, 1/ln n of a chain
const AT_TIP: f32 = 0.25;
const SHORTEST: f32 = 1e-3;    // lengths of the segment: a shorter chord has no direction
const OPPOSITE: f32 = 1e-4;    // 1 + cosine of two directions that no smallest rotation joins

// Adds the change of each point's velocity by external forces. Returns the push on the strand beyond that while it came
// to rest [m/s]: the mean over its points, or that of one point by AT_TIP, if it would bend the strand farther. A
// sleeping strand has no velocity but that by viscosity.
fn load(strand: Strand, sleeping: bool) -> f32 {
    var movable = 0.0;
    var sum = vec3f(0.0);
    var largest = 0.0;
    for (var k = 0u; k < strand.points; k++) {
        let p = strand.first_point + k;
        let point = rod_points[p];
        if point.inverse_mass == 0.0 { continue; }
        let velocity = point.velocity - point.external_dv;
        // Only a caller can have written such a speed while forcing/reset is left out: freeze, and replay with the
        // recovery passes.
        if !within(velocity, FAST) && status.inspected == 0u { freeze(UNRECOVERED_STRAND); }
        let felt = params.step * point.inverse_mass * (point.force - point.resistance * velocity);
        rod_points[p].external_dv = point.external_dv + felt;
        rod_points[p].impulse_change = point.impulse_change + felt;
        let push = point.impulse_change + felt + select(vec3f(0.0), velocity, sleeping);
        movable += 1.0;
        sum += push;
        largest = max(largest, length(push));
    }
    return max(length(sum) / max(movable, 1.0), largest / max(AT_TIP * movable, 1.0));
}

// Pins of a strand.
struct Pins {
    last: u32,       // point of the last, NO_PIN without any
    farthest: f32,   // m, from a pin to its point
}

// Lets the pins of a strand go their part of the way in this substep, all but the last as springs.
fn pull(strand: Strand) -> Pins {
    let left = params.substeps - status.step % params.substeps;
    var pins = Pins(NO_PIN, 0.0);
    if !PINS { return pins; }
    if (strand.joints & TIP_HELD) != 0u { pins.last = strand.points - 1u; }
    for (var done = 1u; done <= strand.points; done++) {
        let k = strand.points - done;
        let p = strand.first_point + k;
        if rod_points[p].pinned == 0u { continue; }
        pins.farthest = max(pins.farthest, length(rod_points[p].pin));
        if rod_points[p].pinned == AT_PLACE { rod_points[p].pin /= f32(left); }
        if pins.last != NO_PIN { continue; }
        pins.last = k;
        rod_points[p].pinned = 0u;
    }
    return pins;
}

// Whether a strand whose clamp rests goes on at rest. The drag on a trembling strand trembles too, and must not wake
// it.
fn rests(strand: Strand, resting: u32, woken: bool, push: f32) -> bool {
    let sleeping = resting == SLEEPS;
    let rested = resting >= RESTING_STEPS && f32(resting) * params.step >= strand.still_time;
    let pushed = (sleeping || params.model == PARTICLES) && push > strand.still_acceleration * params.step;
    return rested && !pushed && !(sleeping && woken);
}

fn chord_of(p: u32) -> vec3f {
    let gap = rod_points[p + 1u].start.xyz - rod_points[p].start.xyz;
    return gap + (rod_points[p + 1u].remainder - rod_points[p].remainder);
}

// Places a strand: in its rest shape, unrolled from the clamp, where a tip that is held stays; or as it is, turned with
// its root and moved with it. A sleeping strand keeps the external forces of its last step awake.
fn place(strand: Strand, rod: RodStrand, at_rest: bool, sleeps: bool) {
    let scheme = select(KINEMATIC, HOLD, sleeps);
    var frame = rod.root_frame;
    var displacement = rod.root_displacement;
    var offset = vec3f(0.0);   // from the root, as it is
    var rest = vec3f(0.0);     // and at rest
    for (var k = 0u; k < strand.points; k++) {
        let p = strand.first_point + k;
        rod_points[p].displacement = displacement;
        rod_points[p].scheme = scheme;
        if !sleeps {
            rod_points[p].force = vec3f(0.0);
            rod_points[p].resistance = 0.0;
            rod_points[p].external_dv = vec3f(0.0);
        }
        if k + 1u == strand.points { break; }
        let j = strand.first_segment + k;
        var start = orientation[j];
        if at_rest {
            frame = normalize(product(frame, segments[j].rest_rotation));
            start = frame;
        } else {
            frame = normalize(product(rod.root_turn, start));
        }
        var segment = RodSegment();
        segment.start = start;
        segment.frame = frame;
        segment.turn = vec4f(0.0, 0.0, 0.0, 1.0);
        segment.scheme = scheme;
        segment.rest_drift = segment_history[j].rest_drift;
        rod_segments[j] = segment;
        offset += chord_of(p);
        rest += segments[j].rest_length * tangent(frame);
        let end = select(rotate(rod.root_turn, offset), rest, at_rest);
        let stays = PINS & at_rest & ((strand.joints & TIP_HELD) != 0u) & (k + 2u == strand.points);
        displacement = select(rod.root_displacement + end - offset, rod.tip_displacement, stays);
    }
}

// A frame turned by the smallest rotation that takes its tangent onto a chord.
fn onto(chord: vec3f, frame: vec4f) -> vec4f {
    let along = tangent(frame);
    let goal = normalize(chord);
    let cosine = 1.0 + dot(along, goal);
    let half_turn = vec4f(rotate(frame, vec3f(1.0, 0.0, 0.0)), 0.0);
    return normalize(product(select(half_turn, normalize(vec4f(cross(along, goal), cosine)), cosine > OPPOSITE),
        frame));
}

fn set_off(strand: Strand, rod: RodStrand) {
    let direct = params.direct_rods != 0u;
    let scheme = rod.scheme;
    // Hair that comes out of a body gathers no speed.
    let keeps = f32(rod.comes_out == 0u);
    let root = rod_points[strand.first_point];
    var displacement = select(params.step * keeps * root.velocity, rod.root_displacement, root.inverse_mass == 0.0);
    var shift = vec3f(0.0);   // m, of the points beyond the segments that were made whole
    for (var k = 0u; k < strand.points; k++) {
        let p = strand.first_point + k;
        let here = rod_points[p];
        let held = here.inverse_mass == 0.0;
        let damping = damping_of(here);
        let acceleration = here.weight * params.gravity + here.inverse_mass * here.force;
        let moves = free_move(keeps * here.velocity, keeps * here.before, keeps * here.previous_move, acceleration,
            damping, scheme);
        let free = select(moves, select(rod.tip_displacement - shift, rod.root_displacement, !PINS || k == 0u), held);
        rod_points[p].free = free;
        if PINS { rod_points[p].pin = select(here.pin - shift, free, held); }
        rod_points[p].effective_inverse_mass = response(damping, scheme) * here.inverse_mass;
        rod_points[p].displacement = select(free, displacement, direct);
        rod_points[p].scheme = scheme;
        rod_points[p].remainder = here.remainder + shift;
        if k + 1u == strand.points { break; }

        let j = strand.first_segment + k;
        let next = rod_points[p + 1u];
        let history = segment_history[j];
        let l = segments[j].rest_length;
        let chord = (next.start.xyz - here.start.xyz) + (next.remainder - here.remainder);
        var start = orientation[j];
        var strain = chord - l * tangent(start);
        if direct && !(length(strain) <= WHOLE * l) {
            // Only a caller can have written such a length while forcing/reset is left out: freeze, and replay with the
            // recovery passes.
            if !(length(chord) < FAR * l) && status.inspected == 0u { freeze(UNRECOVERED_STRAND); }
            if length(chord) > SHORTEST * l { start = onto(chord, start); }
            let left = chord - l * tangent(start);
            strain = clamped(left, WHOLE * l);
            shift += strain - left;
        }
        let turn = rotation(clamped(params.step * keeps * history.angular_velocity, TURN));
        let free_turn = rotation(
            free_move(keeps * history.angular_velocity, keeps * history.before, keeps * history.turn, vec3f(0.0),
                params.damping, scheme),
        );
        let frame = normalize(product(select(free_turn, turn, direct), start));
        displacement += turned_by(turn, l * tangent(start) + strain);
        var segment = RodSegment();
        segment.start = start;
        segment.frame = frame;
        segment.turn = turn;
        segment.free = free_turn;
        segment.strain = rotate(turn, strain);
        segment.scheme = scheme;
        segment.rest_drift = history.rest_drift;
        rod_segments[j] = segment;
    }
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let s = invocation(id, groups);
    if (s >= params.strands) | frozen() { return; }
    let strand = strands[s];
    let rod = rod_strands[s];
    var condition = rod.condition;
    let resets = condition.failed != 0u;
    let jumps = resets || rod.state == TELEPORTED;
    let push = load(strand, condition.resting == SLEEPS);
    let pins = pull(strand);
    let woken = rod.woken != 0u || pins.farthest > strand.still_way;
    let sleeps = !jumps && rod.state == ASLEEP && rests(strand, condition.resting, woken, push);
    var state = rod.state;
    if jumps | sleeps {
        place(strand, rod, resets, sleeps);
        if resets { state = SOLVED; } else { count(select(TELEPORT, SLEEPING_STEP, sleeps)); }
        condition.resting = select(0u, SLEEPS, sleeps);
    } else {
        set_off(strand, rod);
        state = FREE;
        if condition.resting == SLEEPS { condition.resting = 0u; }
        if rod.scheme == EULER && params.bdf2 != 0u { count(EULER_STEP); }
    }
    if jumps { rod_strands[s].pin_force = vec3f(0.0); }
    condition.failed = 0u;
    condition.bdf2_ready = select(u32(!jumps), condition.bdf2_ready, sleeps);
    rod_strands[s].state = state;
    rod_strands[s].newton = 0u;
    rod_strands[s].steep = 0u;
    rod_strands[s].pin = pins.last;
    rod_strands[s].condition = condition;
}
