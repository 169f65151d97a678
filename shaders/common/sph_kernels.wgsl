// Smoothing kernels (Mueller et al. 2003): Poly6 for densities, Spiky's gradient for corrections.
import package::common::{params::params, pi::PI};

// W(r) = 315/(64 pi h^9) (h^2 - r^2)^3 is this times (1 - (r/h)^2)^3 [1/m^3]: so nothing leaves the range of f32.
fn poly6_factor() -> f32 {
    let h = params.kernel_radius;
    return 315.0 / (64.0 * PI * h * h * h);
}

// |grad W| = 45/(pi h^6) (h - r)^2; the gradient points from i to j: grad_i W = -|grad W| (x_i - x_j)/r.
fn spiky_slope(r: f32) -> f32 {
    let q = max(1.0 - r / params.kernel_radius, 0.0);
    return spiky_factor() * q * q;
}

// 45/(pi h^4) [1/m^4].
fn spiky_factor() -> f32 {
    let h = params.kernel_radius;
    return 45.0 / (PI * h * h * h * h);
}

// A random number from a number: PCG (Jarzynski & Olano 2020, Hash Functions for GPU Rendering).
fn pcg(x: u32) -> u32 {
    let state = x * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

// Unit vector from j to i. Coincident particles get a random one, and (j, i) its opposite, so that they separate.
fn direction(i: u32, j: u32, gap: vec3f, r: f32) -> vec3f {
    if r >= 1e-6 * params.kernel_radius {
        return gap / r;
    }
    let first = pcg(min(i, j) ^ pcg(max(i, j)));
    let second = pcg(first);
    let z = 2.0 * f32(first) / 4294967296.0 - 1.0;
    let angle = 2.0 * PI * f32(second) / 4294967296.0;
    let ring = sqrt(max(1.0 - z * z, 0.0));
    let random = vec3f(ring * cos(angle), ring * sin(angle), z);
    return select(-random, random, i < j);
}

// grad_i W of Spiky [1/m^4], from `gap` = x_i - x_j [m].
fn spiky_gradient(i: u32, j: u32, gap: vec3f) -> vec3f {
    let r = length(gap);
    return -spiky_slope(r) * direction(i, j, gap, r);
}
