//! The wind enters; air lifts and drags hair, and hair slows the air.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};
use windswept_scene::{InflowWave, Model, Strands};

use crate::{Parameters, grid::Neighbours, rods::Load, sph_kernels::poly6};

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

/// Part of the mean wind that a hair point feels where the air is this thin, ρ/ρ0: below it air counts by what is there.
const THIN: f64 = 0.5;
/// Width of the strip of air that a strand slows, in kernel radii: fitted to fixed strands of 10 to 1000 fibres.
const WAKE: f64 = 1.3;
/// Most that a fibre's own wake is taken to have slowed the air at it. More would be in air that passes at less than a
/// centimetre a second: there is no wake, but viscosity.
const OWN_WAKE: f64 = 1.1;

/// The air at a hair point.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Local {
    /// Where the point drifted to \[m\].
    pub position: DVec3,
    /// θ, the part of its surroundings that air particles fill.
    pub filled: f64,
    /// u \[m/s\]
    pub wind: DVec3,
    /// G \[1/kg\]: what an impulse on each hair point near it changes u by.
    pub give: f64,
}

/// The mean wind alone.
#[must_use]
pub fn undisturbed(wind: DVec3) -> Local {
    Local { wind, ..Local::default() }
}

/// w_ij = V_j W(y_i − x_j)/max(θ_i, 1/2): with which an air particle of `volume` at `position` counts for a hair point.
#[must_use]
pub fn weight(p: &Parameters, local: &Local, position: DVec3, volume: f64) -> f64 {
    volume * poly6((local.position - position).length(), p.kernel_radius) / local.filled.max(THIN)
}

/// The air at every hair point, after the density constraint: θ_i = Σ_j V_j W, u_i = Σ_j w_ij v_j + (1 − Σ_j w_ij) U over air,
/// G_i = Σ_k W/ρ0 over hair, itself included.
#[must_use]
pub fn sample(p: &Parameters, wind: DVec3, x: &[DVec3], v: &[DVec3], volume: &[f64], near: &Neighbours) -> Vec<Local> {
    let h = p.kernel_radius;
    let each = |i: usize| {
        let (air, hair): (Vec<_>, Vec<_>) = near.of(i).partition(|&j| p.is_air(j));
        let number = |j: usize| poly6((x[i] - x[j]).length(), h);
        let filled = air.iter().map(|&j| volume[j] * number(j)).sum();
        let give = (number(i) + hair.iter().map(|&k| number(k)).sum::<f64>()) / p.rest_density;
        let mut local = Local { position: x[i], filled, wind, give };
        local.wind += air.iter().map(|&j| weight(p, &local, x[j], volume[j]) * (v[j] - wind)).sum::<DVec3>();
        local
    };
    (0..p.hair_points).map(each).collect()
}

/// What hair gives back to each air particle \[m/s\]: v_j −= Σ_i w_ij J_i/m_j over hair, with the weights that it was
/// sampled with; `impulse` J per hair point \[N s\].
#[must_use]
pub fn react(
    p: &Parameters,
    local: &[Local],
    impulse: &[DVec3],
    x: &[DVec3],
    volume: &[f64],
    inverse_mass: &[f64],
    near: &Neighbours,
) -> Vec<DVec3> {
    let given = |j: usize| {
        let hair = near.of(j).filter(|&i| !p.is_air(i));
        -inverse_mass[j] * hair.map(|i| weight(p, &local[i], x[j], volume[j]) * impulse[i]).sum::<DVec3>()
    };
    (p.hair_points..x.len()).map(given).collect()
}

/// Lift and drag of the air on each hair point, and how many of them had to be limited.
///
/// Each point takes half of D and F of the segments beside it, u the mean of its two points' less the segment's own
/// velocity, with tangents of `x` \[m\] and velocities `v` \[m/s\] that lead the step ([`crate::rods::ahead`]). D_n is the larger
/// eigenvalue of D; what D resists less along the fibre is left where v is:
///
/// ```text
///   force = D (u − v) + D_n v + F,   resistance = D_n       both times min(1, 1/(Δt G D_n))
/// ```
/// The limit is where air and hair near a point would have one velocity after the step.
#[must_use]
pub fn drag(p: &Parameters, hair: &Strands, local: &[Local], x: &[DVec3], v: &[DVec3]) -> (Vec<Load>, usize) {
    let mut resistance = vec![DMat3::ZERO; hair.positions.len()];
    let mut largest = vec![0.0; hair.positions.len()];
    let mut lift = vec![DVec3::ZERO; hair.positions.len()];
    for s in 0..hair.len() {
        for (k, a) in hair.segments(s).zip(hair.points(s)) {
            let b = a + 1;
            if exposed(p, 0.5 * (x[a] + x[b])) {
                let slip = 0.5 * (local[a].wind + local[b].wind) - 0.5 * (v[a] + v[b]);
                let filled = 0.5 * (local[a].filled.min(THIN) + local[b].filled.min(THIN)) / THIN;
                let of = segment(p, x[b] - x[a], slip, hair.radius[k], hair.fibres[k], filled);
                for point in [a, b] {
                    resistance[point] += 0.5 * of.resistance;
                    largest[point] += 0.5 * of.largest;
                    lift[point] += 0.5 * of.lift;
                }
            }
        }
    }
    let mut limited = 0;
    let load = |i: usize| {
        let part = p.step * local[i].give * largest[i];
        limited += usize::from(part > 1.0);
        let left = 1.0 / part.max(1.0);
        let (d, n) = (left * resistance[i], left * largest[i]);
        Load { force: d * (local[i].wind - v[i]) + n * v[i] + left * lift[i], resistance: n }
    };
    let loads = (0..hair.positions.len()).map(load).collect();
    (loads, limited)
}

/// Whether a segment with its middle there is in the air that is sampled: with `particles` only the mean wind outside their
/// box drags.
fn exposed(p: &Parameters, middle: DVec3) -> bool {
    match p.model {
        Model::Drag | Model::TwoWay => true,
        Model::Particles => !(middle.cmpge(DVec3::ZERO).all() && middle.cmplt(p.box_size).all()),
        Model::None => false,
    }
}

/// What a segment does in the air.
struct Piece {
    /// D \[kg/s\]
    resistance: DMat3,
    /// max(k_n, k_t) \[kg/s\]
    largest: f64,
    /// F \[N\]
    lift: DVec3,
}

/// A segment of `fibres` fibres along `axis` \[m\] in air that passes with u = `slip` \[m/s\]; its drag is D u. u_n is what of u
/// is normal to the axis, t its direction, A = 2 r l the frontal area.
///
/// ```text
///        t ^       D = k_n (I − t tᵀ) + k_t t tᵀ
///    u     |  l    k_n = ½ρA C_d |u_n|,  C_d = 1 + 10 Re^(−2/3)       a cylinder across (White, Viscous Fluid Flow)
///   ---->  |       k_t = ½ρA 5.4 √(ν |u_n|/2r)                        laminar skin friction (Taylor 1952)
///                  F = ½ρA C_l |u_n| (t × u)
/// ```
/// Re = 2r |u_n|/ν; C_d |u_n| is written without it, for it is 0 at rest and Re^(−2/3) is not.
///
/// The air that was sampled has been slowed by the fibre itself, from s |u_n| to |u_n| where particles fill it: a porous
/// strip of width b in a free flow slows it by 1 + k_n/(2 ρ b l |u_n|) (Taylor 1944, Air resistance of a flat plate of very
/// porous material). So k_n is taken as s k_n(s |u_n|).
fn segment(p: &Parameters, axis: DVec3, slip: DVec3, radius: f64, fibres: f64, filled: f64) -> Piece {
    let length = axis.length();
    if length == 0.0 {
        return Piece { resistance: DMat3::ZERO, largest: 0.0, lift: DVec3::ZERO };
    }
    let tangent = axis / length;
    let speed = (slip - slip.dot(tangent) * tangent).length();
    let (nu, width) = (p.kinematic_viscosity, 2.0 * radius);
    // Of one fibre a metre long, over ρ/2.
    let across = |speed: f64| width * (speed + 10.0 * (width / nu).powf(-2.0 / 3.0) * speed.cbrt());
    let slowed = if filled > 0.0 && speed > 0.0 {
        (1.0 + filled * 0.25 * across(speed) / (WAKE * p.kernel_radius * speed)).min(OWN_WAKE)
    } else {
        1.0
    };
    let half_rho = 0.5 * p.rest_density * length * fibres;
    let normal = half_rho * slowed * across(slowed * speed);
    let tangential = half_rho * width * 5.4 * (nu * speed / width).sqrt();
    let along = DMat3::from_cols(tangent * tangent.x, tangent * tangent.y, tangent * tangent.z);
    Piece {
        resistance: normal * (DMat3::IDENTITY - along) + tangential * along,
        largest: normal.max(tangential),
        lift: half_rho * width * p.lift * speed * tangent.cross(slip),
    }
}
