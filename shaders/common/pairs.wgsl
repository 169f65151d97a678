// A particle and its neighbours: how far apart they are, and the kernels there.
import package::common::{params::params, cells::is_air, sph_kernels::{poly6_factor, spiky_factor}};

// What the pairs of a particle share: read once, not once per neighbour.
struct Pairs {
    own: vec3f,             // m, position of the particle
    first_periodic: u32,    // index from which on neighbours are met through the periodic faces: air's, if the particle is air
    box_size: vec3f,        // m
    slope: f32,             // 1/m^4, 45/(pi h^4)
    per_box: vec3f,         // 1/m
    per_radius: f32,        // 1/m, 1/h
    height: f32,            // 1/m^3, 315/(64 pi h^3)
}

const SMALLEST_GAP: f32 = 1e-6;   // h; what is nearer has no direction

fn pairs_of(i: u32, own: vec3f) -> Pairs {
    let first = select(params.particles, params.hair_points, is_air(i));
    let h = params.kernel_radius;
    return Pairs(own, first, params.box_size, spiky_factor(), 1.0 / params.box_size, 1.0 / h, poly6_factor());
}

// x_i - x_j [m]. Air meets air through the periodic faces; everything else meets directly.
fn gap_to(pairs: Pairs, j: u32, other: vec3f) -> vec3f {
    let gap = pairs.own - other;
    return gap - select(vec3f(0.0), pairs.box_size * round(pairs.per_box * gap), j >= pairs.first_periodic);
}

// Whether particles lie on one another.
fn coincide(pairs: Pairs, gap: vec3f) -> bool {
    return pairs.per_radius * length(gap) < SMALLEST_GAP;
}

// grad_i W of Spiky [1/m^4]; 0 for particles that lie on one another, which have no direction.
fn gradient_at(pairs: Pairs, gap: vec3f) -> vec3f {
    let r = pairs.per_radius * length(gap);
    let q = max(1.0 - r, 0.0);
    return select(-pairs.slope * pairs.per_radius * q * q / r, 0.0, r < SMALLEST_GAP) * gap;
}

fn gradient_to(pairs: Pairs, j: u32, other: vec3f) -> vec3f {
    return gradient_at(pairs, gap_to(pairs, j, other));
}

// W of Poly6 [1/m^3].
fn kernel_at(pairs: Pairs, gap: vec3f) -> f32 {
    let q = max(1.0 - pairs.per_radius * pairs.per_radius * dot(gap, gap), 0.0);
    return pairs.height * q * q * q;
}
