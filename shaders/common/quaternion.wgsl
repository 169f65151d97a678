// Unit quaternions (x, y, z, w); they rotate material frame to world.

fn product(a: vec4f, b: vec4f) -> vec4f {
    return vec4f(a.w * b.xyz + b.w * a.xyz + cross(a.xyz, b.xyz), a.w * b.w - dot(a.xyz, b.xyz));
}

fn conjugate(q: vec4f) -> vec4f {
    return vec4f(-q.xyz, q.w);
}

fn rotate(q: vec4f, v: vec3f) -> vec3f {
    return v + 2.0 * cross(q.xyz, cross(q.xyz, v) + q.w * v);
}

// The third director: the tangent.
fn tangent(q: vec4f) -> vec3f {
    return vec3f(
        2.0 * (q.x * q.z + q.w * q.y),
        2.0 * (q.y * q.z - q.w * q.x),
        1.0 - 2.0 * (q.x * q.x + q.y * q.y),
    );
}

// Its columns are the directors.
fn matrix(q: vec4f) -> mat3x3f {
    return mat3x3f(rotate(q, vec3f(1.0, 0.0, 0.0)), rotate(q, vec3f(0.0, 1.0, 0.0)), tangent(q));
}

// The rotation by |angle| about `angle` [rad].
fn rotation(angle: vec3f) -> vec4f {
    let half_angle = 0.5 * length(angle);
    // sin(x)/x is 1 to rounding below 1e-4.
    let ratio = select(1.0, sin(half_angle) / half_angle, half_angle > 1e-4);
    return vec4f(0.5 * ratio * angle, cos(half_angle));
}

// Its rotation vector, at most pi long [rad].
fn rotation_vector(q: vec4f) -> vec3f {
    let up = select(-q, q, q.w >= 0.0);
    let sine = length(up.xyz);
    let ratio = select(1.0, atan2(sine, up.w) / sine, sine > 1e-4);
    return 2.0 * ratio * up.xyz;
}

// q turned by the small rotation vector `angle` [rad], in world axes.
fn turned(q: vec4f, angle: vec3f) -> vec4f {
    return normalize(q + 0.5 * product(vec4f(angle, 0.0), q));
}
