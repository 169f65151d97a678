// Articulated bodies (Featherstone 2008, Rigid Body Dynamics Algorithms, ch. 7): the bodies beyond a point act on it,
// moved by x and turned by theta, by the force A (x, theta) + b. Seen through a spring of stiffness K that resists by
// f, it acts by
//
//   A' = K (A + K)^-1 A,   b' = b - A (A + K)^-1 (b + f)      the spring gives by -(A + K)^-1 (b + f + A (x, theta))
//
// No term subtracts nearly equal numbers: a stiff spring leaves A as it is, a soft one leaves K. So f32 suffices.
//
// A force on a tip that is held adds B of it to b. It moves the tip by -Omega, Omega = sum B^T (A + K)^-1 B over all
// springs on the way; the others move it by -sum B^T (A + K)^-1 (b + f).
import package::common::{
    quaternion::{product, conjugate, matrix},
    symmetric::{Symmetric, applied, applied_to_columns, dyad, full, inverse_of, minus, plus, symmetric_product},
};

// A, b and B are split into the components of one kind, moves or rotations, which the next spring resists, and those of
// the other.
struct Beyond {
    own: Symmetric,        // A
    other: Symmetric,
    cross: mat3x3f,        // forces of its own kind, by the other kind
    force: vec3f,          // b
    other_force: vec3f,
    held: mat3x3f,         // B
    other_held: mat3x3f,
    give: Symmetric,       // Omega
    given: vec3f,          // sum B^T (A + K)^-1 (b + f)
}

// A spring: its stiffness, and the force or moment by which it resists, in world axes.
struct Spring {
    stiffness: Symmetric,
    force: vec3f,
}

// Yield of a spring, times -1: by itself, and by a unit of either kind.
struct Answer {
    constant: vec3f,
    by_own: mat3x3f,
    by_other: mat3x3f,
}

struct Passed {
    beyond: Beyond,
    answer: Answer,
}

const STIFFEST: f32 = 1e-6;   // 1/(N m): a compliance below it counts as it, 0 among them,
// and so does one below this part of the spring's largest: f32 holds no stiffnesses farther apart
const UNEVEN: f32 = 1e-3;
const ONE = mat3x3f(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 1.0, 0.0), vec3f(0.0, 0.0, 1.0));

// sum_i k_i c_i c_i^T over the columns of m, and sum_i k_i gap_i c_i.
fn spring(m: mat3x3f, compliance: vec3f, gap: vec3f) -> Spring {
    let largest = max(compliance.x, max(compliance.y, compliance.z));
    let k = 1.0 / max(compliance, vec3f(max(STIFFEST, UNEVEN * largest)));
    return Spring(plus(plus(dyad(k.x, m[0]), dyad(k.y, m[1])), dyad(k.z, m[2])), m * (k * gap));
}

// The joint between two frames, for turns of the second.
fn joint(before: vec4f, after: vec4f, rest: vec4f, compliance: vec3f) -> Spring {
    let p = product(conjugate(before), after);
    let gap = p.xyz - select(-rest.xyz, rest.xyz, dot(p, rest) >= 0.0);
    return spring(0.5 * matrix(before) * (p.w * ONE + crossing(p.xyz, ONE)), compliance, gap);
}

// A vector, crossed with the columns of a matrix.
fn crossing(v: vec3f, m: mat3x3f) -> mat3x3f {
    return mat3x3f(cross(v, m[0]), cross(v, m[1]), cross(v, m[2]));
}

// The part beyond, for a spring of the other kind.
fn swapped(b: Beyond) -> Beyond {
    return Beyond(b.other, b.own, transpose(b.cross), b.other_force, b.force, b.other_held, b.held, b.give, b.given);
}

fn through(b: Beyond, k: Spring, holds: bool) -> Passed {
    let e = inverse_of(plus(b.own, k.stiffness));
    let answer = Answer(applied(e, b.force + k.force), applied_to_columns(e, full(b.own)),
        applied_to_columns(e, b.cross));
    var after = b;
    after.own = symmetric_product(full(k.stiffness), answer.by_own);
    after.other = minus(b.other, symmetric_product(b.cross, answer.by_other));
    after.cross = applied_to_columns(k.stiffness, answer.by_other);
    after.force -= applied(b.own, answer.constant);
    after.other_force -= answer.constant * b.cross;
    if holds {
        let moved = applied_to_columns(e, b.held);
        after.held = applied_to_columns(k.stiffness, moved);
        after.other_held -= transpose(b.cross) * moved;
        after.give = plus(b.give, symmetric_product(b.held, moved));
        after.given += answer.constant * b.held;
    }
    return Passed(after, answer);
}
