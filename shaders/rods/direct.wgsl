// Newton steps of the dual system of each strand, each solved directly in linear time.
//
//   joint k:    C = Im(conj(q_(k-1)) q_k) - s Im(rest),  dC = A_k (theta_k - theta_(k-1)),  A = 1/2 (p_w I - [p_v]x) R_(k-1)^T
//   segment k:  C = (x_(k+1) - x_k)/l - d3(q_k),         dC = (dx_(k+1) - dx_k)/l + [d3]x theta_k
//   (J W J^T + alpha) dmu = -(C + alpha mu + J (free + W J^T mu - now)),  move = free + W J^T mu
//
// mu are the generalised forces [N m] that hold the rod, W = w h^2/(1 + c h); alpha may be 0. Written in moves: nothing is
// the small difference of two positions. A frame under tension T = -d3.mu resists turning off the pull (the derivative of
// J^T mu that matters at long steps): W = w (I - d3 d3^T)/(1 + w T) + w d3 d3^T, and so much less of its excess. A joint and
// the segment after it are a block of 3 + 3 rows; blocks meet their neighbours only,
//
//   D_k = [F G; G^T H],   above the diagonal O_k = [P 0; Q -s I]   (segment k and joint k + 1 share a frame, or a point)
//
// so that root to tip  D_k -= O_(k-1)^T U_(k-1), U = D^-1 O, y = D^-1 r  and tip to root  dmu_k = y_k - D_k^-1 O_k dmu_(k+1).
// One invocation per strand, done when its segments fit.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, status::{frozen, count, finite, QUIET_STEP},
    quaternion::{product, conjugate, rotation, tangent, matrix}, integration::response, pressure::times,
    rod::{Strand, Segment, RodStrand, RodPoint, RodSegment, FREE, SOLVED, ROOT_JOINT, TIP_JOINT},
};

// D^-1 and y of a block, D^-1 = [1 -T; 0 1] [F^-1 0; 0 S^-1] [1 0; -T^T 1] with T = F^-1 G and S = H - G^T T.
struct Factor {
    f: Symmetric,     // F^-1
    s: Symmetric,     // S^-1
    t: mat3x3f,
    bend: vec3f,      // y
    stretch: vec3f,
}

struct Symmetric {
    diagonal: vec3f,
    off_diagonal: vec3f,   // yz, zx, xy
}

// U and y of a block.
struct Carried {
    bend_bend: mat3x3f,
    bend_stretch: mat3x3f,
    stretch_bend: mat3x3f,
    stretch_stretch: mat3x3f,
    bend: vec3f,
    stretch: vec3f,
}

@group(0) @binding(2) var<storage, read>       strands:      array<Strand>;
@group(0) @binding(3) var<storage, read>       segments:     array<Segment>;
@group(0) @binding(4) var<storage, read_write> rod_strands:  array<RodStrand>;
@group(0) @binding(5) var<storage, read_write> rod_points:   array<RodPoint>;
@group(0) @binding(6) var<storage, read_write> rod_segments: array<RodSegment>;
@group(0) @binding(7) var<storage, read_write> factors:      array<Factor>;

const FITS: f32 = 1e-5;      // |C + alpha mu| of stretch-shear at which a strand is done
const HOPELESS: f32 = 1e30;  // that of one whose numbers are none any more
const QUIET: f32 = 1e-6;     // residual below which a strand need not be solved; see `quiet_below`
// Added to the diagonal of J W J^T, in parts of it: keeps the system within what f32 resolves where segments are stiff and
// short. Steps come out shorter by that much where they are the least certain; where a strand comes to rest stays the same.
const GIVE: f32 = 2e-7;
const ONE = mat3x3f(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 1.0, 0.0), vec3f(0.0, 0.0, 1.0));

// Newton steps of one dispatch. A text that reads copies of what it writes takes one.
@if(copies)
fn newton_steps() -> u32 {
    return 1u;
}
@if(!copies)
fn newton_steps() -> u32 {
    return params.newton_steps;
}

fn skew(v: vec3f) -> mat3x3f {
    return mat3x3f(vec3f(0.0, v.z, -v.y), vec3f(-v.z, 0.0, v.x), vec3f(v.y, -v.x, 0.0));
}

fn diagonal(v: vec3f) -> mat3x3f {
    return mat3x3f(vec3f(v.x, 0.0, 0.0), vec3f(0.0, v.y, 0.0), vec3f(0.0, 0.0, v.z));
}

fn symmetric(m: mat3x3f) -> Symmetric {
    return Symmetric(vec3f(m[0].x, m[1].y, m[2].z), vec3f(m[1].z, m[2].x, m[0].y));
}

// Inverse of a symmetric positive definite matrix, by the adjugate; scaled, so that the determinant stays in the range of f32.
fn inverse(m: mat3x3f) -> mat3x3f {
    let scale = 1.0 / (m[0].x + m[1].y + m[2].z);
    let a = scale * m;
    let c0 = cross(a[1], a[2]);
    let c1 = cross(a[2], a[0]);
    let c2 = cross(a[0], a[1]);
    return (scale / dot(a[0], c0)) * transpose(mat3x3f(c0, c1, c2));
}

// A joint between two frames.
struct Joint {
    gap: vec3f,            // C
    gradient: mat3x3f,     // A, 0 where nothing joins
    compliance: vec3f,
    moment: vec3f,
}

fn joint_between(before: vec4f, after: vec4f, rest: vec4f, compliance: vec3f, moment: vec3f) -> Joint {
    let p = product(conjugate(before), after);
    let gap = p.xyz - select(-rest.xyz, rest.xyz, dot(p, rest) >= 0.0);
    let gradient = 0.5 * (p.w * ONE - skew(p.xyz)) * transpose(matrix(before));
    return Joint(gap, gradient, compliance, moment);
}

// A joint where nothing joins: its rows of the system are 1 dmu = 0.
fn no_joint() -> Joint {
    return Joint(vec3f(0.0), mat3x3f(), vec3f(1.0), vec3f(0.0));
}

// Joint k of a strand, behind a frame; k = points - 1 is that of the tip, which no segment follows. `segment` and `now` are of
// the segment after it, or of the last one.
fn joint(strand: Strand, rod: RodStrand, k: u32, before: vec4f, segment: Segment, now: RodSegment) -> Joint {
    let tip = k == strand.points - 1u;
    let joins = select(select(0u, ROOT_JOINT, k == 0u), TIP_JOINT, tip);
    if (strand.joints & joins) != joins { return no_joint(); }
    return joint_between(
        before, select(now.frame, strand.tip_frame, tip), select(segment.rest_rotation, strand.tip_rest_rotation, tip),
        select(segment.bend_compliance, strand.tip_compliance, tip), select(now.moment, rod.tip_moment, tip),
    );
}

// C + alpha mu of a segment: from its chord, the matrix of its frame and the force on it.
fn stretch_gap(chord: vec3f, rest_length: f32, frame: mat3x3f, compliance: mat3x3f, force: vec3f) -> vec3f {
    return chord / rest_length - frame[2] + compliance * force;
}

// The compliance of a segment in the world.
fn in_world(frame: mat3x3f, compliance: vec3f) -> mat3x3f {
    return frame * diagonal(compliance) * transpose(frame);
}

// A segment, where it stands and what it weighs.
struct Link {
    tangent: vec3f,
    over_length: f32,      // 1/l
    gap: vec3f,            // C + alpha mu
    weight: f32,           // of its frame, w h^2/(1 + c h)
    yielding: f32,         // 1/(1 + weight T): to turns off the pull
    compliance: mat3x3f,   // world
    force: vec3f,          // world
    free: vec3f,           // turn
    turn: vec3f,
}

// The link of a segment, between points that have moved by `start` and `end`.
fn link(segment: Segment, now: RodSegment, scheme: u32, start: vec3f, end: vec3f) -> Link {
    let frame = matrix(now.frame);
    let compliance = in_world(frame, segment.stretch_compliance);
    let gap = stretch_gap(now.chord + end - start, segment.rest_length, frame, compliance, now.force);
    let weight = response(params.damping, scheme) * segment.inverse_inertia;
    let yielding = 1.0 / (1.0 + weight * max(0.0, -dot(frame[2], now.force)));
    return Link(
        frame[2], 1.0 / segment.rest_length, gap, weight, yielding, compliance, now.force, now.free, now.turn
    );
}

// A link beyond either end of a strand: weighs nothing, holds nothing. Its rows of the system are 1 dmu = 0.
fn no_link() -> Link {
    return Link(vec3f(0.0), 0.0, vec3f(0.0), 0.0, 1.0, ONE, vec3f(0.0), vec3f(0.0), vec3f(0.0));
}

// A point of a strand.
struct Node {
    travel: vec3f,
    free: vec3f,
    weight: f32,   // W
}

fn node(p: u32) -> Node {
    let point = rod_points[p];
    return Node(point.travel, point.free, point.reply);
}

// What the forces on a point, of the link before it and of that after it, still have to move it by.
fn point_excess(point: Node, before: Link, after: Link) -> vec3f {
    let pull = before.over_length * before.force - after.over_length * after.force;
    return point.free + point.weight * pull - point.travel;
}

// W of a frame.
fn turn_weight(own: Link) -> mat3x3f {
    let t = own.tangent;
    let along = mat3x3f(t.x * t, t.y * t, t.z * t);
    return own.weight * (own.yielding * ONE + (1.0 - own.yielding) * along);
}

// What the moments on a link still have to turn it by.
fn turn_excess(own: Link, before: Joint, after: Joint) -> vec3f {
    let moment = transpose(before.gradient) * before.moment - transpose(after.gradient) * after.moment;
    let excess = own.free + own.weight * (moment - cross(own.tangent, own.force)) - own.turn;
    return own.yielding * excess + (1.0 - own.yielding) * dot(own.tangent, excess) * own.tangent;
}

// Left out of every step, however short it is, a residual must not add up to a push that wakes a sleeper.
fn quiet_below(strand: Strand) -> f32 {
    let mean_segment = strand.length / f32(strand.points - 1u);
    return min(QUIET, strand.still_acceleration * params.step * params.step / mean_segment);
}

// What elimination leaves.
struct Eliminated {
    tip_change: vec3f,   // dmu of the tip's joint
    unrest: f32,         // the largest residual, and what points, in lengths of their segments, and frames still have to move by:
                         // a strand that falls as it is has no residual
}

// Root to tip: U and y of every block. Block k, of joint and segment k, is due when joint and link k + 1 are known; that of the
// tip's joint, which no segment follows, is the last. Everything stands here once: drivers take long to compile what is
// written out twice, as they inline all functions.
fn eliminate(strand: Strand, rod: RodStrand) -> Eliminated {
    // Of the block before: O = [P 0; Q -s I], U and y.
    var p = mat3x3f();
    var q = mat3x3f();
    var shared_point = 0.0;
    var u: Carried;
    // Of block k, the frame before its joint, and the point that its segment begins at.
    var weight_before = mat3x3f();
    var turn_before = vec3f(0.0);
    var start_excess = vec3f(0.0);
    var start_weight = 0.0;
    var joint_before = no_joint();
    var own = no_link();
    var end = node(strand.first_point);
    var frame = rod.root_frame;
    var unrest = 0.0;
    let last = strand.points - 1u;
    for (var next = 0u; next <= strand.points; next++) {
        var joint_after = no_joint();
        var after = no_link();
        let ahead = node(strand.first_point + min(next + 1u, last));
        if next < strand.points {
            let j = strand.first_segment + min(next, last - 1u);
            let segment = segments[j];
            let now = rod_segments[j];
            joint_after = joint(strand, rod, next, frame, segment, now);
            if next < last { after = link(segment, now, rod.scheme, end.travel, ahead.travel); }
            frame = now.frame;
        }
        let end_excess = point_excess(end, own, after);
        if next > 0u {
            // Residuals, with the unknown moves as far as the multipliers have them.
            let a = joint_before.gradient;
            let turn = turn_excess(own, joint_before, joint_after);
            let bend_residual = joint_before.gap + joint_before.compliance * joint_before.moment + a * (turn - turn_before);
            let stretch_residual = own.gap + own.over_length * (end_excess - start_excess) + cross(own.tangent, turn);
            if next < strand.points {
                unrest = max(unrest, max(length(bend_residual), length(stretch_residual)));
                unrest = max(unrest, max(length(end_excess) * own.over_length, length(turn)));
            }

            let weight = turn_weight(own);
            let turns = own.weight * own.yielding * skew(own.tangent);   // W [d3]x
            let f = (1.0 + GIVE) * a * (weight_before + weight) * transpose(a) + diagonal(joint_before.compliance)
                - (transpose(p) * u.bend_bend + transpose(q) * u.stretch_bend);
            let g = a * transpose(turns) - (transpose(p) * u.bend_stretch + transpose(q) * u.stretch_stretch);
            let along = (start_weight + end.weight) * own.over_length * own.over_length;
            let h = (1.0 + GIVE) * (along * ONE + turns * transpose(skew(own.tangent))) + own.compliance
                + shared_point * u.stretch_stretch;
            let bend = -bend_residual - (transpose(p) * u.bend + transpose(q) * u.stretch);
            let stretch = -stretch_residual + shared_point * u.stretch;

            p = -1.0 * a * weight * transpose(joint_after.gradient);
            q = transpose(joint_after.gradient * turns);
            shared_point = end.weight * own.over_length * after.over_length;
            let f_inverse = inverse(f);
            let t = f_inverse * g;
            let s_inverse = inverse(h - transpose(g) * t);
            u.stretch = s_inverse * (stretch - transpose(t) * bend);
            u.bend = f_inverse * bend - t * u.stretch;
            u.stretch_bend = s_inverse * (q - transpose(t) * p);
            u.bend_bend = f_inverse * p - t * u.stretch_bend;
            u.stretch_stretch = -shared_point * s_inverse;
            u.bend_stretch = shared_point * t * s_inverse;
            if next < strand.points {
                factors[strand.first_segment + next - 1u] = Factor(symmetric(f_inverse), symmetric(s_inverse), t, u.bend, u.stretch);
            }
            weight_before = weight;
            turn_before = turn;
        }
        start_excess = end_excess;
        start_weight = end.weight;
        end = ahead;
        joint_before = joint_after;
        own = after;
    }
    return Eliminated(u.bend, unrest);
}

// Tip to root: multipliers, and the moves that follow from them. Returns max |C + alpha mu| of stretch-shear afterwards. Joint
// and segment k come with the point at the segment's end, at first the tip's joint alone, at last the root's point.
fn substitute(strand: Strand, s: u32, rod: RodStrand, tip_change: vec3f) -> f32 {
    let last = strand.points - 1u;
    var worst = 0.0;
    var bend = tip_change;
    var stretch = vec3f(0.0);
    var joint_after = no_joint();
    var after = no_link();
    // The segment after, as it is now, and the point at its end.
    var chord_after = vec3f(0.0);
    var frame_after = ONE;
    var compliance_after = vec3f(0.0);
    var length_after = 0.0;
    var end_after = vec3f(0.0);
    // The segment's frame before it is turned, and the point at its end.
    var own_frame = vec4f();
    var end: Node;
    for (var done = 0u; done <= strand.points; done++) {
        let k = last - done;   // wraps at the root's point
        let j = strand.first_segment + min(k, last - 1u);
        let p = strand.first_point + k + 1u;
        var joint_before = no_joint();
        var own = no_link();
        var chord = vec3f(0.0);
        var frame = ONE;
        var compliance = vec3f(0.0);
        var rest_length = 0.0;
        let start = node(strand.first_point + min(k, last));
        var frame_before = rod.root_frame;
        if done < last { frame_before = rod_segments[strand.first_segment + k - 1u].frame; }
        if done <= last {
            let segment = segments[j];
            var now = rod_segments[j];
            now.frame = own_frame;   // the iteration before has read it
            chord = now.chord;
            compliance = segment.stretch_compliance;
            rest_length = segment.rest_length;
            joint_before = joint(strand, rod, k, frame_before, segment, now);
            if done > 0u {
                own = link(segment, now, rod.scheme, start.travel, end.travel);
                // O dmu of the block after, and D^-1 of that.
                let turn = transpose(joint_after.gradient) * bend;
                let bend_after = -(joint_before.gradient * (turn_weight(own) * turn));
                let stretch_after = -own.weight * own.yielding * cross(own.tangent, turn)
                    - end.weight * own.over_length * after.over_length * stretch;
                let factor = factors[j];
                let stretch_less = times(factor.s.diagonal, factor.s.off_diagonal, stretch_after - transpose(factor.t) * bend_after);
                stretch = factor.stretch - stretch_less;
                bend = factor.bend - times(factor.f.diagonal, factor.f.off_diagonal, bend_after) + factor.t * stretch_less;
                own.force += stretch;
            }
            joint_before.moment += bend;
        }
        if done == 0u {
            rod_strands[s].tip_moment = joint_before.moment;
        } else {
            let travel = end.travel + point_excess(end, own, after);
            rod_points[p].travel = travel;
            if done <= last {
                let turn = own.turn + turn_excess(own, joint_before, joint_after);
                let turned = normalize(product(rotation(turn), rod_segments[j].start));
                rod_segments[j].turn = turn;
                rod_segments[j].frame = turned;
                rod_segments[j].force = own.force;
                rod_segments[j].moment = joint_before.moment;
                frame = matrix(turned);
            }
            if done > 1u {
                let chord_now = chord_after + end_after - travel;
                let compliance_now = in_world(frame_after, compliance_after);
                let gap = length(stretch_gap(chord_now, length_after, frame_after, compliance_now, after.force));
                worst = max(worst, select(HOPELESS, gap, finite(gap)));
            }
            end_after = travel;
        }
        joint_after = joint_before;
        after = own;
        chord_after = chord;
        frame_after = frame;
        compliance_after = compliance;
        length_after = rest_length;
        own_frame = frame_before;
        end = start;
    }
    return worst;
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let s = invocation(id, groups);
    if (s >= params.strands) | frozen() { return; }
    let strand = strands[s];
    for (var step = 0u; step < newton_steps(); step++) {
        let rod = rod_strands[s];
        if rod.state != FREE { break; }
        let eliminated = eliminate(strand, rod);
        if params.sleep != 0u && eliminated.unrest < quiet_below(strand) {
            rod_strands[s].state = SOLVED;
            count(QUIET_STEP);
            break;
        }
        let misfit = substitute(strand, s, rod, eliminated.tip_change);
        rod_strands[s].misfit = misfit;
        if misfit < FITS { rod_strands[s].state = SOLVED; }
    }
}
