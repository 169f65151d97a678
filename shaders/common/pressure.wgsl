// What the solver of velocities without divergence keeps of a particle.
import package::common::{params::params, cells::is_air, matter::inverse_mass_of};
import package::common::params::TWO_WAY;
import package::common::sph_kernels::spiky_factor;

// What pressure did in the last step, from which the next one starts.
struct Pressed {
    change: vec3f,   // m/s, what pressure changed the velocity by
    pressure: f32,   // m^2/s, lambda: pressure over density, times the step
}

// A symmetric matrix B that corrects the gradients of the kernel at a particle, and how the particle's divergence gives way.
struct Gradients {
    diagonal: vec3f,       // of B: xx, yy, zz
    response: f32,         // 1/m^2, a: change of the divergence by a unit of the particle's own pressure
    off_diagonal: vec3f,   // of B: yz, zx, xy
}

// A symmetric matrix by which a particle pushes its neighbours, lambda B/V [1/(m s)], and the divergence that it answers.
struct Stress {
    diagonal: vec3f,
    divergence: f32,       // 1/s, s: the rate at which density rises, over the density
    off_diagonal: vec3f,
}

const THIN: f32 = 0.6;   // rho/rho_0 below which air is missing: pressure pushes there, and does not pull

// The pressure that a particle of this density may have.
fn allowed(pressure: f32, density: f32) -> f32 {
    return select(pressure, min(pressure, 0.0), density < THIN);
}

// Whether a particle is in the sums: in `two-way` the solver has to do with air only.
fn flows(i: u32) -> bool {
    return is_air(i) || params.model != TWO_WAY;
}

// What a push moves a particle by, of what it moves air by: 1 for air, 0 where a point is held.
fn share_of(i: u32) -> f32 {
    return inverse_mass_of(i) / params.air_inverse_mass;
}

// A symmetric matrix times a vector.
fn times(diagonal: vec3f, off_diagonal: vec3f, v: vec3f) -> vec3f {
    return diagonal * v + off_diagonal.zzy * v.yxx + off_diagonal.yxx * v.zzy;
}

// What the pairs of a particle share: read once, not once per neighbour.
struct Pairs {
    own: vec3f,             // m, position of the particle
    first_periodic: u32,    // index from which on neighbours are met through the periodic faces: air's, if the particle is air
    box_size: vec3f,        // m
    slope: f32,             // 1/m^4, 45/(pi h^4)
    per_box: vec3f,         // 1/m
    per_radius: f32,        // 1/m, 1/h
}

const SMALLEST_GAP: f32 = 1e-6;   // h; what is nearer has no direction

fn pairs_of(i: u32, own: vec3f) -> Pairs {
    let first = select(params.particles, params.hair_points, is_air(i));
    let h = params.kernel_radius;
    return Pairs(own, first, params.box_size, spiky_factor(), 1.0 / params.box_size, 1.0 / h);
}

// x_i - x_j [m].
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
