// Inverse mass and XSPH coefficient of a particle: one value for all air, one mass per point for hair.
import package::common::{params::params, cells::is_air};

const MAX_EDDIES: f32 = 0.25;   // c of unresolved eddies: above a half XSPH overshoots

struct Exchange {
    share: f32,         // S: the part of its velocity that a particle would exchange
    deformation: f32,   // |G| dt: how the flow deforms air in a step (`fluid/deform`); 0 for hair
}

@group(0) @binding(2) var<storage, read> inverse_mass: array<f32>;   // of each hair point [1/kg], 0 where it is held

fn inverse_mass_of(i: u32) -> f32 {
    if is_air(i) { return params.air_inverse_mass; }
    return inverse_mass[i];
}

// XSPH coefficient of a particle whose flow deforms by `deformation` in a step. A pair has the smaller of its two (eq.
// 8). Eddies that the spacing does not resolve add theirs, nu = (C d)^2 |G| (Smagorinsky 1963), which is c = 22 (C
// d/h)^2 |G| dt.
fn viscosity_of(i: u32, deformation: f32) -> f32 {
    let eddies = min(MAX_EDDIES, params.viscosity_eddies * deformation);
    return select(params.viscosity_hair, params.viscosity_air, is_air(i)) + eddies;
}
