// Per strand: how it goes through this step, and from where its solver starts.
//
// A strand that was not finite starts again from its rest shape; a teleported one moves as a whole; one at rest that
// nothing pushes sleeps. The others are integrated. A calm strand goes where its velocities lead without being torn: it
// takes BDF2, and the direct solver starts from there, held by the forces of the step before. From where a strand is torn
// BDF2 blows up: it takes Euler, from its free move, until CALM_STEPS steps on end were calm. A free move that a rod could not
// follow is capped and counted.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, quaternion::{product, rotate, rotation, tangent},
    integration::{EULER, BDF2, PUT, free_move}, rest::{STILL_TIME, STILL_STEPS},
    rod::{Strand, Segment, RodStrand, RodPoint, RodSegment, Health, FREE, SOLVED, TELEPORTED, ASLEEP, SLEEPS,
        TIP_HELD},
    status::{frozen, count, MOVE_CAPPED, EULER_STEP, ASLEEP_STEP, TELEPORT},
};

@group(0) @binding(2) var<storage, read>       strands:      array<Strand>;
@group(0) @binding(3) var<storage, read>       segments:     array<Segment>;
@group(0) @binding(4) var<storage, read_write> rod_strands:  array<RodStrand>;
@group(0) @binding(5) var<storage, read_write> rod_points:   array<RodPoint>;
@group(0) @binding(6) var<storage, read_write> rod_segments: array<RodSegment>;
@group(0) @binding(7) var<storage, read_write> health:       array<Health>;
@group(0) @binding(8) var<storage, read>       touched:      array<u32>;   // per strand, of the step before: by bodies, or they moved

const TORN: f32 = 0.1;        // |C| of stretch-shear
const CALM_STEPS: u32 = 3u;   // on end, before BDF2

fn put_point(p: u32, travel: vec3f) {
    rod_points[p].travel = travel;
    rod_points[p].scheme = PUT;
}

fn put_segment(k: u32, frame: vec4f) {
    rod_segments[k].frame = frame;
    rod_segments[k].scheme = PUT;
    rod_segments[k].force = vec3f(0.0);
    rod_segments[k].moment = vec3f(0.0);
}

// The strand as it is, turned with its root and moved with it.
fn put_as_it_is(strand: Strand, rod: RodStrand) {
    var offset = vec3f(0.0);   // from the root
    put_point(strand.first_point, rod.root_travel);
    for (var k = 0u; k < strand.points - 1u; k++) {
        let j = strand.first_segment + k;
        offset += rod_segments[j].chord;
        put_segment(j, normalize(product(rod.root_turn, rod_segments[j].start)));
        put_point(strand.first_point + k + 1u, rod.root_travel + rotate(rod.root_turn, offset) - offset);
    }
}

// The rest shape, unrolled from the clamp; a tip that is held stays.
fn put_at_rest(strand: Strand, rod: RodStrand) {
    var frame = rod.root_frame;
    var offset = vec3f(0.0);   // from the root, as it is
    var rest = vec3f(0.0);     // and at rest
    put_point(strand.first_point, rod.root_travel);
    for (var k = 0u; k < strand.points - 1u; k++) {
        let j = strand.first_segment + k;
        frame = normalize(product(frame, segments[j].rest_rotation));
        offset += rod_segments[j].chord;
        rest += segments[j].rest_length * tangent(frame);
        put_segment(j, frame);
        let stays = k + 2u == strand.points && (strand.joints & TIP_HELD) != 0u;
        put_point(strand.first_point + k + 1u, select(rod.root_travel + rest - offset, vec3f(0.0), stays));
    }
}

fn rested(steps: u32) -> bool {
    return steps >= STILL_STEPS && f32(steps) * params.step >= STILL_TIME;
}

// By what acts from outside in this step; a sleeper has no velocity but what viscosity gave it since.
fn pushed(strand: Strand, asleep: bool) -> bool {
    for (var k = 0u; k < strand.points; k++) {
        let point = rod_points[strand.first_point + k];
        let push = length(select(point.change, point.velocity, asleep));
        if push > strand.still_acceleration * params.step { return true; }
    }
    return false;
}

// A held point goes where it is held.
fn free_point(strand: Strand, rod: RodStrand, k: u32, scheme: u32) -> vec3f {
    let point = rod_points[strand.first_point + k];
    if point.inverse_mass == 0.0 { return select(vec3f(0.0), rod.root_travel, k == 0u); }
    return free_move(point.velocity, point.before, point.carried, params.gravity, scheme);
}

fn free_turn(j: u32, scheme: u32) -> vec3f {
    let segment = rod_segments[j];
    return free_move(segment.angular_velocity, segment.before, segment.carried, vec3f(0.0), scheme);
}

// Where velocities lead. (By the velocity before, too, it would lead nearer; rings under moment then begin to swing.)
fn led_point(strand: Strand, rod: RodStrand, k: u32) -> vec3f {
    let point = rod_points[strand.first_point + k];
    if point.inverse_mass == 0.0 { return select(vec3f(0.0), rod.root_travel, k == 0u); }
    return params.step * point.velocity;
}

fn led_turn(j: u32) -> vec3f {
    return params.step * rod_segments[j].angular_velocity;
}

// max |C| of stretch-shear there.
fn tear(strand: Strand, rod: RodStrand) -> f32 {
    var worst = 0.0;
    var before = led_point(strand, rod, 0u);
    for (var k = 0u; k < strand.points - 1u; k++) {
        let j = strand.first_segment + k;
        let after = led_point(strand, rod, k + 1u);
        let frame = product(rotation(led_turn(j)), rod_segments[j].start);
        let chord = rod_segments[j].chord + after - before;
        worst = max(worst, length(chord / segments[j].rest_length - tangent(frame)));
        before = after;
    }
    return worst;
}

// What the free move is measured from: the root, or the strand's mean where that is free.
fn base(strand: Strand, rod: RodStrand, scheme: u32) -> vec3f {
    if rod_points[strand.first_point].inverse_mass == 0.0 { return rod.root_travel; }
    var sum = vec3f(0.0);
    for (var k = 0u; k < strand.points; k++) { sum += free_point(strand, rod, k, scheme); }
    return sum / f32(strand.points);
}

fn start(strand: Strand, rod: RodStrand, scheme: u32, led: bool) {
    let origin = base(strand, rod, scheme);
    for (var k = 0u; k < strand.points; k++) {
        let p = strand.first_point + k;
        let point = rod_points[p];
        var free = free_point(strand, rod, k, scheme);
        var travel = free;
        if point.inverse_mass > 0.0 {
            let far = length(free - origin);
            if led { travel = led_point(strand, rod, k); }
            if far > point.largest {
                free = origin + (point.largest / far) * (free - origin);
                travel = free;
                count(MOVE_CAPPED);
            }
        }
        rod_points[p].free = free;
        rod_points[p].travel = travel;
        rod_points[p].scheme = scheme;
    }
    for (var k = 0u; k < strand.points - 1u; k++) {
        let j = strand.first_segment + k;
        let segment = rod_segments[j];
        let free = free_turn(j, scheme);
        var turn = free;
        if led { turn = led_turn(j); }
        let frame = normalize(product(rotation(turn), segment.start));
        rod_segments[j].free = free;
        rod_segments[j].turn = turn;
        rod_segments[j].frame = frame;
        rod_segments[j].scheme = scheme;
        rod_segments[j].force = select(vec3f(0.0), rotate(frame, segment.force), led);
        rod_segments[j].moment = select(vec3f(0.0), segment.moment, led);
    }
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let s = invocation(id, groups);
    if s >= params.strands || frozen() { return; }
    let strand = strands[s];
    let rod = rod_strands[s];
    var found = health[s].committed;
    let bad = found.bad != 0u;
    found.bad = 0u;
    rod_strands[s].tip_moment = vec3f(0.0);
    rod_strands[s].misfit = 0.0;
    if bad {
        found.calm = 0u;
        found.still = 0u;
        put_at_rest(strand, rod);
        rod_strands[s].state = SOLVED;
    } else if rod.state == TELEPORTED {
        found.calm = 0u;
        found.still = 0u;
        put_as_it_is(strand, rod);
        count(TELEPORT);
    } else if rod.state == ASLEEP && rested(found.still) && !pushed(strand, found.still == SLEEPS)
        && !(found.still == SLEEPS && touched[s] != 0u) {
        found.still = SLEEPS;
        put_as_it_is(strand, rod);
        count(ASLEEP_STEP);
    } else {
        found.calm = select(0u, min(found.calm + 1u, CALM_STEPS), tear(strand, rod) < TORN);
        let calm = found.calm == CALM_STEPS;
        if !calm && params.bdf2 != 0u { count(EULER_STEP); }
        let scheme = select(EULER, BDF2, calm && params.bdf2 != 0u);
        start(strand, rod, scheme, calm && params.direct_rods != 0u);
        if found.still == SLEEPS { found.still = 0u; }
        rod_strands[s].state = FREE;
    }
    health[s].found = found;
}
