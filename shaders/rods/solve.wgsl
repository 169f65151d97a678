// Newton steps on the incremental potential of each strand, each solved exactly in linear time.
//
//   Phi = sum_i |x_i - free_i|^2/(2 W_i) + sum_k 4 J_k (1 - |p_w|) + sum_k 1/2 eps^T alpha_s^-1 eps + sum_joints 1/2 C^T alpha_b^-1 C
//         + sum_contacts 1/2 k (phi + D)^2
//   p = turn conj(free turn),  eps = R^T u/l,  C = Im(conj(q_(k-1)) q_k) - s Im(rest),  J = 1/W of a frame
//
// The unknowns are frames and strains u; points follow from them, x_(k+1) = x_k + l d3 + u, so that a strand is whole at every iterate:
//
//   dx_(k+1) = dx_k + theta_k x r_k + e_k,   theta_k = theta_(k-1) + phi_k,   r = l d3 + u
//
// Tip to root, what lies beyond a point acts on it as an articulated body (`common/articulated`); root to tip, turns and strains follow. The
// Hessian is Gauss-Newton's, and a frame under tension resists turning off the pull: it is positive definite, so that Phi falls along theta.
// Contacts with bodies are springs on points and segments (`common/contact`).
//
// One invocation per strand, until frames, strains, pins and contacts have settled. It runs on in a frozen step, in which nothing that it
// writes is committed: whether a step is frozen stands in a ninth buffer, and WebGPU's default allows eight.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, integration::response, pi::PI,
    quaternion::{product, conjugate, rotate, rotation, rotation_vector, tangent, matrix, turned_by},
    symmetric::{applied, applied_to_columns, cross_dyad, dyad, inverse_of, plus, twice_symmetric},
    articulated::{Answer, Beyond, ONE, Spring, crossing, joint, spring, swapped, through}, body::{BODIES, Placed, near},
    contact::{
        Contact, Met, Place, LIVE, MIDDLE, PLANE, RECOVERY, SLIDES, UNEASY, between, meet, nearest, parted, place_of_point, renewed, resists,
        seen_from, stiffness_of,
    },
    rod::{Strand, Segment, RodStrand, RodPoint, RodSegment, FREE, SOLVED, ROOT_JOINT, TIP_JOINT, ROOT_HELD, TIP_HELD, WHOLE, TURN, clamped},
};

@group(0) @binding(2) var<storage, read_write> factors:      array<Factor>;
@group(0) @binding(3) var<storage, read>       segments:     array<Segment>;
@group(0) @binding(4) var<storage, read_write> rod_strands:  array<RodStrand>;
@group(0) @binding(5) var<storage, read_write> rod_points:   array<RodPoint>;
@group(0) @binding(6) var<storage, read_write> rod_segments: array<RodSegment>;
@group(0) @binding(7) var<storage, read_write> contacts:     array<Contact>;   // of points, then of segments, each with every body
@group(0) @binding(8) var<storage, read>       placed:       array<Placed>;

const PIN: f32 = 1e4;         // stiffness of a pin, over that of its point's inertia: 1/W
const HELD_TURN: f32 = 0.5;   // rad, of a frame in a Newton step of a strand that is held beside its root
const UNCUT: f32 = 1e6;       // rad
// How a segment answers to the move v of its first point and the turn w of the frame before: phi and e.
struct Factor {
    bend: Answer,
    stretch: Answer,
}

const SETTLED: f32 = 1e-3;    // rad, of a frame, and strain, in a Newton step that is the last,
const RELATIVE: f32 = 1e-2;   // or this part of the first Newton step's
const BESIDE: f32 = 0.2;      // part of a segment from an end, nearer to which a place of it says nothing of the other end's velocity

// How contacts are after a Newton step.
struct Touch {
    touches: bool,
    changed: bool,   // some changed
    lags: bool,      // a multiplier, or the force that limits a friction, is not the force that acts
}

// What elimination leaves.
struct Eliminated {
    root_move: vec3f,   // of the root's point, 0 where it is held
    pin_force: vec3f,   // change of the force at the pin
}

// Adds a pin nearer to the root than the strand's last: a spring, and the force that it had in the step before.
fn pin_point(beyond: Beyond, point: RodPoint) -> Beyond {
    var sum = beyond;
    if point.pinned == 0u { return sum; }
    let k = PIN / point.reply;
    sum.own.diagonal += vec3f(k);
    sum.force += k * (point.travel - point.pin) + point.pin_force;
    return sum;
}

// Adds the contacts of a point; of the segment from point p on, whose second end is at `arm` from the first.
fn push_point(beyond: Beyond, rod: RodStrand, p: u32) -> Beyond {
    var sum = beyond;
    for (var b = 0u; b < bodies(rod); b++) {
        let contact = contacts[p * arrayLength(&placed) + b];
        if (contact.state & LIVE) == 0u { continue; }
        let push = resists(contact, rod_points[p].reply, rod.newton);
        sum.own = plus(sum.own, push.stiffness);
        sum.force += push.force;
    }
    return sum;
}
fn push_segment(beyond: Beyond, rod: RodStrand, p: u32, j: u32, arm: vec3f) -> Beyond {
    var sum = beyond;
    for (var b = 0u; b < bodies(rod); b++) {
        let contact = contacts[(params.hair_points + j) * arrayLength(&placed) + b];
        if (contact.state & LIVE) == 0u { continue; }
        let push = resists(contact, between(place_of_point(rod_points[p]), place_of_point(rod_points[p + 1u]), contact.place).reply, rod.newton);
        let reach = contact.place * arm;
        let swung = applied_to_columns(push.stiffness, -1.0 * crossing(reach, ONE));
        sum.own = plus(sum.own, push.stiffness);
        sum.cross += swung;
        sum.other = plus(sum.other, twice_symmetric(0.5 * crossing(reach, swung)));
        sum.force += push.force;
        sum.other_force += cross(reach, push.force);
        // The place shifts as the segment turns.
        let axis = cross(normalize(arm), contact.normal);
        sum.other = plus(sum.other, dyad(max(contact.force, 0.0) * contact.curve, axis));
    }
    return sum;
}

// Tip to root, under the force that holds the strand at its pin and a change of it, which counts for no tension. `steep` takes all of a segment's force for its
// tension, which is more than there is.
fn eliminate(strand: Strand, rod: RodStrand, change: vec3f) -> Eliminated {
    let last = strand.points - 2u;
    var holds = false;
    var frame = rod_segments[strand.first_segment + last].frame;
    var beyond = Beyond();
    if (strand.joints & TIP_JOINT) != 0u {
        let tip = joint(frame, rod.tip_frame, strand.tip_rest_rotation, strand.tip_compliance);
        beyond.other = tip.stiffness;
        beyond.other_force = -tip.force;
    }
    for (var done = 0u; done <= last; done++) {
        let k = last - done;
        let j = strand.first_segment + k;
        let point = rod_points[strand.first_point + k + 1u];
        let segment = segments[j];
        let now = rod_segments[j];
        let axes = matrix(frame);
        let l = segment.rest_length;
        let mass = select(1.0 / point.reply, 0.0, point.reply == 0.0);
        beyond.own.diagonal += vec3f(mass);
        beyond.force += mass * (point.travel - point.free);
        beyond = push_point(pin_point(beyond, point), rod, strand.first_point + k + 1u);
        if k + 1u == rod.pin {
            holds = true;
            beyond.held = ONE;
            beyond.force += rod.pin_force + change;
        }
        let stretched = through(beyond, spring((1.0 / l) * axes, segment.stretch_compliance, (now.strain * axes) / l), holds);
        beyond = stretched.beyond;

        // To the segment's first point.
        let arm = l * axes[2] + now.strain;
        let swung = applied_to_columns(beyond.own, -1.0 * crossing(arm, ONE));
        beyond.other = plus(beyond.other, twice_symmetric(crossing(arm, beyond.cross + 0.5 * swung)));
        beyond.cross += swung;
        beyond.other_force += cross(arm, beyond.force);
        beyond.other_held += crossing(arm, beyond.held);
        beyond = push_segment(beyond, rod, strand.first_point + k, j, arm);

        // The frame: its inertia, and the pull that it resists turning off.
        let inertia = 1.0 / (response(params.damping, now.scheme) * segment.inverse_inertia);
        let off = product(now.turn, conjugate(now.free));
        let force = beyond.force - beyond.held * change;
        let pull = select(max(0.0, -dot(force, axes[2])), length(force), rod.steep != 0u);
        beyond.other = plus(beyond.other, cross_dyad(l * pull, axes[2]));
        beyond.other.diagonal += vec3f(inertia);
        beyond.other_force += select(-2.0, 2.0, off.w >= 0.0) * inertia * off.xyz;

        var before = rod.root_frame;
        if k > 0u { before = rod_segments[j - 1u].frame; }
        var bends = joint(before, frame, segment.rest_rotation, segment.bend_compliance);
        if k == 0u && (strand.joints & ROOT_JOINT) == 0u { bends = Spring(); }
        let bent = through(swapped(beyond), bends, holds);
        beyond = swapped(bent.beyond);
        factors[j] = Factor(bent.answer, stretched.answer);
        frame = before;
    }
    let root = rod_points[strand.first_point];
    var root_move = vec3f(0.0);
    if root.reply > 0.0 {
        beyond.own.diagonal += vec3f(1.0 / root.reply);
        beyond.force += (root.travel - root.free) / root.reply;
        beyond = push_point(pin_point(beyond, root), rod, strand.first_point);
        let floats = through(beyond, Spring(), holds);
        root_move = -floats.answer.constant;
        beyond = floats.beyond;
    }
    if !holds { return Eliminated(root_move, vec3f(0.0)); }
    let pinned = rod_points[strand.first_point + rod.pin];
    return Eliminated(root_move, change + applied(inverse_of(beyond.give), pinned.travel - pinned.pin - beyond.given));
}

// The linear model of contacts: of a point that moves, and of the segment from point p on, which also turns.
fn foresee(rod: RodStrand, p: u32, reply: f32, shift: vec3f) {
    for (var b = 0u; b < bodies(rod); b++) {
        let i = p * arrayLength(&placed) + b;
        if (contacts[i].state & LIVE) == 0u { continue; }
        contacts[i].linear = contacts[i].multiplier - stiffness_of(reply) * (contacts[i].gap + dot(contacts[i].normal, shift));
    }
}
fn foresee_segment(rod: RodStrand, p: u32, j: u32, shift: vec3f, swing: vec3f) {
    for (var b = 0u; b < bodies(rod); b++) {
        let i = (params.hair_points + j) * arrayLength(&placed) + b;
        let contact = contacts[i];
        if (contact.state & LIVE) == 0u { continue; }
        let reply = between(place_of_point(rod_points[p]), place_of_point(rod_points[p + 1u]), contact.place).reply;
        contacts[i].linear = contact.multiplier - stiffness_of(reply) * (contact.gap + dot(contact.normal, shift + contact.place * swing));
    }
}

// How a joint turns less, and a segment gives, in the Newton step, by the turn before and the move of the segment's first point.
fn bend_of(factor: Factor, turn: vec3f, shift: vec3f) -> vec3f {
    return factor.bend.constant + factor.bend.by_own * turn + factor.bend.by_other * shift;
}
fn stretch_of(factor: Factor, turn: vec3f, shift: vec3f) -> vec3f {
    return factor.stretch.constant + factor.stretch.by_other * turn + factor.stretch.by_own * shift;
}

// Part of the Newton step that a strand takes which is held beside its root: joints that are cut by themselves would lead what is held away.
fn part_of(strand: Strand, root_move: vec3f) -> f32 {
    var most = 0.0;
    var shift = root_move;
    var turn = vec3f(0.0);
    for (var k = 0u; k < strand.points - 1u; k++) {
        let j = strand.first_segment + k;
        let now = rod_segments[j];
        turn -= bend_of(factors[j], turn, shift);
        shift += cross(turn, segments[j].rest_length * tangent(now.frame) + now.strain);
        shift -= stretch_of(factors[j], turn, shift);
        most = max(most, length(turn));
    }
    return min(1.0, HELD_TURN / most);
}

// Root to tip. Returns the largest turn of a frame [rad] or change of a strain.
fn substitute(strand: Strand, rod: RodStrand, root_move: vec3f, part: f32) -> f32 {
    var most = 0.0;
    var shift = root_move;     // v, to first order
    var turn = vec3f(0.0);     // w
    var travel_before = rod_points[strand.first_point].travel;
    var travel = travel_before + part * root_move;
    rod_points[strand.first_point].travel = travel;
    foresee(rod, strand.first_point, rod_points[strand.first_point].reply, root_move);
    for (var k = 0u; k < strand.points - 1u; k++) {
        let j = strand.first_segment + k;
        let p = strand.first_point + k + 1u;
        let now = rod_segments[j];
        let l = segments[j].rest_length;
        let along = l * tangent(now.frame);
        turn -= clamped(bend_of(factors[j], turn, shift), select(TURN, UNCUT, part < 1.0));
        turn = clamped(turn, select(PI, UNCUT, part < 1.0));
        foresee_segment(rod, p - 1u, j, shift, cross(turn, along + now.strain));
        shift += cross(turn, along + now.strain);
        let stretch = stretch_of(factors[j], turn, shift);
        shift -= stretch;
        foresee(rod, p, rod_points[p].reply, shift);
        let strain = clamped(now.strain - part * stretch, WHOLE * l);
        most = max(most, max(length(turn), length(strain - now.strain) / l));

        let rotated = rotation(part * turn);
        let chord = rod_points[p].travel - travel_before;
        travel_before = rod_points[p].travel;
        travel += chord + turned_by(rotated, along + strain) + (strain - now.strain);
        rod_points[p].travel = travel;
        let turned = normalize(product(rotated, now.turn));
        rod_segments[j].turn = turned;
        rod_segments[j].frame = normalize(product(turned, now.start));
        rod_segments[j].strain = rotate(rotated, strain);
    }
    return most;
}

// Bodies that a strand may meet.
fn bodies(rod: RodStrand) -> u32 {
    return select(0u, arrayLength(&placed), BODIES && rod.meets != 0u);
}

// Contacts of all places where they are now; `starts`: of the first time in the step. `renews` makes multipliers and the limits of friction what acts.
fn touch(strand: Strand, rod: RodStrand, starts: bool, renews: bool) -> Touch {
    var touch = Touch();
    for (var b = 0u; b < bodies(rod); b++) {
        let body = placed[b];
        var begins = Place();    // of the segment,
        var first = Contact();   // and its contact
        var before = 0.0;        // m, length of the segment
        for (var k = 0u; k < strand.points; k++) {
            let ends = place_of_point(rod_points[strand.first_point + k]);
            let after = segments[strand.first_segment + min(k, strand.points - 2u)].rest_length;
            let i = (strand.first_point + k) * bodies(rod) + b;
            let second = met_point(contacts[i], body, ends, starts, renews, max(before, after), k >= rod.embedded);
            contacts[i] = second.contact;
            touch = counted(touch, second);
            if k > 0u {
                let j = (params.hair_points + strand.first_segment + k - 1u) * bodies(rod) + b;
                let middle = met_segment(
                    contacts[j], body, begins, ends, first, second.contact, starts, renews, before, k > rod.embedded,
                );
                contacts[j] = middle.contact;
                touch = counted(touch, middle);
            }
            begins = ends;
            first = second.contact;
            before = after;
        }
    }
    return touch;
}

fn counted(before: Touch, met: Met) -> Touch {
    return Touch(
        before.touches || (met.contact.state & LIVE) != 0u, before.changed || met.changed, before.lags || met.lags,
    );
}

// A place is at least so far from a body as it was, less its way.
fn met_point(last: Contact, body: Placed, place: Place, starts: bool, renews: bool, reach: f32, may_touch: bool) -> Met {
    var contact = last;
    if renews { contact = renewed(last); }
    let seen = seen_from(body, place);
    let least = contact.before - length(seen.way);
    if least > reach { return parted(contact, least, starts); }
    let surface = near(body, seen.base, seen.way);
    if (contact.state & PLANE) == 0u { contact.normal = surface.normal; }
    if !may_touch { return parted(contact, surface.distance, starts); }
    return meet(contact, body, place, surface, starts, reach);
}

// The segment between two places, with the contacts of its ends.
fn met_segment(
    last: Contact, body: Placed, begins: Place, ends: Place, first: Contact, second: Contact, starts: bool, renews: bool, l: f32,
    may_touch: bool,
) -> Met {
    var contact = last;
    if renews { contact = renewed(last); }
    if !may_touch || first.gap + second.gap > l { return parted(contact, l, starts); }
    let plane = (contact.state & PLANE) != 0u;
    let found = nearest(contact, body, begins, ends, first.normal, second.normal, starts);
    if !plane {
        contact.place = found.part;
        contact.straight = found.straight;
        if starts { contact.curve = found.curve; }
    }
    if found.part < MIDDLE || found.part > 1.0 - MIDDLE { return parted(contact, l, starts); }
    return meet(contact, body, found.place, found.surface, starts, l);
}

// Contacts of an unsolved strand remember nothing. A point that touches, or that a touching segment moves, has the velocity of its move: all of
// it where it sticks, else across the surface, so that the integrator carries nothing into the body.
fn leave(strand: Strand, rod: RodStrand, solved: bool) {
    let count = bodies(rod);
    for (var k = 0u; k < strand.points; k++) {
        let p = strand.first_point + k;
        let j = params.hair_points + strand.first_segment + k;   // segment after it
        for (var b = 0u; b < count; b++) {
            slow(p, contacts[p * count + b]);
            if k > 0u && contacts[(j - 1u) * count + b].place >= BESIDE { slow(p, contacts[(j - 1u) * count + b]); }
            if k + 1u < strand.points && contacts[j * count + b].place <= 1.0 - BESIDE { slow(p, contacts[j * count + b]); }
        }
    }
    for (var k = 0u; k < strand.points && !solved; k++) {
        for (var b = 0u; b < count; b++) {
            let i = (strand.first_point + k) * count + b;
            forget(i);
            if k + 1u < strand.points { forget((params.hair_points + strand.first_segment + k) * count + b); }
        }
    }
}

fn forget(i: u32) {
    contacts[i].friction = vec3f(0.0);
    contacts[i].force = 0.0;
}

fn slow(p: u32, contact: Contact) {
    if (contact.state & LIVE) == 0u || rod_points[p].reply == 0.0 { return; }
    let point = rod_points[p];
    let sticks = (contact.state & SLIDES) == 0u && contact.grip > 0.0;
    let carried = point.travel - point.carried;
    let faster = point.travel / params.step - point.velocity;
    rod_points[p].carried += select(dot(carried, contact.normal) * contact.normal, carried, sticks);
    rod_points[p].velocity += select(dot(faster, contact.normal) * contact.normal, faster, sticks);
}

// Hair that comes out of a body goes its way through the step, beside that of its root, only in part, so that no point of it is faster than
// RECOVERY: all frames turn by that part.
fn crawl(strand: Strand, rod: RodStrand) {
    let root = rod_points[strand.first_point].travel;
    var far = 0.0;
    for (var k = 0u; k < strand.points; k++) { far = max(far, distance(rod_points[strand.first_point + k].travel, root)); }
    let part = min(1.0, RECOVERY * params.step / far);
    var travel = root;
    for (var k = 0u; k < strand.points - 1u; k++) {
        let p = strand.first_point + k;
        let j = strand.first_segment + k;
        let now = rod_segments[j];
        let chord = (rod_points[p + 1u].start.xyz - rod_points[p].start.xyz) + (rod_points[p + 1u].remainder - rod_points[p].remainder);
        let turn = rotation(part * rotation_vector(now.turn));
        let frame = normalize(product(turn, now.start));
        let strain = rotate(turn, rotate(conjugate(now.turn), now.strain));
        travel += segments[j].rest_length * tangent(frame) + strain - chord;
        rod_segments[j].turn = turn;
        rod_segments[j].frame = frame;
        rod_segments[j].strain = strain;
        rod_points[p + 1u].travel = travel;
    }
}

// A strand that nothing holds keeps its momentum to rounding. What is left of the way to a tip that is held is spread over the points.
fn finish(strand: Strand, rod: RodStrand, touches: bool) {
    let last = strand.first_point + strand.points - 1u;
    var shift = vec3f(0.0);    // m, of all points,
    var spread = vec3f(0.0);   // and of the tip
    if (strand.joints & TIP_HELD) != 0u { spread = rod_points[last].free - rod_points[last].travel; }
    if (strand.joints & (ROOT_HELD | TIP_HELD)) == 0u && !touches && rod.pin >= strand.points {
        var momentum = vec4f(0.0);
        for (var p = strand.first_point; p <= last; p++) {
            momentum += vec4f(rod_points[p].free - rod_points[p].travel, 1.0) / rod_points[p].reply;
        }
        shift = momentum.xyz / momentum.w;
    }
    for (var k = 0u; k < strand.points; k++) {
        let point = rod_points[strand.first_point + k];
        if (point.pinned != 0u) & (rod.state == SOLVED) {
            rod_points[strand.first_point + k].pin_force += PIN / point.reply * (point.travel - point.pin);
        }
        rod_points[strand.first_point + k].travel += shift + f32(k) / f32(strand.points - 1u) * spread;
    }
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let s = invocation(id, groups);
    if s >= params.strands { return; }
    var rod = rod_strands[s];
    if rod.state != FREE || rod.newton == params.newton_steps { return; }
    let strand = rod.strand;
    var now = Touch();
    if rod.newton == 0u { now = touch(strand, rod, true, false); }
    // A step takes two eliminations where the strand is pinned: the first finds the force that holds it.
    let first = select(1u, 0u, rod.pin < strand.points);
    for (var part = 0u; part < params.newton_part && rod.newton < params.newton_steps; part++) {
        var eliminated = Eliminated();
        for (var elimination = first; elimination < 2u; elimination++) {
            eliminated = eliminate(strand, rod, eliminated.pin_force);
        }
        var step = 1.0;
        if first == 0u { step = part_of(strand, eliminated.root_move); }
        var most = substitute(strand, rod, eliminated.root_move, step);
        rod.pin_force += step * eliminated.pin_force;
        if first == 0u {
            let pinned = rod_points[strand.first_point + rod.pin];
            most = max(most, length(pinned.travel - pinned.pin) / strand.length);
        }
        if rod.newton == 0u { rod.settled = max(SETTLED, RELATIVE * most); }
        rod.newton++;
        now = touch(strand, rod, false, false);
        if most < rod.settled && !now.changed {
            if !now.lags {
                rod.state = SOLVED;
                break;
            }
            now = touch(strand, rod, false, true);
        }
        rod.steep = u32(most > TURN || (now.touches && (now.changed || most > UNEASY)));
    }
    if rod.state == SOLVED || rod.newton == params.newton_steps {
        if BODIES && rod.comes_out != 0u { crawl(strand, rod); }
        finish(strand, rod, now.touches);
        if BODIES && rod.meets != 0u { leave(strand, rod, rod.state == SOLVED); }
    }
    rod_strands[s] = rod;
}
