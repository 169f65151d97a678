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

// q turned by the small rotation vector `angle` [rad], in world axes.
fn turned(q: vec4f, angle: vec3f) -> vec4f {
    return normalize(q + 0.5 * product(vec4f(angle, 0.0), q));
}
