// Newton steps on the incremental potential of each strand, each solved exactly in linear time.
//
//   Phi = sum_i |x_i - free_i|^2/(2 W_i) + sum_k 4 J_k (1 - |p_w|) + sum_k 1/2 eps^T alpha_s^-1 eps
//       + sum_joints 1/2 C^T alpha_b^-1 C
//         + sum_contacts 1/2 k (phi + D)^2
//   p = turn conj(free turn),  eps = R^T u/l,  C = Im(conj(q_(k-1)) q_k) - s Im(rest),  J = 1/W of a frame
//
// The unknowns are frames and strains u; points follow from them, x_(k+1) = x_k + l d3 + u, so that a strand is whole
// at every iterate:
//
//   dx_(k+1) = dx_k + theta_k x r_k + e_k,   theta_k = theta_(k-1) + phi_k,   r = l d3 + u
//
// Tip to root, the strand beyond a point acts on it as an articulated body (`common/articulated`); root to tip, turns
// and strains follow. The Hessian is Gauss-Newton's, and a frame under tension resists turning off the pull: it is
// positive definite, so that Phi falls along theta. Contacts with bodies are springs on points and segments
// (`common/contact`).
//
// One invocation per strand, until frames, strains, pins and contacts have settled. It runs on in a frozen step, in
// which nothing that it writes is committed: whether a step is frozen stands in a ninth buffer, and WebGPU's default
// allows eight.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, integration::response, pi::PI,
    quaternion::{product, conjugate, rotate, rotation, rotation_vector, tangent, matrix, turned_by},
    symmetric::{applied, applied_to_columns, cross_dyad, inverse_of, plus, twice_symmetric},
    articulated::{Answer, Beyond, ONE, Spring, crossing, joint, spring, swapped, through}, body::BODIES,
    contact::{RECOVERY, UNEASY},
    touch::{Touch, rod_points, segments, foresee, foresee_segment, leave, push_point, push_segment, touch},
    rod::{
        Strand, RodStrand, RodPoint, RodSegment, PINS, LOOSE, FREE, SOLVED, ROOT_JOINT, TIP_JOINT, ROOT_HELD, TIP_HELD,
        WHOLE, TURN, clamped,
    },
};

@group(0) @binding(2) var<storage, read_write> factors:      array<Factor>;
@group(0) @binding(4) var<storage, read_write> rod_strands:  array<RodStrand>;
@group(0) @binding(6) var<storage, read_write> rod_segments: array<RodSegment>;

// How a segment answers to the move v of its first point and the turn w of the frame before: phi and e.
struct Factor {
    bend: Answer,
    stretch: Answer,
}

const PIN: f32 = 1e4;         // stiffness of a pin, over that of its point's inertia: 1/W
const HELD_TURN: f32 = 0.5;   // rad, of a frame in a Newton step of a strand that is held beside its root
const UNCUT: f32 = 1e6;       // rad
const SETTLED: f32 = 1e-3;    // rad, of a frame, and strain, in a Newton step that is the last,
const RELATIVE: f32 = 1e-2;   // or this part of the first Newton step's

// Result of the elimination.
struct Eliminated {
    root_move: vec3f,   // of the root's point, 0 where it is held
    pin_force: vec3f,   // change of the force at the pin
}

// Adds a pin nearer to the root than the strand's last: a spring, and the force that it had in the step before.
fn pin_point(beyond: Beyond, point: RodPoint) -> Beyond {
    var sum = beyond;
    if !PINS || point.pinned == 0u { return sum; }
    let k = PIN / point.effective_inverse_mass;
    sum.own.diagonal += vec3f(k);
    sum.force += k * (point.displacement - point.pin) + point.pin_force;
    return sum;
}

// Tip to root, under the force that holds the strand at its pin and a change of it, which counts for no tension.
// `steep` takes all of a segment's force for its tension, which is more than there is.
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
        let mass = select(1.0 / point.effective_inverse_mass, 0.0, point.effective_inverse_mass == 0.0);
        beyond.own.diagonal += vec3f(mass);
        beyond.force += mass * (point.displacement - point.free);
        beyond = push_point(pin_point(beyond, point), rod, strand.first_point + k + 1u);
        if PINS && k + 1u == rod.pin {
            holds = true;
            beyond.held = ONE;
            beyond.force += rod.pin_force + change;
        }
        let stretched = through(beyond, spring((1.0 / l) * axes, segment.stretch_compliance, (now.strain * axes) / l),
            holds);
        beyond = stretched.beyond;

        // To the segment's first point.
        let arm = l * axes[2] + now.strain;
        let swung = applied_to_columns(beyond.own, -1.0 * crossing(arm, ONE));
        beyond.other = plus(beyond.other, twice_symmetric(crossing(arm, beyond.cross + 0.5 * swung)));
        beyond.cross += swung;
        beyond.other_force += cross(arm, beyond.force);
        beyond.other_held += crossing(arm, beyond.held);
        beyond = push_segment(beyond, rod, strand.first_point + k, j, arm);

        // The frame: its inertia, and the geometric stiffness of the segment's tension, or of the whole force if `steep`.
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
    if LOOSE && root.effective_inverse_mass > 0.0 {
        beyond.own.diagonal += vec3f(1.0 / root.effective_inverse_mass);
        beyond.force += (root.displacement - root.free) / root.effective_inverse_mass;
        beyond = push_point(pin_point(beyond, root), rod, strand.first_point);
        let floats = through(beyond, Spring(), holds);
        root_move = -floats.answer.constant;
        beyond = floats.beyond;
    }
    if !holds { return Eliminated(root_move, vec3f(0.0)); }
    let pinned = rod_points[strand.first_point + rod.pin];
    return Eliminated(root_move,
        change + applied(inverse_of(beyond.give), pinned.displacement - pinned.pin - beyond.given));
}

// How a joint turns less, and a segment gives, in the Newton step, by the turn before and the move of the segment's
// first point.
fn bend_of(factor: Factor, turn: vec3f, shift: vec3f) -> vec3f {
    return factor.bend.constant + factor.bend.by_own * turn + factor.bend.by_other * shift;
}
fn stretch_of(factor: Factor, turn: vec3f, shift: vec3f) -> vec3f {
    return factor.stretch.constant + factor.stretch.by_other * turn + factor.stretch.by_own * shift;
}

// Part of the Newton step that a strand takes that is held beside its root: joints that are cut by themselves would
// lead the pin's point away.
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
    var shift = root_move;     // dx of the segment's first point, to first order
    var turn = vec3f(0.0);     // theta of the frame before
    var travel_before = rod_points[strand.first_point].displacement;
    var displacement = travel_before + part * root_move;
    rod_points[strand.first_point].displacement = displacement;
    foresee(rod, strand.first_point, rod_points[strand.first_point].effective_inverse_mass, root_move);
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
        foresee(rod, p, rod_points[p].effective_inverse_mass, shift);
        let strain = clamped(now.strain - part * stretch, WHOLE * l);
        most = max(most, max(length(turn), length(strain - now.strain) / l));

        let rotated = rotation(part * turn);
        let chord = rod_points[p].displacement - travel_before;
        travel_before = rod_points[p].displacement;
        displacement += chord + turned_by(rotated, along + strain) + (strain - now.strain);
        rod_points[p].displacement = displacement;
        let turned = normalize(product(rotated, now.turn));
        rod_segments[j].turn = turned;
        rod_segments[j].frame = normalize(product(turned, now.start));
        rod_segments[j].strain = rotate(rotated, strain);
    }
    return most;
}

// Hair that comes out of a body goes its way through the step, beside that of its root, only in part, so that no point
// of it is faster than RECOVERY: all frames turn by that part.
fn crawl(strand: Strand, rod: RodStrand) {
    let root = rod_points[strand.first_point].displacement;
    var far = 0.0;
    for (var k = 0u; k < strand.points; k++) {
        far = max(far, distance(rod_points[strand.first_point + k].displacement, root));
    }
    let part = min(1.0, RECOVERY * params.step / far);
    var displacement = root;
    for (var k = 0u; k < strand.points - 1u; k++) {
        let p = strand.first_point + k;
        let j = strand.first_segment + k;
        let now = rod_segments[j];
        let chord = (rod_points[p + 1u].start.xyz - rod_points[p].start.xyz)
            + (rod_points[p + 1u].remainder - rod_points[p].remainder);
        let turn = rotation(part * rotation_vector(now.turn));
        let frame = normalize(product(turn, now.start));
        let strain = rotate(turn, rotate(conjugate(now.turn), now.strain));
        displacement += segments[j].rest_length * tangent(frame) + strain - chord;
        rod_segments[j].turn = turn;
        rod_segments[j].frame = frame;
        rod_segments[j].strain = strain;
        rod_points[p + 1u].displacement = displacement;
    }
}

// A strand without clamp, pin or contact keeps its momentum to rounding. The gap that the solve leaves to a held tip is
// spread over the points.
fn finish(strand: Strand, rod: RodStrand, touches: bool) {
    if !(PINS || LOOSE) { return; }
    let last = strand.first_point + strand.points - 1u;
    var shift = vec3f(0.0);    // m, of all points,
    var spread = vec3f(0.0);   // and of the tip
    if PINS && (strand.joints & TIP_HELD) != 0u { spread = rod_points[last].free - rod_points[last].displacement; }
    if LOOSE && (strand.joints & (ROOT_HELD | TIP_HELD)) == 0u && !touches && rod.pin >= strand.points {
        var momentum = vec4f(0.0);
        for (var p = strand.first_point; p <= last; p++) {
            momentum += vec4f(rod_points[p].free - rod_points[p].displacement, 1.0)
                / rod_points[p].effective_inverse_mass;
        }
        shift = momentum.xyz / momentum.w;
    }
    for (var k = 0u; k < strand.points; k++) {
        let point = rod_points[strand.first_point + k];
        if PINS && point.pinned != 0u && rod.state == SOLVED {
            rod_points[strand.first_point + k].pin_force += PIN / point.effective_inverse_mass
                * (point.displacement - point.pin);
        }
        rod_points[strand.first_point + k].displacement += shift + f32(k) / f32(strand.points - 1u) * spread;
    }
}

// Takes a Newton step. Returns the largest turn of a frame [rad], change of a strain, or part of the strand's length
// that its pin is off.
fn newton_step(strand: Strand, rod: ptr<function, RodStrand>, is_pinned: bool) -> f32 {
    // A step takes two eliminations where the strand is pinned: the first finds the force that holds it.
    var eliminated = Eliminated();
    for (var left = select(1u, 2u, is_pinned); left > 0u; left--) {
        eliminated = eliminate(strand, *rod, eliminated.pin_force);
    }
    var step = 1.0;
    if is_pinned { step = part_of(strand, eliminated.root_move); }
    var most = substitute(strand, *rod, eliminated.root_move, step);
    (*rod).pin_force += step * eliminated.pin_force;
    if is_pinned {
        let pinned = rod_points[strand.first_point + (*rod).pin];
        most = max(most, length(pinned.displacement - pinned.pin) / strand.length);
    }
    if (*rod).newton == 0u { (*rod).settled = max(SETTLED, RELATIVE * most); }
    (*rod).newton++;
    return most;
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let s = invocation(id, groups);
    if s >= params.strands { return; }
    var rod = rod_strands[s];
    if rod.state != FREE || rod.newton == params.newton_steps { return; }
    let strand = rod.strand;
    let is_pinned = PINS && rod.pin < strand.points;
    var now = Touch();
    var most = 0.0;
    // In front of a step's first Newton step contacts are found.
    var starts = rod.newton == 0u;
    for (var left = params.newton_part; starts || (left > 0u && rod.newton < params.newton_steps);) {
        if !starts {
            most = newton_step(strand, &rod, is_pinned);
            left--;
        }
        // A step that settles renews the forces of contacts that lag, once. The call stands here once, as drivers
        // inline it.
        var settles = false;
        var renews = false;
        loop {
            now = touch(strand, rod, starts, renews);
            if renews { break; }
            settles = !starts && most < rod.settled && !now.changed;
            renews = settles && now.lags;
            if !renews { break; }
        }
        if settles && !renews {
            rod.state = SOLVED;
            break;
        }
        rod.steep = u32(!starts && (most > TURN || (now.touches && (now.changed || most > UNEASY))));
        starts = false;
    }
    if rod.state == SOLVED || rod.newton == params.newton_steps {
        if BODIES && rod.comes_out != 0u { crawl(strand, rod); }
        finish(strand, rod, now.touches);
        if BODIES && rod.meets != 0u { leave(strand, rod, rod.state == SOLVED); }
    }
    rod_strands[s].state = rod.state;
    rod_strands[s].newton = rod.newton;
    rod_strands[s].steep = rod.steep;
    rod_strands[s].settled = rod.settled;
    rod_strands[s].pin_force = rod.pin_force;
}
