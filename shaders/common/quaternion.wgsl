// Unit quaternions (x, y, z, w); they rotate material frame to world.
import package::common::pi::PI;

fn product(a: vec4f, b: vec4f) -> vec4f {
    return vec4f(a.w * b.xyz + b.w * a.xyz + cross(a.xyz, b.xyz), a.w * b.w - dot(a.xyz, b.xyz));
}

fn conjugate(q: vec4f) -> vec4f {
    return vec4f(-q.xyz, q.w);
}

// The change of a vector by a rotation.
fn turned_by(q: vec4f, v: vec3f) -> vec3f {
    return 2.0 * cross(q.xyz, cross(q.xyz, v) + q.w * v);
}

fn rotate(q: vec4f, v: vec3f) -> vec3f {
    return v + turned_by(q, v);
}

// Tangent of a frame: its third director.
fn tangent(q: vec4f) -> vec3f {
    return vec3f(
        2.0 * (q.x * q.z + q.w * q.y),
        2.0 * (q.y * q.z - q.w * q.x),
        1.0 - 2.0 * (q.x * q.x + q.y * q.y),
    );
}

// Rotation matrix of a frame; its columns are the directors.
fn matrix(q: vec4f) -> mat3x3f {
    return mat3x3f(rotate(q, vec3f(1.0, 0.0, 0.0)), rotate(q, vec3f(0.0, 1.0, 0.0)), tangent(q));
}

// Quaternion of a rotation matrix, from its largest component (Shepperd 1978).
fn frame_of(m: mat3x3f) -> vec4f {
    let diagonal = vec3f(m[0].x, m[1].y, m[2].z);
    let sums = vec4f(diagonal - diagonal.yzx - diagonal.zxy, diagonal.x + diagonal.y + diagonal.z);
    let swaps = vec3f(m[1].z - m[2].y, m[2].x - m[0].z, m[0].y - m[1].x);
    let pairs = vec3f(m[1].z + m[2].y, m[2].x + m[0].z, m[0].y + m[1].x);   // of y and z, of z and x, of x and y
    let largest = max(max(sums.x, sums.y), max(sums.z, sums.w));
    if largest == sums.w { return normalize(vec4f(swaps, 1.0 + largest)); }
    if largest == sums.x { return normalize(vec4f(1.0 + largest, pairs.z, pairs.y, swaps.x)); }
    if largest == sums.y { return normalize(vec4f(pairs.z, 1.0 + largest, pairs.x, swaps.y)); }
    return normalize(vec4f(pairs.y, pairs.x, 1.0 + largest, swaps.z));
}

// The rotation by |turn| about `turn` [rad], half a turn at most: a longer one is cut to half a turn. The series stand
// here because WGSL's own sin and cos may be off by 2^-11.
fn rotation(turn: vec3f) -> vec4f {
    let size = length(turn);
    let v = select(turn, turn * (PI / size), size > PI);
    let s = -0.25 * dot(v, v);
    // cos x and sin x / x of half the angle, s = -x^2 above -2.5: the next terms are below 1e-8.
    let cosine = 1.0
        + s / 2.0 * (1.0 + s / 12.0 * (1.0 + s / 30.0 * (1.0 + s / 56.0 * (1.0 + s / 90.0 * (1.0 + s / 132.0)))));
    let sine = 1.0
        + s / 6.0 * (1.0 + s / 20.0 * (1.0 + s / 42.0 * (1.0 + s / 72.0 * (1.0 + s / 110.0 * (1.0 + s / 156.0)))));
    return vec4f(0.5 * sine * v, cosine);
}

// Rotation vector of a rotation, half a turn at most [rad]. The angle is halved thrice, after which the arcsine's
// series is good to 1e-8; WGSL's own atan2 may be off by 4096 ulp.
fn rotation_vector(q: vec4f) -> vec3f {
    var part = select(-q, q, q.w >= 0.0);
    for (var k = 0; k < 3; k++) {
        let cosine = sqrt(0.5 + 0.5 * part.w);
        part = vec4f(part.xyz / (2.0 * cosine), cosine);
    }
    let s = dot(part.xyz, part.xyz);
    let arc = 1.0 + s / 6.0 * (1.0 + s * 9.0 / 20.0 * (1.0 + s * 25.0 / 42.0 * (1.0 + s * 49.0 / 72.0)));
    return 16.0 * arc * part.xyz;
}

// q turned by the small rotation vector `angle` [rad], in world axes.
fn turned(q: vec4f, angle: vec3f) -> vec4f {
    return normalize(q + 0.5 * product(vec4f(angle, 0.0), q));
}
