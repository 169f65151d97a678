// Symmetric matrices of three rows.

struct Symmetric {
    diagonal: vec3f,       // xx, yy, zz
    off_diagonal: vec3f,   // yz, zx, xy
}

// k v v^T.
fn dyad(k: f32, v: vec3f) -> Symmetric {
    return Symmetric(k * v * v, k * v.yzx * v.zxy);
}

// k (v . v - v v^T), which is k [v]x [v]x^T.
fn cross_dyad(k: f32, v: vec3f) -> Symmetric {
    return Symmetric(k * (v.yzx * v.yzx + v.zxy * v.zxy), -k * v.yzx * v.zxy);
}

// m^T n, where that is symmetric.
fn symmetric_product(m: mat3x3f, n: mat3x3f) -> Symmetric {
    return Symmetric(
        vec3f(dot(m[0], n[0]), dot(m[1], n[1]), dot(m[2], n[2])),
        vec3f(dot(m[1], n[2]), dot(m[2], n[0]), dot(m[0], n[1])),
    );
}

// m + m^T.
fn twice_symmetric(m: mat3x3f) -> Symmetric {
    return Symmetric(2.0 * vec3f(m[0].x, m[1].y, m[2].z), vec3f(m[1].z + m[2].y, m[2].x + m[0].z, m[0].y + m[1].x));
}

// All nine numbers.
fn full(a: Symmetric) -> mat3x3f {
    let d = a.diagonal;
    let o = a.off_diagonal;
    return mat3x3f(vec3f(d.x, o.z, o.y), vec3f(o.z, d.y, o.x), vec3f(o.y, o.x, d.z));
}

fn scaled(k: f32, a: Symmetric) -> Symmetric {
    return Symmetric(k * a.diagonal, k * a.off_diagonal);
}

fn plus(a: Symmetric, b: Symmetric) -> Symmetric {
    return Symmetric(a.diagonal + b.diagonal, a.off_diagonal + b.off_diagonal);
}

fn minus(a: Symmetric, b: Symmetric) -> Symmetric {
    return Symmetric(a.diagonal - b.diagonal, a.off_diagonal - b.off_diagonal);
}

// A matrix times a vector.
fn applied(a: Symmetric, v: vec3f) -> vec3f {
    return a.diagonal * v + a.off_diagonal.zzy * v.yxx + a.off_diagonal.yxx * v.zzy;
}

// A matrix times another.
fn applied_to_columns(a: Symmetric, m: mat3x3f) -> mat3x3f {
    return mat3x3f(applied(a, m[0]), applied(a, m[1]), applied(a, m[2]));
}

fn adjugate_of(a: Symmetric) -> Symmetric {
    let d = a.diagonal;
    let o = a.off_diagonal;
    return Symmetric(d.yzx * d.zxy - o * o, o.yzx * o.zxy - d * o);
}

// Determinant of a matrix whose adjugate is known.
fn determinant(a: Symmetric, adjugate: Symmetric) -> f32 {
    let o = a.off_diagonal * adjugate.off_diagonal;
    return a.diagonal.x * adjugate.diagonal.x + o.y + o.z;
}

// Inverse of a positive definite matrix, by the adjugate; scaled, so that the determinant stays in the range of f32.
fn inverse_of(m: Symmetric) -> Symmetric {
    let scale = 1.0 / (m.diagonal.x + m.diagonal.y + m.diagonal.z);
    let a = scaled(scale, m);
    let adjugate = adjugate_of(a);
    return scaled(scale / determinant(a, adjugate), adjugate);
}
