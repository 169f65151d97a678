// Data of a point for friction of hair on hair (`fluid/friction`), and the normal impulse of a pair.
import package::common::{params::params, sph_kernels::spiky_slope};

struct FrictionPoint {
    // m/s, how it would go through this step without friction, and the pull of its tangential spring
    pull: vec3f,
    multiplier: f32,     // kg m^2, sum of lambda times the relaxation over the iterations of this step
    moved: vec3f,        // m/s, how it went through the last step
    inverse_mass: f32,   // 1/kg
    friction: f32,       // Coulomb's coefficient
}

// p_ij = |(L_i V_j + L_j V_i) grad W|/dt, the impulse by which the density constraint squeezes a pair [N s], from each
// one's multiplier [kg m^2] and volume [m^3], and the distance of the two [m].
fn pressed(own: f32, volume: f32, other: f32, other_volume: f32, r: f32) -> f32 {
    return abs(own * other_volume + other * volume) * spiky_slope(r) / params.step;
}
