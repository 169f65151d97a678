// Means over all air, of sums over it.
import package::common::params::params;

// Particles of air; 1 without any, of which all sums are 0.
fn air_particles() -> f32 {
    return f32(max(params.particles - params.hair_points, 1u));
}

// Mean change of the air's velocity by confinement [m/s], of its sum: it is taken out where momentum is
// conserved.
fn taken_out(sum: vec3f) -> vec3f {
    return select(vec3f(0.0), sum / air_particles(), params.conserve_momentum != 0u);
}
