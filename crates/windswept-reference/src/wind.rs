//! The wind enters, and lifts and drags hair that no air particle reaches.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};
use windswept_scene::{InflowWave, Model, Strands};

use crate::Parameters;

/// Part of the wind that has risen after `steps` steps.
#[must_use]
pub fn risen(p: &Parameters, steps: u64) -> f64 {
    if p.ramp > 0.0 { (steps as f64 * p.step / p.ramp).min(1.0) } else { 1.0 }
}

/// The mean wind after `steps` steps \[m/s\]: what has risen of U, and what gusts add, linear between their keyframes.
#[must_use]
pub fn blow(p: &Parameters, steps: u64) -> DVec3 {
    let time = steps as f64 * p.step;
    let gust = match p.gust.iter().position(|(at, _)| *at > time) {
        Some(0) => p.gust[0].1,
        Some(next) => {
            let ((a, from), (b, to)) = (p.gust[next - 1], p.gust[next]);
            from.lerp(to, (time - a) / (b - a))
        }
        None => p.gust.last().map_or(DVec3::ZERO, |(_, last)| *last),
    };
    p.wind * risen(p, steps) + gust
}

/// What the wind brings in at `position` after `steps` steps \[m/s\]: the mean wind, and waves that it has carried along.
fn brought(p: &Parameters, steps: u64, position: DVec3) -> DVec3 {
    let wind = blow(p, steps + 1);
    let ends = |step| 0.5 * p.step * (blow(p, step) + blow(p, step + 1));
    let way: DVec3 = if p.inflow.is_empty() { DVec3::ZERO } else { (0..steps).map(ends).sum() };
    let eddy = |wave: &InflowWave| wave.amplitude * (wave.number.dot(position - way) + wave.phase).sin();
    wind + wind.length() * p.inflow.iter().map(eddy).sum::<DVec3>()
}

/// How far `position` is behind the face that the wind enters through on an axis \[m\].
#[must_use]
pub fn depth(p: &Parameters, wind: DVec3, axis: usize, position: DVec3) -> f64 {
    if wind[axis] >= 0.0 { position[axis] } else { p.box_size[axis] - position[axis] }
}

/// What the wind adds to air at `position` that moves with `velocity` in step number `steps` \[m/s\].
///
/// The mean wind's change, then v += (1 − e^{−σΔt})(U + u' − v), u' the turbulence that the wind brings in, σ = 10 max(|U|, 0.3 m/s)/ℓ sin²(π x/ℓ) within the thickness
/// ℓ of the face that U enters through; several faces count with the cosines of U.
#[must_use]
pub fn fringe(p: &Parameters, steps: u64, position: DVec3, velocity: DVec3) -> DVec3 {
    let (wind, before) = (blow(p, steps + 1), blow(p, steps));
    let (change, speed) = (wind - before, wind.length());
    if speed == 0.0 {
        return change;
    }
    let mut sigma = 0.0;
    for axis in 0..3 {
        let depth = depth(p, wind, axis, position);
        if depth < p.fringe {
            let cosine = wind[axis].abs() / speed;
            sigma += cosine * 10.0 * speed.max(0.3) / p.fringe * (PI * depth / p.fringe).sin().powi(2);
        }
    }
    change + (1.0 - (-sigma * p.step).exp()) * (brought(p, steps, position) - (velocity + change))
}

/// What lift and drag from a wind U change the velocity of each hair point by \[m/s\].
///
/// Each point takes half of D and F of the segments beside it: (I + Δt w D) δv = Δt w (D (U − v) + F), implicit in the
/// point's velocity with D and F of the committed state; nothing at a clamped point. `x` in m, `v` in m/s, `inverse_mass`
/// w in 1/kg, per hair point; `wind` U in m/s.
#[must_use]
pub fn drag(p: &Parameters, hair: &Strands, wind: DVec3, x: &[DVec3], v: &[DVec3], inverse_mass: &[f64]) -> Vec<DVec3> {
    let mut resistance = vec![DMat3::ZERO; hair.positions.len()];
    let mut lift = vec![DVec3::ZERO; hair.positions.len()];
    for s in 0..hair.len() {
        for (k, a) in hair.segments(s).zip(hair.points(s)) {
            let b = a + 1;
            if exposed(p, 0.5 * (x[a] + x[b])) {
                let slip = wind - 0.5 * (v[a] + v[b]);
                let (of_drag, of_lift) = segment(p, x[b] - x[a], slip, hair.radius[k], hair.fibres[k]);
                for point in [a, b] {
                    resistance[point] += 0.5 * of_drag;
                    lift[point] += 0.5 * of_lift;
                }
            }
        }
    }
    let change = |i: usize| {
        let share = p.step * inverse_mass[i];
        (DMat3::IDENTITY + share * resistance[i]).inverse() * (share * (resistance[i] * (wind - v[i]) + lift[i]))
    };
    (0..hair.positions.len()).map(change).collect()
}

/// Whether a segment with its middle there is in the wind itself: all are where the scene has no air particles, else
/// those outside their box.
fn exposed(p: &Parameters, middle: DVec3) -> bool {
    match p.model {
        Model::Drag => true,
        Model::Particles => !(middle.cmpge(DVec3::ZERO).all() && middle.cmplt(p.box_size).all()),
        Model::None => false,
    }
}

/// Resistance D \[kg/s\] and lift F \[N\] of a segment of `fibres` fibres along `axis` \[m\] in air that passes with u =
/// `slip` \[m/s\]; its drag is D u. u_n is what of u is normal to the axis, t its direction, A = 2 r l the frontal area.
///
/// ```text
///        t ^       D = k_n (I − t tᵀ) + k_t t tᵀ
///    u     |  l    k_n = ½ρA C_d |u_n|,  C_d = 1 + 10 Re^(−2/3)       a cylinder across (White, Viscous Fluid Flow)
///   ---->  |       k_t = ½ρA 5.4 √(ν |u_n|/2r)                        laminar skin friction (Taylor 1952)
///                  F = ½ρA C_l |u_n| (t × u)
/// ```
/// Re = 2r |u_n|/ν; C_d |u_n| is written without it, for it is 0 at rest and Re^(−2/3) is not.
fn segment(p: &Parameters, axis: DVec3, slip: DVec3, radius: f64, fibres: f64) -> (DMat3, DVec3) {
    let length = axis.length();
    if length == 0.0 {
        return (DMat3::ZERO, DVec3::ZERO);
    }
    let tangent = axis / length;
    let speed = (slip - slip.dot(tangent) * tangent).length();
    let (nu, width) = (p.kinematic_viscosity, 2.0 * radius);
    let half_rho_area = 0.5 * p.rest_density * width * length * fibres;
    let normal = half_rho_area * (speed + 10.0 * (width / nu).powf(-2.0 / 3.0) * speed.cbrt());
    let tangential = half_rho_area * 5.4 * (nu * speed / width).sqrt();
    let along = DMat3::from_cols(tangent * tangent.x, tangent * tangent.y, tangent * tangent.z);
    let resistance = normal * (DMat3::IDENTITY - along) + tangential * along;
    (resistance, half_rho_area * p.lift * speed * tangent.cross(slip))
}
