// The air that a hair point is dragged by.
import package::common::{params::params, sph_kernels::poly6};

struct Sampled {
    position: vec3f,   // m, y: where hair drifted to
    filled: f32,       // theta: the part of the kernel that air particles fill
    wind: vec3f,       // m/s, u
    give: f32,         // 1/kg, G: what an impulse on each hair point near it changes u by
}

const THIN: f32 = 0.5;   // rho/rho_0 below which air counts by what is there, and the mean wind takes over

// w_ij = V_j W(y_i - x_j)/max(theta_i, 1/2): with which a particle of this volume at `gap` from y counts for the point.
fn air_weight(filled: f32, gap: vec3f, volume: f32) -> f32 {
    return volume * poly6(dot(gap, gap)) / max(filled, THIN);
}
