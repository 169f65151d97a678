// Per strand: how it goes through this step, and from where its solver starts.
//
// A strand that was not finite starts again from its rest shape; a teleported one moves as a whole; one at rest that
// nothing pushes sleeps. The others are integrated. The direct solver starts a calm strand where its velocities lead, held by
// the forces of the step before, and others at their free move. A free move that a rod could not follow is capped and counted:
// what is loaded suddenly takes some steps until it feels all of the load.
import package::common::{
    params::{params, PARTICLES, TWO_WAY, MEAN_WIND}, dispatch::{invocation, WORKGROUP}, quaternion::{product, rotate, rotation, tangent},
    integration::{EULER, PUT, STAY, free_move, response}, rest::STILL_STEPS, load::damping_of,
    led::{held_move, led_move, led_turn}, body::{PUSHED, MOVED},
    rod::{Strand, Segment, RodStrand, RodPoint, RodSegment, Health, FREE, SOLVED, TELEPORTED, ASLEEP, SLEEPS, CALM_STEPS,
        ROOT_HELD, TIP_HELD, GROWTH, is_whole},
    share::{Stretch, owner_of, worker_of, stretch_of, sum_shared, largest_shared, any_shared},
    status::{frozen, count, MOVE_CAPPED, EULER_STEP, ASLEEP_STEP, TELEPORT},
};

@group(0) @binding(2) var<storage, read>       strands:      array<Strand>;
@group(0) @binding(3) var<storage, read>       segments:     array<Segment>;
@group(0) @binding(4) var<storage, read_write> rod_strands:  array<RodStrand>;
@group(0) @binding(5) var<storage, read_write> rod_points:   array<RodPoint>;
@group(0) @binding(6) var<storage, read_write> rod_segments: array<RodSegment>;
@group(0) @binding(7) var<storage, read_write> health:       array<Health>;

const AT_TIP: f32 = 0.25;  // force on the tip that bends a strand as far as a force on all of it: 3/8 of a beam, 1/ln n of a chain
const LOADED: f32 = 0.4;   // lengths of the strand: what forces may move a free point by, where the strand is whole

fn rested(strand: Strand, steps: u32) -> bool {
    return steps >= STILL_STEPS && f32(steps) * params.step >= strand.still_time;
}

// Whether something pushes the strand that did not while it came to rest: all of it on average, or one point by as much as bends
// the strand as far. A sleeper has no velocity but what viscosity gave it since. One that trembles feels the drag tremble, and is not pushed by that.
fn pushed(strand: Strand, own: Stretch, asleep: bool) -> bool {
    if !asleep && params.model != PARTICLES { return false; }
    var count = 0.0;   // of points that nothing holds
    var sum = vec3f(0.0);
    var largest = 0.0;
    for (var k = own.begin; k < own.end; k++) {
        let point = rod_points[strand.first_point + k];
        if point.inverse_mass == 0.0 { continue; }
        let push = select(point.push, point.stir, asleep);
        count += 1.0;
        sum += push;
        largest = max(largest, length(push));
    }
    let all = sum_shared(vec4f(sum, count));
    largest = largest_shared(largest);
    let felt = max(length(all.xyz) / max(all.w, 1.0), largest / max(AT_TIP * all.w, 1.0));
    return felt > strand.still_acceleration * params.step;
}

// A move without the rod: with all forces, and without those from outside.
struct Free {
    whole: vec3f,
    bare: vec3f,
}

// Where point k goes without its rod.
fn free_point(point: RodPoint, rod: RodStrand, k: u32) -> Free {
    if point.inverse_mass == 0.0 {
        let held = held_move(rod, k);
        return Free(held, held);
    }
    let damping = damping_of(point);
    let weight = point.weight * params.gravity;
    let loaded = weight + point.inverse_mass * point.force;
    return Free(
        free_move(point.velocity, point.before, point.carried, loaded, damping, rod.scheme),
        free_move(point.velocity, point.before, point.carried, weight, damping, rod.scheme),
    );
}

fn capped(shift: vec3f, origin: vec3f, largest: f32) -> vec3f {
    let way = shift - origin;
    return origin + (largest / max(length(way), largest)) * way;
}

// How a strand goes through the step: placed or integrated.
struct Way {
    placed: bool,
    at_rest: bool,   // placed in its rest shape, unrolled from the clamp, where a tip that is held stays; else as it is, turned with
                     // its root and moved with it
    sleeps: bool,    // placed, and remembers what pushed it when it fell asleep
    led: bool,       // integrated, from where its velocities lead
    scheme: u32,     // of its points
}

// What a walk along the points of a strand is for. Only the last one writes, so that nothing is read which this pass has written.
const MEAN: u32 = 0u;    // to find the mean free move of a strand whose root is free
const LOSES: u32 = 1u;   // to find what caps take from a strand that nothing holds, beside forces, which it keeps as a whole
const MOVES: u32 = 2u;   // to move the points, and the segments behind them

// Returns the farthest free move, or what `Condition.reach` is below 0. A strand that had to be put is held back: its free move
// is capped at a part of what it could not follow, and the cap grows from step to step until it cuts nothing. Of a strand that is placed
// nobody reads the free moves. Both ways have one text: what is written twice takes drivers twice as long to compile.
fn start(s: u32, strand: Strand, stretch: Stretch, speaks: bool, rod: RodStrand, reach: f32, way: Way) -> f32 {
    // Each segment of a strand that is placed stands on the one before: one invocation has them all.
    var own = stretch;
    if way.placed { own = Stretch(0u, 0u, select(0u, strand.points, speaks)); }
    let drags = params.model == TWO_WAY || params.model == MEAN_WIND;
    let grown = select(0.0, GROWTH * reach, params.direct_rods != 0u && drags);
    let held_back = reach < 0.0;
    let root_held = (strand.joints & ROOT_HELD) != 0u;
    let tip_held = (strand.joints & TIP_HELD) != 0u;
    let loose = !root_held && !tip_held;
    var origin = Free(rod.root_travel, rod.root_travel);   // what free moves are measured from
    var mean = Free();
    var lost = vec3f(0.0);   // N, to the caps, beside what is cut of forces
    var heaviness = 0.0;     // N/m
    var kept = vec3f(0.0);   // m, of what is lost
    var farthest = 0.0;
    var carried_far = held_back;
    // Of a strand that is placed: the frame before a segment, and where a point is placed.
    var frame = rod.root_frame;
    var offset = vec3f(0.0);   // from the root, as it is
    var rest = vec3f(0.0);     // and at rest
    var placed_travel = rod.root_travel;
    for (var walk = select(MEAN, MOVES, root_held | way.placed); walk <= MOVES; walk++) {
        if walk == LOSES && !loose { continue; }
        for (var k = own.begin; k < own.end; k++) {
            let p = strand.first_point + k;
            let point = rod_points[p];
            let moves = free_point(point, rod, k);
            let held = point.inverse_mass == 0.0;
            if walk == MEAN {
                mean = Free(mean.whole + moves.whole, mean.bare + moves.bare);
                continue;
            }
            var free = moves.whole;
            var far = 0.0;
            var reply = 0.0;
            var force = vec3f(0.0);
            var outside = vec3f(0.0);
            var cut = false;
            if !held {
                far = length(free - origin.whole);
                carried_far = carried_far || far > point.largest;
                reply = response(damping_of(point), rod.scheme) * point.inverse_mass;
                let loaded = reply * length(point.force);
                let bears = select(0.0, min(loaded, LOADED * strand.length), is_whole(rod));
                let bearable = max(point.largest + bears, grown);
                let largest = select(bearable, min(bearable, -reach), held_back);
                heaviness += 1.0 / reply;
                cut = (far > largest) & !way.placed;
                if cut {
                    free = capped(free, origin.whole, largest);
                    // What the force still moves the point by is all of it that the point feels, and that the air gives.
                    let bare_capped = capped(moves.bare, origin.bare, largest);
                    force = (free - bare_capped) / reply;
                    outside = point.outside + params.step * point.inverse_mass * (force - point.force);
                    lost += (moves.bare - bare_capped) / reply;
                    far = largest;
                }
            }
            if walk == LOSES { continue; }
            free += kept;
            farthest = max(farthest, far);
            let integrated = select(free, led_move(point, rod, k), way.led & !held);
            rod_points[p].free = free;
            rod_points[p].reply = reply;
            rod_points[p].travel = select(integrated, placed_travel, way.placed);
            rod_points[p].scheme = way.scheme;
            if cut { count(MOVE_CAPPED); }
            let forgets = way.placed & !way.sleeps;
            if cut | forgets {
                rod_points[p].force = force;
                rod_points[p].outside = outside;
            }
            if forgets { rod_points[p].resistance = 0.0; }

            if k + 1u == strand.points { continue; }
            let j = strand.first_segment + k;
            let segment = rod_segments[j];
            let free_turn = free_move(
                segment.angular_velocity, segment.before, segment.carried, vec3f(0.0), params.damping, rod.scheme,
            );
            let turn = select(select(free_turn, led_turn(segment), way.led), vec3f(0.0), way.placed);
            frame = normalize(product(
                select(select(rotation(turn), rod.root_turn, way.placed), frame, way.at_rest),
                select(segment.start, segments[j].rest_rotation, way.at_rest),
            ));
            rod_segments[j].free = free_turn;
            rod_segments[j].turn = turn;
            rod_segments[j].frame = frame;
            rod_segments[j].scheme = select(rod.scheme, PUT, way.placed);
            rod_segments[j].force = select(vec3f(0.0), rotate(frame, segment.force), way.led);
            rod_segments[j].moment = select(vec3f(0.0), segment.moment, way.led);
            // Frames that nothing may be known of are taken as they are put.
            if way.at_rest { rod_segments[j].start = frame; }
            offset += segment.chord;
            rest += segments[j].rest_length * tangent(frame);
            let place = select(rotate(rod.root_turn, offset), rest, way.at_rest);
            let stays = way.at_rest & tip_held & (k + 2u == strand.points);
            placed_travel = select(rod.root_travel + place - offset, vec3f(0.0), stays);
        }
        if walk == MEAN {
            let whole = sum_shared(vec4f(mean.whole, 0.0)).xyz;
            let bare = sum_shared(vec4f(mean.bare, 0.0)).xyz;
            origin = Free(whole / f32(strand.points), bare / f32(strand.points));
        }
        if walk == LOSES {
            let all = sum_shared(vec4f(lost, heaviness));
            kept = all.xyz / all.w;
        }
    }
    farthest = largest_shared(farthest);
    carried_far = any_shared(carried_far);
    // One that is torn where it is is mended, not put: put, it would stay torn.
    if speaks & !way.placed { rod_strands[s].far = u32(carried_far && is_whole(rod)); }
    return select(farthest, GROWTH * reach, held_back && farthest >= -reach);
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let at = invocation(id, groups);
    let s = owner_of(at);
    let speaks = worker_of(at) == 0u;   // for the strand
    if (s >= params.strands) | frozen() { return; }
    let strand = strands[s];
    let rod = rod_strands[s];
    let own = stretch_of(strand.points, worker_of(at));
    var found = health[s].committed;
    let bad = found.bad != 0u;
    found.bad = 0u;
    let jumps = bad || rod.state == TELEPORTED;
    let sleeps = !jumps && rod.state == ASLEEP && rested(strand, found.still)
        && !pushed(strand, own, found.still == SLEEPS)
        && !(found.still == SLEEPS && (found.touched & (PUSHED | MOVED)) != 0u);
    let placed = jumps | sleeps;
    found.calm = select(select(min(found.calm + 1u, CALM_STEPS), 0u, (rod.torn != 0u) | jumps), found.calm, sleeps);
    let led = !placed & (found.calm == CALM_STEPS) & (params.direct_rods != 0u);
    let scheme = select(rod.scheme, select(PUT, STAY, sleeps), placed);
    let reach = start(s, strand, own, speaks, rod, found.reach, Way(placed, bad, sleeps, led, scheme));
    if !speaks { return; }
    rod_strands[s].tip_moment = vec3f(0.0);
    rod_strands[s].misfit = 0.0;
    if sleeps {
        found.still = SLEEPS;
        count(ASLEEP_STEP);
    } else if jumps {
        found.still = 0u;
        if bad { rod_strands[s].state = SOLVED; } else { count(TELEPORT); }
    } else {
        found.reach = reach;
        if found.still == SLEEPS { found.still = 0u; }
        if rod.scheme == EULER && params.bdf2 != 0u { count(EULER_STEP); }
        rod_strands[s].state = FREE;
    }
    health[s].found = found;
}
