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
