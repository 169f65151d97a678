// Newton steps on the incremental potential of each strand, each solved exactly in linear time.
//
//   Phi = sum_i |x_i - free_i|^2/(2 W_i) + sum_k 4 J_k (1 - |p_w|) + sum_k 1/2 eps^T alpha_s^-1 eps + sum_joints 1/2 C^T alpha_b^-1 C
//   p = turn conj(free turn),  eps = R^T u/l,  C = Im(conj(q_(k-1)) q_k) - s Im(rest),  J = 1/W of a frame
//
// The unknowns are frames and strains u; points follow from them, x_(k+1) = x_k + l d3 + u, so that a strand is whole at every iterate:
//
//   dx_(k+1) = dx_k + theta_k x r_k + e_k,   theta_k = theta_(k-1) + phi_k,   r = l d3 + u
//
// Tip to root, what lies beyond a point acts on it as a stiffness A and a force b (the articulated body of Featherstone 2008, Rigid Body
// Dynamics Algorithms, ch. 7); a spring of stiffness K that it hangs on leaves A' = K (A + K)^-1 A. Nothing is subtracted that is nearly
// equal, so that f32 suffices. Root to tip, turns and strains follow. The Hessian is Gauss-Newton's, and a frame under tension resists
// turning off the pull: it is positive definite, and theta a direction in which Phi falls.
//
// One invocation per strand, until no frame turns and no segment stretches by more than SETTLED. A held point is one of infinite mass.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, status::frozen, integration::response,
    quaternion::{product, conjugate, rotate, rotation, tangent, matrix, turned_by},
    symmetric::{Symmetric, applied, applied_to_columns, cross_dyad, dyad, full, inverse_of, minus, plus, symmetric_product, twice_symmetric},
    rod::{Strand, Segment, RodStrand, RodPoint, RodSegment, FREE, SOLVED, ROOT_JOINT, TIP_JOINT, ROOT_HELD, TIP_HELD, WHOLE, TURN, clamped},
};

// How a segment answers to what its first point does: of its joint phi = -(bend + bend_turn w + bend_move v), w and v the turn before it
// and the move of its first point; of itself e = -(stretch + stretch_turn theta + stretch_move (v + theta x r)).
struct Factor {
    bend_turn: mat3x3f,
    bend_move: mat3x3f,
    stretch_turn: mat3x3f,
    stretch_move: mat3x3f,
    bend: vec3f,
    stretch: vec3f,
}

@group(0) @binding(2) var<storage, read>       strands:      array<Strand>;
@group(0) @binding(3) var<storage, read>       segments:     array<Segment>;
@group(0) @binding(4) var<storage, read_write> rod_strands:  array<RodStrand>;
@group(0) @binding(5) var<storage, read_write> rod_points:   array<RodPoint>;
@group(0) @binding(6) var<storage, read_write> rod_segments: array<RodSegment>;
@group(0) @binding(7) var<storage, read_write> factors:      array<Factor>;

const SETTLED: f32 = 1e-3;    // rad, of a frame, and strain, in a Newton step that is the last
const STIFFEST: f32 = 1e-6;   // 1/(N m): a compliance below it counts as it, 0 among them
const HALF_TURN: f32 = 3.1415927;
const ONE = mat3x3f(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 1.0, 0.0), vec3f(0.0, 0.0, 1.0));

// A spring: its stiffness, and the force or moment by which it resists, in world axes.
struct Spring {
    stiffness: Symmetric,
    force: vec3f,
}

// sum_i k_i c_i c_i^T over the columns of m, and sum_i k_i gap_i c_i.
fn spring(m: mat3x3f, compliance: vec3f, gap: vec3f) -> Spring {
    let k = 1.0 / max(compliance, vec3f(STIFFEST));
    return Spring(plus(plus(dyad(k.x, m[0]), dyad(k.y, m[1])), dyad(k.z, m[2])), m * (k * gap));
}

// The joint between two frames, for turns of the second.
fn joint(before: vec4f, after: vec4f, rest: vec4f, compliance: vec3f) -> Spring {
    let p = product(conjugate(before), after);
    let gap = p.xyz - select(-rest.xyz, rest.xyz, dot(p, rest) >= 0.0);
    let skew = mat3x3f(vec3f(0.0, p.z, -p.y), vec3f(-p.z, 0.0, p.x), vec3f(p.y, -p.x, 0.0));
    return spring(0.5 * matrix(before) * (p.w * ONE + skew), compliance, gap);
}

// Tip to root. Returns the move of the root's point, 0 where it is held. `steep` takes all of a segment's force for its tension, which is
// more than there is.
fn eliminate(strand: Strand, rod: RodStrand, steep: bool) -> vec3f {
    let last = strand.points - 2u;
    var turn_turn = Symmetric();     // A: moments by turns,
    var move_turn = mat3x3f();       // forces by turns,
    var move_move = Symmetric();     // forces by moves
    var moment = vec3f(0.0);         // b
    var force = vec3f(0.0);
    var frame = rod_segments[strand.first_segment + last].frame;
    if (strand.joints & TIP_JOINT) != 0u {
        let tip = joint(frame, strand.tip_frame, strand.tip_rest_rotation, strand.tip_compliance);
        turn_turn = tip.stiffness;
        moment = -tip.force;
    }
    for (var done = 0u; done <= last; done++) {
        let k = last - done;
        let j = strand.first_segment + k;
        let point = rod_points[strand.first_point + k + 1u];
        let segment = segments[j];
        let now = rod_segments[j];
        let axes = matrix(frame);
        let l = segment.rest_length;

        // The point at the segment's end.
        let held = point.reply == 0.0;
        let off = point.travel - point.free;
        let mass = select(1.0 / point.reply, 0.0, held);
        move_move.diagonal += vec3f(mass);
        force += mass * off;

        // Through the segment's own stretch.
        let own = spring((1.0 / l) * axes, segment.stretch_compliance, (now.strain * axes) / l);
        let e = inverse_of(plus(move_move, own.stiffness));
        var stretch = applied(e, force + own.force);
        var stretch_turn = applied_to_columns(e, move_turn);
        var stretch_move = applied_to_columns(e, full(move_move));
        var passed = force - applied(move_move, stretch);
        if held {
            stretch = off;
            stretch_turn = mat3x3f();
            stretch_move = ONE;
            passed = applied(own.stiffness, off) - own.force;
        }
        turn_turn = minus(turn_turn, symmetric_product(move_turn, stretch_turn));
        moment -= stretch * move_turn;
        force = passed;
        move_turn = applied_to_columns(own.stiffness, stretch_turn);
        move_move = symmetric_product(full(own.stiffness), stretch_move);

        // To the segment's first point.
        let arm = l * axes[2] + now.strain;
        let swung = applied_to_columns(move_move, mat3x3f(cross(ONE[0], arm), cross(ONE[1], arm), cross(ONE[2], arm)));
        turn_turn = plus(turn_turn, twice_symmetric(crossing(arm, move_turn + 0.5 * swung)));
        move_turn += swung;
        moment += cross(arm, force);

        // The frame itself: its inertia, and the pull that it resists turning off.
        let inertia = 1.0 / (response(params.damping, now.scheme) * segment.inverse_inertia);
        let p = product(now.turn, conjugate(now.free));
        let pull = select(max(0.0, -dot(force, axes[2])), length(force), steep);
        turn_turn = plus(turn_turn, cross_dyad(l * pull, axes[2]));
        turn_turn.diagonal += vec3f(inertia);
        moment += select(-2.0, 2.0, p.w >= 0.0) * inertia * p.xyz;

        // Through the joint before it.
        var before = rod.root_frame;
        if k > 0u { before = rod_segments[j - 1u].frame; }
        var bends = joint(before, frame, segment.rest_rotation, segment.bend_compliance);
        if k == 0u && (strand.joints & ROOT_JOINT) == 0u { bends = Spring(); }
        let f = inverse_of(plus(turn_turn, bends.stiffness));
        let bend = applied(f, moment + bends.force);
        let turn_move = transpose(move_turn);
        let bend_turn = applied_to_columns(f, full(turn_turn));
        let bend_move = applied_to_columns(f, turn_move);
        factors[j] = Factor(bend_turn, bend_move, stretch_turn, stretch_move, bend, stretch);
        moment -= applied(turn_turn, bend);
        force -= move_turn * bend;
        move_move = minus(move_move, symmetric_product(turn_move, bend_move));
        move_turn = transpose(applied_to_columns(bends.stiffness, bend_move));
        turn_turn = symmetric_product(full(bends.stiffness), bend_turn);
        frame = before;
    }
    let root = rod_points[strand.first_point];
    if root.reply == 0.0 { return vec3f(0.0); }
    let mass = 1.0 / root.reply;
    let all = inverse_of(plus(move_move, Symmetric(vec3f(mass), vec3f(0.0))));
    return -applied(all, force + mass * (root.travel - root.free));
}

fn crossing(v: vec3f, m: mat3x3f) -> mat3x3f {
    return mat3x3f(cross(v, m[0]), cross(v, m[1]), cross(v, m[2]));
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
        let arm = l * tangent(now.frame) + now.strain;
        turn = clamped(turn - clamped(factor.bend + factor.bend_turn * turn + factor.bend_move * shift, TURN), HALF_TURN);
        shift += cross(turn, arm);
        let stretch = -(factor.stretch + factor.stretch_turn * turn + factor.stretch_move * shift);
        shift += stretch;
        most = max(most, max(length(turn), length(stretch) / l));

        let rotated = rotation(turn);
        let strain = clamped(now.strain + stretch, max(WHOLE * l, length(now.strain)));
        let along = rod_points[p].travel - travel_before;
        travel_before = rod_points[p].travel;
        travel += along + turned_by(rotated, l * tangent(now.frame) + strain) + (strain - now.strain);
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
    if (strand.joints & TIP_HELD) != 0u {
        let gap = rod_points[last].travel - rod_points[last].free;
        for (var k = 1u; k < strand.points - 1u; k++) {
            rod_points[strand.first_point + k].travel -= f32(k) / f32(strand.points - 1u) * gap;
        }
        rod_points[last].travel = rod_points[last].free;
    } else if (strand.joints & ROOT_HELD) == 0u {
        var momentum = vec3f(0.0);
        var mass = 0.0;
        for (var p = strand.first_point; p <= last; p++) {
            let point = rod_points[p];
            momentum += (point.travel - point.free) / point.reply;
            mass += 1.0 / point.reply;
        }
        for (var p = strand.first_point; p <= last; p++) { rod_points[p].travel -= momentum / mass; }
    }
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let s = invocation(id, groups);
    if (s >= params.strands) | frozen() { return; }
    let rod = rod_strands[s];
    if rod.state != FREE { return; }
    let strand = strands[s];
    var steep = false;
    for (var step = 0u; step < params.newton_steps; step++) {
        let most = substitute(strand, eliminate(strand, rod, steep));
        if most < SETTLED {
            rod_strands[s].state = SOLVED;
            break;
        }
        steep = most > TURN;
    }
    finish(strand);
}
