// Inverse mass and XSPH coefficient of a particle: one value for all air, one mass per point for hair.
import package::common::{params::params, cells::is_air};

const MOST_EDDIES: f32 = 0.25;   // c of unresolved eddies: above a half XSPH overshoots

struct Exchange {
    share: f32,    // S: the part of its velocity that a particle would exchange
    eddies: f32,   // c of unresolved eddies; hair has none
}

@group(0) @binding(2) var<storage, read> inverse_mass: array<f32>;   // of each hair point [1/kg], 0 where it is held

fn inverse_mass_of(i: u32) -> f32 {
    if is_air(i) { return params.air_inverse_mass; }
    return inverse_mass[i];
}

// XSPH coefficient of a particle. A pair has the smaller of its two (eq. 8).
fn viscosity_of(i: u32) -> f32 {
    return select(params.viscosity_hair, params.viscosity_air, is_air(i));
}
