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
// One invocation per strand, done when its segments fit, or one Newton step later if they are many. On a GPU the seven beside it rest,
// so that those of a warp read few strands at once.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, status::{frozen, count, finite, QUIET_STEP},
    quaternion::{product, conjugate, rotation, tangent, matrix}, integration::response,
    share::{owner_of, worker_of}, symmetric::{Symmetric, applied, applied_to_columns, cross_dyad, dyad, inverse_of, minus, plus, scaled, symmetric_product},
    rod::{Strand, Segment, RodStrand, RodPoint, RodSegment, FREE, FITTED, SOLVED, MISFIT, ROOT_JOINT, TIP_JOINT},
};

// D^-1 and y of a block, D^-1 = [1 -T; 0 1] [F^-1 0; 0 S^-1] [1 0; -T^T 1] with T = F^-1 G and S = H - G^T T.
struct Factor {
    f: Symmetric,     // F^-1
    s: Symmetric,     // S^-1
    t: mat3x3f,
    bend: vec3f,      // y
    stretch: vec3f,
}

// O^T U and O^T y of a block: what its elimination takes from the next one. With R = Q - T^T P:
struct Taken {
    bend_bend: Symmetric,         // P^T F^-1 P + R^T S^-1 R
    bend_stretch: mat3x3f,        // -s (S^-1 R)^T
    stretch_stretch: Symmetric,   // s^2 S^-1
    bend: vec3f,
    stretch: vec3f,
}

@group(0) @binding(2) var<storage, read>       strands:      array<Strand>;
@group(0) @binding(3) var<storage, read>       segments:     array<Segment>;
@group(0) @binding(4) var<storage, read_write> rod_strands:  array<RodStrand>;
@group(0) @binding(5) var<storage, read_write> rod_points:   array<RodPoint>;
@group(0) @binding(6) var<storage, read_write> rod_segments: array<RodSegment>;
@group(0) @binding(7) var<storage, read_write> factors:      array<Factor>;

const FITS: f32 = 1e-5;      // |C + alpha mu| of stretch-shear below which a strand fits
const HOPELESS: f32 = 1e30;  // that of one whose numbers are none any more
// A strand of more points is solved once more when it fits. What f32 leaves of a Newton step grows with the fourth power of the number
// of segments, and brakes or drives swings.
const FEW_POINTS: u32 = 65u;
const QUIET: f32 = 1e-6;     // residual below which a strand need not be solved; see `quiet_below`
// Added to the diagonal of J W J^T in the rows of stretch-shear, in parts of it: f32 then holds a strand that is taut between its ends.
// Steps come out shorter by that much; where a strand comes to rest stays the same.
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

// The columns of a matrix, crossed with a vector.
fn crossed(m: mat3x3f, v: vec3f) -> mat3x3f {
    return mat3x3f(cross(m[0], v), cross(m[1], v), cross(m[2], v));
}

// A joint between two frames.
struct Joint {
    gap: vec3f,          // C
    gradient: mat3x3f,   // A^T, 0 where nothing joins
    compliance: vec3f,
    moment: vec3f,
}

// Joint k of a strand, behind a frame; k = points - 1 is that of the tip, which no segment follows. `segment` and `now` are of
// the segment after it, or of any where there is none. Where nothing joins, its rows of the system are 1 dmu = 0.
fn joint(strand: Strand, rod: RodStrand, k: u32, before: vec4f, segment: Segment, now: RodSegment) -> Joint {
    let tip = k == strand.points - 1u;
    let joins = select(select(0u, ROOT_JOINT, k == 0u), TIP_JOINT, tip);
    let holds = (k < strand.points) & ((strand.joints & joins) == joins);
    let rest = select(segment.rest_rotation, strand.tip_rest_rotation, tip);
    let p = product(conjugate(before), select(now.frame, strand.tip_frame, tip));
    let gap = p.xyz - select(-rest.xyz, rest.xyz, dot(p, rest) >= 0.0);
    return Joint(
        select(vec3f(0.0), gap, holds),
        select(0.0, 0.5, holds) * matrix(before) * (p.w * ONE + skew(p.xyz)),
        select(vec3f(1.0), select(segment.bend_compliance, strand.tip_compliance, tip), holds),
        select(vec3f(0.0), select(now.moment, rod.tip_moment, tip), holds),
    );
}

// A segment, where it stands and what it weighs.
struct Link {
    tangent: vec3f,
    over_length: f32,        // 1/l
    gap: vec3f,              // C + alpha mu
    weight: f32,             // of its frame, w h^2/(1 + c h)
    yielding: f32,           // 1/(1 + weight T): to turns off the pull
    compliance: Symmetric,   // world
    force: vec3f,            // world
    free: vec3f,             // turn
    turn: vec3f,
}

// C + alpha mu of a segment but for its chord over its length: from the matrix of its frame and the force on it.
fn strain(frame: mat3x3f, compliance: vec3f, force: vec3f) -> vec3f {
    return frame * (compliance * (force * frame)) - frame[2];
}

// The link of a segment, between points that have moved by `start` and `end`. One beyond either end of a strand weighs nothing and
// holds nothing: its rows of the system are 1 dmu = 0.
fn link(segment: Segment, now: RodSegment, scheme: u32, start: vec3f, end: vec3f, there: bool) -> Link {
    let frame = matrix(now.frame);
    let c = segment.stretch_compliance;
    let compliance = plus(plus(dyad(c.x, frame[0]), dyad(c.y, frame[1])), dyad(c.z, frame[2]));
    let over_length = select(0.0, 1.0 / segment.rest_length, there);
    let gap = (now.chord + end - start) / segment.rest_length + strain(frame, c, now.force);
    let weight = select(0.0, response(params.damping, scheme) * segment.inverse_inertia, there);
    let yielding = 1.0 / (1.0 + weight * max(0.0, -dot(frame[2], now.force)));
    return Link(
        frame[2],
        over_length,
        select(vec3f(0.0), gap, there),
        weight,
        yielding,
        Symmetric(
            select(vec3f(1.0), compliance.diagonal, there), select(vec3f(0.0), compliance.off_diagonal, there),
        ),
        now.force,
        select(vec3f(0.0), now.free, there),
        select(vec3f(0.0), now.turn, there),
    );
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
fn turn_weight(own: Link) -> Symmetric {
    let all = vec3f(own.weight * own.yielding);
    return plus(Symmetric(all, vec3f(0.0)), dyad(own.weight * (1.0 - own.yielding), own.tangent));
}

// What the moments on a link still have to turn it by.
fn turn_excess(own: Link, before: Joint, after: Joint) -> vec3f {
    let moment = before.gradient * before.moment - after.gradient * after.moment;
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

// What elimination reads for a block: the segment, and the point at its end.
struct Due {
    ahead: Node,
    segment: Segment,
    now: RodSegment,
}

// For block k; for one beyond the last that of the last.
fn due_of(strand: Strand, k: u32) -> Due {
    let last = strand.points - 1u;
    let j = strand.first_segment + min(k, last - 1u);
    return Due(node(strand.first_point + min(k + 1u, last)), segments[j], rod_segments[j]);
}

// Root to tip: D^-1 and y of every block. Block k, of joint and segment k, is due when joint and link k + 1 are known; that of the
// tip's joint, which no segment follows, is the last, and the first is one of nothing. Everything stands here once: drivers take
// long to compile what is written out twice, as they inline all functions. They also take long over branches, and over what the loop
// carries: of the block before that is no more than what it takes from this one.
fn eliminate(strand: Strand, rod: RodStrand) -> Eliminated {
    var taken: Taken;
    // Of block k, the frame before its joint, and the point that its segment begins at.
    var weight_before: Symmetric;
    var turn_before = vec3f(0.0);
    var start_excess = vec3f(0.0);
    var start_weight = 0.0;
    var joint_before = Joint(vec3f(0.0), mat3x3f(), vec3f(1.0), vec3f(0.0));
    var own = Link();
    own.yielding = 1.0;
    own.compliance.diagonal = vec3f(1.0);
    var end = node(strand.first_point);
    var frame = rod.root_frame;
    var tip_change = vec3f(0.0);
    var unrest = 0.0;
    let last = strand.points - 1u;
    // A GPU reads the next block while it eliminates this one.
    @if(!software) var coming = due_of(strand, 0u);
    for (var next = 0u; next <= strand.points; next++) {
        @if(software) let due = due_of(strand, next);
        @if(!software) let due = coming;
        @if(!software) coming = due_of(strand, next + 1u);
        let ahead = due.ahead;
        let segment = due.segment;
        let now = due.now;
        let joint_after = joint(strand, rod, next, frame, segment, now);
        let after = link(segment, now, rod.scheme, end.travel, ahead.travel, next < last);
        frame = now.frame;

        // Residuals, with the unknown moves as far as the multipliers have them.
        let a = joint_before.gradient;
        let end_excess = point_excess(end, own, after);
        let turn = turn_excess(own, joint_before, joint_after);
        let bend_residual = joint_before.gap + joint_before.compliance * joint_before.moment + (turn - turn_before) * a;
        let stretch_residual = own.gap + own.over_length * (end_excess - start_excess) + cross(own.tangent, turn);
        let residual = max(length(bend_residual), length(stretch_residual));
        let excess = max(length(end_excess) * own.over_length, length(turn));
        unrest = max(unrest, max(residual, excess));

        let weight = turn_weight(own);
        let across = own.weight * own.yielding;   // W [d3]x is this times [d3]x
        let before = applied_to_columns(plus(weight_before, weight), a);
        let along = (start_weight + end.weight) * own.over_length * own.over_length;
        let stiff = plus(Symmetric(vec3f(along), vec3f(0.0)), cross_dyad(across, own.tangent));
        let f = minus(plus(symmetric_product(a, before), Symmetric(joint_before.compliance, vec3f(0.0))), taken.bend_bend);
        let g = -across * transpose(crossed(a, own.tangent)) - taken.bend_stretch;
        let h = minus(plus(scaled(1.0 + GIVE, stiff), own.compliance), taken.stretch_stretch);
        let f_inverse = inverse_of(f);
        let t = applied_to_columns(f_inverse, g);
        let s_inverse = inverse_of(minus(h, symmetric_product(g, t)));
        let bend_left = -bend_residual - taken.bend;
        let stretch = applied(s_inverse, -stretch_residual - taken.stretch - bend_left * t);
        let bend = applied(f_inverse, bend_left) - t * stretch;
        if (next > 0u) & (next < strand.points) {
            factors[strand.first_segment + next - 1u] = Factor(f_inverse, s_inverse, t, bend, stretch);
        }

        let p = -1.0 * transpose(a) * applied_to_columns(weight, joint_after.gradient);
        let q = across * crossed(joint_after.gradient, own.tangent);
        let shared_point = end.weight * own.over_length * after.over_length;
        let r = q - transpose(t) * p;
        let u = applied_to_columns(s_inverse, r);
        taken = Taken(
            plus(symmetric_product(p, applied_to_columns(f_inverse, p)), symmetric_product(r, u)),
            -shared_point * transpose(u),
            scaled(shared_point * shared_point, s_inverse),
            bend * p + stretch * q,
            -shared_point * stretch,
        );
        tip_change = bend;
        weight_before = weight;
        turn_before = turn;
        start_excess = end_excess;
        start_weight = end.weight;
        end = ahead;
        joint_before = joint_after;
        own = after;
    }
    return Eliminated(tip_change, unrest);
}

// Tip to root: multipliers, and the moves that follow from them. Returns max |C + alpha mu| of stretch-shear afterwards. Joint
// and segment k come with the point at the segment's end, at first the tip's joint alone, at last the root's point.
fn substitute(strand: Strand, s: u32, rod: RodStrand, tip_change: vec3f) -> f32 {
    let last = strand.points - 1u;
    var worst = 0.0;
    var bend = tip_change;
    var stretch = vec3f(0.0);
    var joint_after: Joint;
    var after: Link;
    // What the segment after has now: its chord but for the move of its first point, and its strain.
    var reach_after = vec3f(0.0);
    var strain_after = vec3f(0.0);
    // The segment's frame before it is turned, and the point at its end.
    var own_frame = vec4f();
    var end: Node;
    for (var done = 0u; done <= strand.points; done++) {
        let there = (done > 0u) & (done <= last);
        let k = last - done;   // wraps at the root's point
        let j = strand.first_segment + min(k, last - 1u);
        let start = node(strand.first_point + min(k, last));
        // All is read before any branch, at once.
        let before = select(0u, k - 1u, done < last);
        let frame_before = select(rod.root_frame, rod_segments[strand.first_segment + before].frame, done < last);
        let factor = factors[j];
        let segment = segments[j];
        var now = rod_segments[j];
        now.frame = own_frame;   // the iteration before has read it
        var joint_before = joint(strand, rod, k, frame_before, segment, now);
        var own = link(segment, now, rod.scheme, start.travel, end.travel, there);
        if there {
            // O dmu of the block after, and D^-1 of that.
            let turn = joint_after.gradient * bend;
            let bend_after = -1.0 * (applied(turn_weight(own), turn) * joint_before.gradient);
            let stretch_after = -own.weight * own.yielding * cross(own.tangent, turn)
                - end.weight * own.over_length * after.over_length * stretch;
            let stretch_less = applied(factor.s, stretch_after - bend_after * factor.t);
            stretch = factor.stretch - stretch_less;
            bend = factor.bend - applied(factor.f, bend_after) + factor.t * stretch_less;
            own.force += stretch;
        }
        joint_before.moment += bend;
        if done == 0u {
            rod_strands[s].tip_moment = joint_before.moment;
        } else {
            let travel = end.travel + point_excess(end, own, after);
            rod_points[strand.first_point + k + 1u].travel = travel;
            if done > 1u {
                let gap = length(after.over_length * (reach_after - travel) + strain_after);
                worst = max(worst, select(HOPELESS, gap, finite(gap)));
            }
            reach_after = now.chord + travel;
        }
        if there {
            let turn = own.turn + turn_excess(own, joint_before, joint_after);
            let turned = normalize(product(rotation(turn), now.start));
            rod_segments[j].turn = turn;
            rod_segments[j].frame = turned;
            rod_segments[j].force = own.force;
            rod_segments[j].moment = joint_before.moment;
            strain_after = strain(matrix(turned), segment.stretch_compliance, own.force);
        }
        joint_after = joint_before;
        after = own;
        own_frame = frame_before;
        end = start;
    }
    return worst;
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let at = invocation(id, groups);
    let s = owner_of(at);
    if (s >= params.strands) | (worker_of(at) > 0u) | frozen() { return; }
    let strand = strands[s];
    for (var step = 0u; step < newton_steps(); step++) {
        let rod = rod_strands[s];
        let first = rod.state == FREE;
        if !first & (rod.state != FITTED) { break; }
        let eliminated = eliminate(strand, rod);
        if first && params.sleep != 0u && eliminated.unrest < quiet_below(strand) {
            rod_strands[s].state = SOLVED;
            count(QUIET_STEP);
            break;
        }
        let misfit = substitute(strand, s, rod, eliminated.tip_change);
        rod_strands[s].misfit = misfit;
        let solved = select(SOLVED, FITTED, first & (strand.points > FEW_POINTS));
        let done = (misfit < FITS) | (!first & (misfit < MISFIT));
        rod_strands[s].state = select(FREE, solved, done);
    }
}
