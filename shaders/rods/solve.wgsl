// Newton steps on the incremental potential of each strand, each solved exactly in linear time.
//
//   Phi = sum_i |x_i - free_i|^2/(2 W_i) + sum_k 4 J_k (1 - |p_w|) + sum_k 1/2 eps^T alpha_s^-1 eps + sum_joints 1/2 C^T alpha_b^-1 C
//   p = turn conj(free turn),  eps = R^T u/l,  C = Im(conj(q_(k-1)) q_k) - s Im(rest),  J = 1/W of a frame
//
// The unknowns are frames and strains u; points follow from them, x_(k+1) = x_k + l d3 + u, so that a strand is whole at every iterate:
//
//   dx_(k+1) = dx_k + theta_k x r_k + e_k,   theta_k = theta_(k-1) + phi_k,   r = l d3 + u
//
// Tip to root, what lies beyond a point acts on it as an articulated body (`common/articulated`); root to tip, turns and strains follow. The
// Hessian is Gauss-Newton's, and a frame under tension resists turning off the pull: it is positive definite, so that Phi falls along theta.
//
// One invocation per strand, until frames, strains and a held tip have settled.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, status::frozen, integration::response, pi::PI,
    quaternion::{product, conjugate, rotate, rotation, tangent, matrix, turned_by},
    symmetric::{applied, applied_to_columns, cross_dyad, inverse_of, plus, twice_symmetric},
    articulated::{Answer, Beyond, ONE, Spring, crossing, joint, spring, swapped, through},
    rod::{Strand, Segment, RodStrand, RodPoint, RodSegment, FREE, SOLVED, ROOT_JOINT, TIP_JOINT, ROOT_HELD, TIP_HELD, WHOLE, TURN, clamped},
};

// How a segment answers to the move v of its first point and the turn w of the frame before: phi and e.
struct Factor {
    bend: Answer,
    stretch: Answer,
}

@group(0) @binding(2) var<storage, read>       strands:      array<Strand>;
@group(0) @binding(3) var<storage, read>       segments:     array<Segment>;
@group(0) @binding(4) var<storage, read_write> rod_strands:  array<RodStrand>;
@group(0) @binding(5) var<storage, read_write> rod_points:   array<RodPoint>;
@group(0) @binding(6) var<storage, read_write> rod_segments: array<RodSegment>;
@group(0) @binding(7) var<storage, read_write> factors:      array<Factor>;

const SETTLED: f32 = 1e-3;    // rad, of a frame, and strain, in a Newton step that is the last,
const RELATIVE: f32 = 1e-2;   // or this part of the first Newton step's

// What elimination leaves.
struct Eliminated {
    root_move: vec3f,   // of the root's point, 0 where it is held
    tip_force: vec3f,   // change of the force that holds the tip
}

// Tip to root, under a force on a held tip and a change of it, which counts for no tension. `steep` takes all of a segment's force for its
// tension, which is more than there is.
fn eliminate(strand: Strand, rod: RodStrand, steep: bool, tip_force: vec3f, change: vec3f) -> Eliminated {
    let last = strand.points - 2u;
    let holds = (strand.joints & TIP_HELD) != 0u;
    var frame = rod_segments[strand.first_segment + last].frame;
    var beyond = Beyond();
    beyond.force = tip_force + change;
    beyond.held = ONE;
    if (strand.joints & TIP_JOINT) != 0u {
        let tip = joint(frame, strand.tip_frame, strand.tip_rest_rotation, strand.tip_compliance);
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
        let stretched = through(beyond, spring((1.0 / l) * axes, segment.stretch_compliance, (now.strain * axes) / l), holds);
        beyond = stretched.beyond;

        // To the segment's first point.
        let arm = l * axes[2] + now.strain;
        let swung = applied_to_columns(beyond.own, -1.0 * crossing(arm, ONE));
        beyond.other = plus(beyond.other, twice_symmetric(crossing(arm, beyond.cross + 0.5 * swung)));
        beyond.cross += swung;
        beyond.other_force += cross(arm, beyond.force);
        beyond.other_held += crossing(arm, beyond.held);

        // The frame: its inertia, and the pull that it resists turning off.
        let inertia = 1.0 / (response(params.damping, now.scheme) * segment.inverse_inertia);
        let off = product(now.turn, conjugate(now.free));
        let force = beyond.force - beyond.held * change;
        let pull = select(max(0.0, -dot(force, axes[2])), length(force), steep);
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
        let floats = through(beyond, Spring(), holds);
        root_move = -floats.answer.constant;
        beyond = floats.beyond;
    }
    if !holds { return Eliminated(root_move, vec3f(0.0)); }
    let tip = rod_points[strand.first_point + last + 1u];
    return Eliminated(root_move, change + applied(inverse_of(beyond.give), tip.travel - tip.free - beyond.given));
}

// Root to tip. Returns the largest turn of a frame [rad] or change of a strain.
fn substitute(strand: Strand, root_move: vec3f) -> f32 {
    var most = 0.0;
    var shift = root_move;     // v, to first order
    var turn = vec3f(0.0);     // w
    var travel_before = rod_points[strand.first_point].travel;
    var travel = travel_before + root_move;
    rod_points[strand.first_point].travel = travel;
    for (var k = 0u; k < strand.points - 1u; k++) {
        let j = strand.first_segment + k;
        let p = strand.first_point + k + 1u;
        let factor = factors[j];
        let now = rod_segments[j];
        let l = segments[j].rest_length;
        let along = l * tangent(now.frame);
        turn -= clamped(factor.bend.constant + factor.bend.by_own * turn + factor.bend.by_other * shift, TURN);
        turn = clamped(turn, PI);
        shift += cross(turn, along + now.strain);
        let stretch = factor.stretch.constant + factor.stretch.by_other * turn + factor.stretch.by_own * shift;
        shift -= stretch;
        let strain = clamped(now.strain - stretch, WHOLE * l);
        most = max(most, max(length(turn), length(strain - now.strain) / l));

        let rotated = rotation(turn);
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

// A strand that nothing holds keeps its momentum to rounding. What is left of the way to a tip that is held is spread over the points.
fn finish(strand: Strand) {
    let last = strand.first_point + strand.points - 1u;
    var shift = vec3f(0.0);    // m, of all points,
    var spread = vec3f(0.0);   // and of the tip
    if (strand.joints & TIP_HELD) != 0u { spread = rod_points[last].free - rod_points[last].travel; }
    if (strand.joints & (ROOT_HELD | TIP_HELD)) == 0u {
        var momentum = vec4f(0.0);
        for (var p = strand.first_point; p <= last; p++) {
            momentum += vec4f(rod_points[p].free - rod_points[p].travel, 1.0) / rod_points[p].reply;
        }
        shift = momentum.xyz / momentum.w;
    }
    for (var k = 0u; k < strand.points; k++) {
        rod_points[strand.first_point + k].travel += shift + f32(k) / f32(strand.points - 1u) * spread;
    }
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let s = invocation(id, groups);
    if (s >= params.strands) | frozen() { return; }
    let rod = rod_strands[s];
    if rod.state != FREE { return; }
    let strand = strands[s];
    // A step takes two eliminations where the tip is held: the first finds the force that holds it.
    let first = select(1u, 0u, (strand.joints & TIP_HELD) != 0u);
    var steep = false;
    var settled = SETTLED;
    var tip_force = rod.tip_force;
    for (var step = 0u; step < params.newton_steps; step++) {
        var eliminated = Eliminated();
        for (var elimination = first; elimination < 2u; elimination++) {
            eliminated = eliminate(strand, rod, steep, tip_force, eliminated.tip_force);
        }
        var most = substitute(strand, eliminated.root_move);
        // Where turns were cut, the force would close a gap that the cut left, and wind up.
        if most <= TURN { tip_force += eliminated.tip_force; }
        let tip = rod_points[strand.first_point + strand.points - 1u];
        if first == 0u { most = max(most, length(tip.travel - tip.free) / strand.length); }
        if step == 0u { settled = max(SETTLED, RELATIVE * most); }
        if most < settled {
            rod_strands[s].state = SOLVED;
            break;
        }
        steep = most > TURN;
    }
    rod_strands[s].tip_force = tip_force;
    finish(strand);
}
