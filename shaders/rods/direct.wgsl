// One Newton step of the dual system of each strand, solved directly in linear time.
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
// so that root to tip  D_k -= O_(k-1)^T U_(k-1), U = D^-1 O, y = D^-1 r  and tip to root  dmu_k = y_k - U_k dmu_(k+1).
// One invocation per strand, done when its segments fit.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, status::{frozen, count, QUIET_STEP},
    quaternion::{product, conjugate, rotate, rotation, tangent, matrix}, integration::response, load::damping_of,
    rod::{Strand, Segment, RodStrand, RodPoint, RodSegment, FREE, SOLVED, ROOT_JOINT, TIP_JOINT},
};

// U and y of a block.
struct Factor {
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
const QUIET: f32 = 1e-6;     // residual below which a strand need not be solved; see `quiet_below`
// Added to the diagonal of J W J^T, in parts of it: keeps the system within what f32 resolves where segments are stiff and
// short. Steps come out shorter by that much where they are the least certain; where a strand comes to rest stays the same.
const GIVE: f32 = 2e-7;
const ONE = mat3x3f(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 1.0, 0.0), vec3f(0.0, 0.0, 1.0));

fn skew(v: vec3f) -> mat3x3f {
    return mat3x3f(vec3f(0.0, v.z, -v.y), vec3f(-v.z, 0.0, v.x), vec3f(v.y, -v.x, 0.0));
}

fn diagonal(v: vec3f) -> mat3x3f {
    return mat3x3f(vec3f(v.x, 0.0, 0.0), vec3f(0.0, v.y, 0.0), vec3f(0.0, 0.0, v.z));
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

// Joint k of a strand; k = points - 1 is that of the tip.
fn joint(strand: Strand, rod: RodStrand, k: u32) -> Joint {
    let j = strand.first_segment + k;
    if k == 0u {
        if (strand.joints & ROOT_JOINT) == 0u { return no_joint(); }
        let segment = segments[j];
        return joint_between(
            rod.root_frame, rod_segments[j].frame, segment.rest_rotation, segment.bend_compliance, rod_segments[j].moment
        );
    }
    if k == strand.points - 1u {
        if (strand.joints & TIP_JOINT) == 0u { return no_joint(); }
        return joint_between(
            rod_segments[j - 1u].frame, strand.tip_frame, strand.tip_rest_rotation, strand.tip_compliance, rod.tip_moment
        );
    }
    let segment = segments[j];
    return joint_between(
        rod_segments[j - 1u].frame, rod_segments[j].frame, segment.rest_rotation, segment.bend_compliance,
        rod_segments[j].moment
    );
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

fn link(strand: Strand, k: u32) -> Link {
    let j = strand.first_segment + k;
    let segment = segments[j];
    let now = rod_segments[j];
    let p = strand.first_point + k;
    let chord = now.chord + rod_points[p + 1u].travel - rod_points[p].travel;
    let frame = matrix(now.frame);
    let compliance = frame * diagonal(segment.stretch_compliance) * transpose(frame);
    let gap = chord / segment.rest_length - frame[2] + compliance * now.force;
    let weight = response(params.damping, now.scheme) * segment.inverse_inertia;
    let yielding = 1.0 / (1.0 + weight * max(0.0, -dot(frame[2], now.force)));
    return Link(
        frame[2], 1.0 / segment.rest_length, gap, weight, yielding, compliance, now.force, now.free, now.turn
    );
}

// A link of a strand that ends before it: weighs nothing, holds nothing.
fn no_link() -> Link {
    return Link(vec3f(0.0), 0.0, vec3f(0.0), 0.0, 1.0, mat3x3f(), vec3f(0.0), vec3f(0.0), vec3f(0.0));
}

// The link after link k.
fn link_after(strand: Strand, k: u32) -> Link {
    if k + 2u < strand.points { return link(strand, k + 1u); }
    return no_link();
}

// W of a point.
fn point_weight(p: u32) -> f32 {
    let point = rod_points[p];
    return response(damping_of(point), point.scheme) * point.inverse_mass;
}

// What the forces on a point, of the link before it and of that after it, still have to move it by.
fn point_excess(p: u32, before: Link, after: Link) -> vec3f {
    let point = rod_points[p];
    let pull = before.over_length * before.force - after.over_length * after.force;
    return point.free + point_weight(p) * pull - point.travel;
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

// Residuals of joint and segment k, with the unknown moves as far as the multipliers have them.
struct Residual { bend: vec3f, stretch: vec3f, excess: vec3f, turn_excess: vec3f }

fn residual(
    strand: Strand, k: u32, own: Link, after: Link, joint_before: Joint, joint_after: Joint, excess: vec3f,
    turn_excess_before: vec3f,
) -> Residual {
    let next = point_excess(strand.first_point + k + 1u, own, after);
    let turn = turn_excess(own, joint_before, joint_after);
    let bend = joint_before.gap + joint_before.compliance * joint_before.moment
        + joint_before.gradient * (turn - turn_excess_before);
    let stretch = own.gap + own.over_length * (next - excess) + cross(own.tangent, turn);
    return Residual(bend, stretch, next, turn);
}

// Where the residuals of a strand with this first link start from: nothing before the root, but the root may have to move.
fn before_root(strand: Strand, first: Link) -> Residual {
    return Residual(vec3f(0.0), vec3f(0.0), point_excess(strand.first_point, no_link(), first), vec3f(0.0));
}

// The largest residual of a strand, and what its points, in lengths of their segments, and frames still have to move by: one
// that falls as it is has no residual.
fn unrest(strand: Strand, rod: RodStrand) -> f32 {
    var worst = 0.0;
    var joint_before = joint(strand, rod, 0u);
    var own = link(strand, 0u);
    var r = before_root(strand, own);
    for (var k = 0u; k < strand.points - 1u; k++) {
        let joint_after = joint(strand, rod, k + 1u);
        let after = link_after(strand, k);
        r = residual(strand, k, own, after, joint_before, joint_after, r.excess, r.turn_excess);
        worst = max(worst, max(length(r.bend), length(r.stretch)));
        worst = max(worst, max(length(r.excess) * own.over_length, length(r.turn_excess)));
        joint_before = joint_after;
        own = after;
    }
    return worst;
}

// Left out of every step, however short it is, a residual must not add up to a push that wakes a sleeper.
fn quiet_below(strand: Strand) -> f32 {
    let mean_segment = strand.length / f32(strand.points - 1u);
    return min(QUIET, strand.still_acceleration * params.step * params.step / mean_segment);
}

// Root to tip: U and y of every block. Returns dmu of the tip's joint.
fn eliminate(strand: Strand, rod: RodStrand) -> vec3f {
    // Of the block before: O = [P 0; Q -s I], U and y.
    var p = mat3x3f();
    var q = mat3x3f();
    var shared_point = 0.0;
    var u: Factor;
    var weight_before = mat3x3f();   // of the frame before the joint
    var joint_before = joint(strand, rod, 0u);
    var own = link(strand, 0u);
    var r = before_root(strand, own);
    for (var k = 0u; k < strand.points - 1u; k++) {
        let joint_after = joint(strand, rod, k + 1u);
        let after = link_after(strand, k);
        r = residual(strand, k, own, after, joint_before, joint_after, r.excess, r.turn_excess);

        let a = joint_before.gradient;
        let w0 = point_weight(strand.first_point + k);
        let w1 = point_weight(strand.first_point + k + 1u);
        let weight = turn_weight(own);
        let turns = own.weight * own.yielding * skew(own.tangent);   // W [d3]x
        let f = (1.0 + GIVE) * a * (weight_before + weight) * transpose(a) + diagonal(joint_before.compliance)
            - (transpose(p) * u.bend_bend + transpose(q) * u.stretch_bend);
        let g = a * transpose(turns) - (transpose(p) * u.bend_stretch + transpose(q) * u.stretch_stretch);
        let h = (1.0 + GIVE) * ((w0 + w1) * own.over_length * own.over_length * ONE + turns * transpose(skew(own.tangent))) + own.compliance
            + shared_point * u.stretch_stretch;
        let bend = -r.bend - (transpose(p) * u.bend + transpose(q) * u.stretch);
        let stretch = -r.stretch + shared_point * u.stretch;

        p = -1.0 * a * weight * transpose(joint_after.gradient);
        q = transpose(joint_after.gradient * turns);
        shared_point = w1 * own.over_length * after.over_length;
        let f_inverse = inverse(f);
        let t = f_inverse * g;
        let s_inverse = inverse(h - transpose(g) * t);
        u.stretch = s_inverse * (stretch - transpose(t) * bend);
        u.bend = f_inverse * bend - t * u.stretch;
        u.stretch_bend = s_inverse * (q - transpose(t) * p);
        u.bend_bend = f_inverse * p - t * u.stretch_bend;
        u.stretch_stretch = -shared_point * s_inverse;
        u.bend_stretch = shared_point * t * s_inverse;
        factors[strand.first_segment + k] = u;

        weight_before = weight;
        joint_before = joint_after;
        own = after;
    }
    // The tip's joint: `joint_before` by now, between the last frame and one that is held.
    let a = joint_before.gradient;
    let f = (1.0 + GIVE) * a * weight_before * transpose(a) + diagonal(joint_before.compliance)
        - (transpose(p) * u.bend_bend + transpose(q) * u.stretch_bend);
    let bend = joint_before.gap + joint_before.compliance * joint_before.moment - a * r.turn_excess;
    return inverse(f) * (-bend - (transpose(p) * u.bend + transpose(q) * u.stretch));
}

// Tip to root: multipliers, and the moves that follow from them. Returns max |C + alpha mu| of stretch-shear afterwards.
fn substitute(strand: Strand, s: u32, rod: RodStrand, tip_change: vec3f) -> f32 {
    let last = strand.points - 1u;
    var worst = 0.0;
    var bend = tip_change;
    var stretch = vec3f(0.0);
    var joint_after = joint(strand, rod, last);
    joint_after.moment += tip_change;
    rod_strands[s].tip_moment = joint_after.moment;
    var after = no_link();
    for (var k = last; k > 0u; k--) {
        let j = strand.first_segment + k - 1u;
        let p = strand.first_point + k;
        let u = factors[j];
        let bend_change = u.bend - u.bend_bend * bend - u.bend_stretch * stretch;
        let stretch_change = u.stretch - u.stretch_bend * bend - u.stretch_stretch * stretch;
        var joint_before = joint(strand, rod, k - 1u);
        var own = link(strand, k - 1u);
        joint_before.moment += bend_change;
        own.force += stretch_change;
        rod_points[p].travel += point_excess(p, own, after);
        let turn = own.turn + turn_excess(own, joint_before, joint_after);
        rod_segments[j].turn = turn;
        rod_segments[j].frame = normalize(product(rotation(turn), rod_segments[j].start));
        rod_segments[j].force = own.force;
        rod_segments[j].moment = joint_before.moment;
        if k < last { worst = max(worst, length(link(strand, k).gap)); }
        bend = bend_change;
        stretch = stretch_change;
        joint_after = joint_before;
        after = own;
    }
    rod_points[strand.first_point].travel += point_excess(strand.first_point, no_link(), after);
    return max(worst, length(link(strand, 0u).gap));
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let s = invocation(id, groups);
    if s >= params.strands || frozen() { return; }
    let rod = rod_strands[s];
    if rod.state != FREE { return; }
    let strand = strands[s];
    if params.sleep != 0u && unrest(strand, rod) < quiet_below(strand) {
        rod_strands[s].state = SOLVED;
        count(QUIET_STEP);
        return;
    }
    let tip_change = eliminate(strand, rod);
    let misfit = substitute(strand, s, rod, tip_change);
    rod_strands[s].misfit = misfit;
    if misfit < FITS { rod_strands[s].state = SOLVED; }
}
