//! BDF2 and Euler, and the rotations that they turn frames by.

use glam::{DMat3, DQuat, DVec3};

use super::Point;
use crate::Parameters;

/// Part of the last move that a step carries on: 1/3 for BDF2, whose h is 2/3 Δt, and 0 for Euler.
fn carry(p: &Parameters, h: f64) -> f64 {
    if h < p.step { 1.0 / 3.0 } else { 0.0 }
}

/// Move without the rod's forces, carry d + h (v + h a)/(1 + c h), with v = (4 v_n − v_{n−1})/3 for BDF2 and v_n for
/// Euler. `damping` is c \[1/s\].
#[must_use]
pub fn free_move(
    p: &Parameters,
    now: DVec3,
    before: DVec3,
    previous_move: DVec3,
    acceleration: DVec3,
    damping: f64,
    h: f64,
) -> DVec3 {
    let v = if h < p.step { (4.0 * now - before) / 3.0 } else { now };
    carry(p, h) * previous_move + h * (v + h * acceleration) / (1.0 + damping * h)
}

/// Velocity v_{n+1} = (move − carry d)/h.
#[must_use]
pub fn rate(p: &Parameters, shift: DVec3, previous_move: DVec3, h: f64) -> DVec3 {
    (shift - carry(p, h) * previous_move) / h
}

/// Move h²/(1 + c h) of a unit of mass by a unit of force \[s²\]. `damping` is c \[1/s\].
#[must_use]
pub fn response(damping: f64, h: f64) -> f64 {
    h * h / (1.0 + damping * h)
}

/// Damping c of a point \[1/s\]: the scene's, and what resists the point's velocity.
#[must_use]
pub fn damping(p: &Parameters, point: &Point) -> f64 {
    p.rods.damping + point.inverse_mass * point.load.resistance
}

/// Frame q turned by the small rotation vector `angle` \[rad\], world axes.
#[must_use]
pub fn turned(q: DQuat, angle: DVec3) -> DQuat {
    let spin = DQuat::from_xyzw(angle.x, angle.y, angle.z, 0.0);
    (q + spin * q * 0.5).normalize()
}

/// Rotation by |turn| about `turn` \[rad\], half a turn at most.
#[must_use]
pub fn rotation(turn: DVec3) -> DQuat {
    DQuat::from_scaled_axis(turn.clamp_length_max(std::f64::consts::PI))
}

/// Rotation vector of q, at most π long \[rad\].
#[must_use]
pub fn rotation_vector(q: DQuat) -> DVec3 {
    (if q.w < 0.0 { -q } else { q }).to_scaled_axis()
}

/// Imaginary part of the rest rotation, with the sign with which that rotation is nearer to p in 4-D.
pub(super) fn nearest_rest(p: DQuat, rest: DQuat) -> DVec3 {
    if (p - rest).length_squared() <= (p + rest).length_squared() { rest.xyz() } else { -rest.xyz() }
}

/// Matrix of the cross product with `v`.
pub(super) fn cross_matrix(v: DVec3) -> DMat3 {
    DMat3::from_cols(DVec3::new(0.0, v.z, -v.y), DVec3::new(-v.z, 0.0, v.x), DVec3::new(v.y, -v.x, 0.0))
}
