// State of a particle in the divergence-free solver (`fluid.solver` is divergence).
import package::common::{params::{params, TWO_WAY}, cells::is_air, matter::inverse_mass_of};

// Effect of the pressure in the last step, from which the next one starts.
struct Pressed {
    change: vec3f,   // m/s, change of the velocity by pressure
    pressure: f32,   // m^2/s, lambda: pressure over density, times the step
}

// A symmetric matrix B that corrects the gradients of the kernel at a particle, and the response of the particle's
// divergence.
struct Gradients {
    diagonal: vec3f,       // of B: xx, yy, zz
    response: f32,         // 1/m^2, a: change of the divergence by a unit of the particle's own pressure
    off_diagonal: vec3f,   // of B: yz, zx, xy
}

// A symmetric matrix by which a particle pushes its neighbours, lambda B/V [1/(m s)], and the divergence against
// which it acts.
struct Stress {
    diagonal: vec3f,
    divergence: f32,       // 1/s, s: the rate at which density rises, over the density
    off_diagonal: vec3f,
    pressure: f32,         // lambda/V, by which a wall pushes the particle
}

// impulse of a push over all steps: BDF2 hands a third of it on to the next, and 1 + 1/3 + 1/9 + ... = 3/2
const LASTING: f32 = 1.5;
const THIN: f32 = 0.6;      // rho/rho_0 below which air is missing: pressure pushes there, and does not pull

// The pressure that a particle of this density may have.
fn allowed(pressure: f32, density: f32) -> f32 {
    return select(pressure, min(pressure, 0.0), density < THIN);
}

// Whether a particle is in the sums.
fn flows(i: u32) -> bool {
    return is_air(i) || params.model != TWO_WAY;
}

// Mobility of a particle under pressure, relative to air: 1 for air, 0 where a point is held.
fn share_of(i: u32) -> f32 {
    return inverse_mass_of(i) / params.air_inverse_mass;
}
