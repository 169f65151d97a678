// A particle and its neighbours: the kernels between them.
import package::common::{params::params, lanes::Near, clusters::frame, sph_kernels::{poly6_factor, spiky_factor}};

// What the pairs of a particle share: read once, not once per neighbour.
struct Pairs {
    own: vec3f,         // m, position of the particle, where it meets the others
    slope: f32,         // 1/m^4, 45/(pi h^4)
    per_radius: f32,    // 1/m, 1/h
    height: f32,        // 1/m^3, 315/(64 pi h^3)
    nearest: f32,       // m^2, square of the distance below which particles lie on one another
}

const SMALLEST_GAP: f32 = 1e-6;   // h; what is nearer has no direction

fn pairs_of(own: vec3f) -> Pairs {
    let nearest = SMALLEST_GAP * params.kernel_radius;
    return Pairs(own - frame, spiky_factor(), 1.0 / params.kernel_radius, poly6_factor(), nearest * nearest);
}

// Whether particles lie on one another.
fn coincide(pairs: Pairs, gap: vec3f) -> bool {
    return dot(gap, gap) < pairs.nearest;
}

// grad_i W of Spiky over `gap` = x_i - x_j [1/m^5]; for particles that lie on one another, which have no direction, what it tends to.
fn slope_at(pairs: Pairs, gap: vec3f) -> f32 {
    let squared = max(dot(gap, gap), pairs.nearest);
    let per_length = inverseSqrt(squared);
    let q = max(1.0 - pairs.per_radius * squared * per_length, 0.0);
    return -pairs.slope * q * q * per_length;
}

// V_j grad_i W of Spiky [1/m].
fn gradient_to(pairs: Pairs, other: Near) -> vec3f {
    let gap = pairs.own - other.at;
    return (other.volume * slope_at(pairs, gap)) * gap;
}

// grad_i W of Spiky [1/m^4], with a direction for particles that lie on one another, so that they separate.
fn gradient_apart(pairs: Pairs, i: u32, j: u32, gap: vec3f) -> vec3f {
    return select(slope_at(pairs, gap) * gap, -pairs.slope * apart(i, j), coincide(pairs, gap));
}

// A unit vector drawn from the indices of two particles, and its opposite for (j, i).
fn apart(i: u32, j: u32) -> vec3f {
    var word = (min(i, j) * 2654435769u) ^ (max(i, j) * 2246822519u);
    word = (word ^ (word >> 15u)) * 3266489917u;
    let drawn = vec3f(vec3u(word, word >> 10u, word >> 20u) & vec3u(1023u)) - 511.5;
    return select(-1.0, 1.0, i < j) * normalize(drawn);
}

// W of Poly6 [1/m^3].
fn kernel_at(pairs: Pairs, gap: vec3f) -> f32 {
    let q = max(1.0 - pairs.per_radius * pairs.per_radius * dot(gap, gap), 0.0);
    return pairs.height * q * q * q;
}

fn kernel_to(pairs: Pairs, other: Near) -> f32 {
    return kernel_at(pairs, pairs.own - other.at);
}
