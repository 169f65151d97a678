// The wall that a body is to the air near it: a plane at the distance and with the normal of the nearest surface. The
// air's own sums lack the parts of the kernels beyond that plane, which are integrals of the distance alone:
//
//   P(phi)   = 30/h (u^4/4 - u^5/5),  u = 1 - phi/h          the gradient's part, of Spiky, is -P n
//   Psi(phi) = 1/2 - 315/256 (q - 4/3 q^3 + 6/5 q^5 - 4/7 q^7 + q^9/9),  q = phi/h       the density's part, of Poly6
//
// Beyond the plane the air sees its mirror image: air as dense, with the normal velocity reversed about that of the
// body.
import package::common::{params::params, status::status};

struct Wall {
    normal: vec3f,     // unit vector out of the body
    weight: f32,       // P(phi) [1/m], and from `fluid/moments` on k = 2 P n . B n
    impulse: vec3f,    // that the particle has given the body in this step, over the mass of an air particle [m/s]
    body: u32,         // index of the body
    speed: f32,        // of the surface along its normal [m/s]
    distance: f32,     // phi, of the particle from the surface [m]
    way: f32,          // displacement of the air in a step [spacings d], at most 1; 0 far from the body
}

// distance from a body up to which density errors are fed back in full; from twice that on not at all [d]
const NEAR: f32 = 4.0;
const FAR: f32 = 9.0;        // beyond which a wall does nothing, wherever air is shifted to [d]

// P(phi), the wall's part of the gradient sum [1/m].
fn gradient_beyond(distance: f32) -> f32 {
    let u = clamp(1.0 - distance / params.kernel_radius, 0.0, 1.0);
    return 30.0 / params.kernel_radius * u * u * u * u * (0.25 - 0.2 * u);
}

// Psi(phi), the wall's part of the density; phi may be negative.
fn density_beyond(distance: f32) -> f32 {
    let q = clamp(distance / params.kernel_radius, -1.0, 1.0);
    let q2 = q * q;
    return 0.5 - 315.0 / 256.0 * q * (1.0 + q2 * (-4.0 / 3.0 + q2 * (6.0 / 5.0 + q2 * (-4.0 / 7.0 + q2 / 9.0))));
}

// The way of air of this speed in a step, at a distance from a body whose surface has that velocity.
fn path_beside(distance: f32, speed: f32, velocity: vec3f) -> f32 {
    let near = clamp(2.0 - distance / (NEAR * params.spacing), 0.0, 1.0);
    let fastest = max(status.fastest_wind, max(speed, length(velocity)));
    return near * min(1.0, params.step / params.spacing * fastest);
}
