//! Air lifts and drags hair, and hair slows the air.

use glam::{DMat3, DVec3};
use windswept_scene::{Model, Strands};

use super::{Load, Moving, Point, STORMY, StrandMotion};
use crate::{Parameters, neighbours::Neighbours, sph_kernels::poly6, state, step::Scratch};

/// Part of the mean wind that a hair point feels where the air is this thin, ρ/ρ0: below it air counts by what is
/// there.
const THIN: f64 = 0.5;
/// Width of the strip of air that a strand slows, in kernel radii: fitted to fixed strands of 10 to 1000 fibres.
const WAKE: f64 = 1.3;
/// Most that a fibre's own wake is taken to have slowed the air at it. More would be in air that passes at less than a
/// centimetre a second: there is no wake, but viscosity.
const OWN_WAKE: f64 = 1.1;
/// Lengths of the strand that the air passes by in a step, beyond which drag has no direction.
const LENGTHS: f64 = 8.0;

/// Air at a hair point.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Local {
    /// Place to which the point drifted \[m\].
    pub position: DVec3,
    /// Part θ of the point's surroundings that air particles fill.
    pub filled: f64,
    /// Velocity u of the air \[m/s\].
    pub wind: DVec3,
    /// Change G of u by a unit of impulse on each hair point nearby \[1/kg\].
    pub give: f64,
}

/// Air that is the mean wind alone.
#[must_use]
pub fn undisturbed(wind: DVec3) -> Local {
    Local { wind, ..Local::default() }
}

/// Part to which the mean wind counts at a hair point, 1 − Σ_j w_ij: all where there is no air.
#[must_use]
pub fn undisturbed_part(local: &Local) -> f64 {
    1.0 - local.filled.min(THIN) / THIN
}

/// Weight w_ij = V_j W(y_i − x_j)/max(θ_i, 1/2) with which an air particle of `volume` at `position` counts for a hair
/// point.
#[must_use]
pub fn weight(p: &Parameters, local: &Local, position: DVec3, volume: f64) -> f64 {
    volume * poly6((local.position - position).length(), p.kernel_radius) / local.filled.max(THIN)
}

/// Air at every hair point, after the density constraint: θ_i = Σ_j V_j W, u_i = Σ_j w_ij v_j + (1 − Σ_j w_ij) U over
/// air, G_i = Σ_k W/ρ0 over hair, itself included.
#[must_use]
pub fn sample_air(
    p: &Parameters,
    wind: DVec3,
    x: &[DVec3],
    v: &[DVec3],
    volume: &[f64],
    near: &Neighbours,
) -> Vec<Local> {
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

/// Change of each air particle's velocity by hair \[m/s\]: v_j −= Σ_i w_ij J_i/m_j over hair, with the weights that the
/// air was sampled with; `impulse` J per hair point \[N s\].
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

/// Adds the drag of the air to the load of each hair point, each strand's where its own step takes it. A strand that
/// the air resists by more than BDF2 bears takes Euler.
pub(super) fn act(s: &mut state::State, w: &mut Scratch, p: &Parameters) {
    let (mut loads, mut limited) = taken(s, w, p);
    let follows = |strand: usize| follows_wind(p, &s.hair, strand, &w.motions[strand], &w.moving, &loads);
    let hasty: Vec<_> = (0..s.hair.len()).filter(|&strand| !follows(strand)).collect();
    if !hasty.is_empty() {
        hasty.iter().for_each(|&strand| w.motions[strand].step = p.step);
        (loads, limited) = taken(s, w, p);
    }
    w.moving.points.iter_mut().zip(loads).for_each(|(point, load)| point.load += load);
    s.limited += limited;
}

/// Drag of the air on each hair point where its strand's step takes it, and how many had to be limited.
fn taken(s: &state::State, w: &Scratch, p: &Parameters) -> (Vec<Load>, usize) {
    let all = (0..s.hair.len()).flat_map(|strand| s.hair.points(strand).map(move |i| (strand, i)));
    let (x, v): (Vec<_>, Vec<_>) =
        all.map(|(strand, i)| ahead(p, &w.moving.points[i], s.position[i], w.motions[strand].step)).unzip();
    drag(p, &s.hair, &w.local, &x, &v)
}

/// Place where the drag of a point is taken, and the velocity that it is taken with: in a step of BDF2 x_n + Δt (3/2
/// v_n − 1/2 v_{n−1}) and 2 v_n − v_{n−1}, in one of Euler x_n and v_n.
///
/// Drag that is taken at the step's start is of first order, and hair in a storm flutters under BDF2. Under Euler hair
/// stands still only where nothing is extrapolated.
#[must_use]
pub fn ahead(p: &Parameters, point: &Point, position: DVec3, h: f64) -> (DVec3, DVec3) {
    if h < p.step {
        let (now, before) = (point.velocity, point.before);
        (position + p.step * (1.5 * now - 0.5 * before), 2.0 * now - before)
    } else {
        (position, point.velocity)
    }
}

/// Whether `drag` resists no point of a strand by more than BDF2 bears: the drag that BDF2 extrapolates grows into a
/// flutter from Δt w D_n = 0.39 on (hairs of 30 to 60 µm, 1 and 4 GPa, 30 to 100 mm in 3 to 20 m/s).
#[must_use]
pub fn follows_wind(
    p: &Parameters,
    hair: &Strands,
    strand: usize,
    motion: &StrandMotion,
    m: &Moving,
    drag: &[Load],
) -> bool {
    let resisted = |i: usize| p.step * m.points[i].inverse_mass * drag[i].resistance > STORMY;
    motion.step == p.step || !hair.points(strand).any(resisted)
}

/// Lift and drag of the air on each hair point, and how many of them had to be limited.
///
/// Each point takes half of D and F of the segments beside it, u the mean of its two points' less the segment's own
/// velocity, with tangents of `x` \[m\] and velocities `v` \[m/s\] that lead the step ([`ahead`]). D_n is the larger
/// eigenvalue of D; the smaller resistance along the fibre is corrected with v as it is:
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
        let strand_length: f64 = hair.rest_length[hair.segments(s)].iter().sum();
        for (k, a) in hair.segments(s).zip(hair.points(s)) {
            let b = a + 1;
            if exposed(p, 0.5 * (x[a] + x[b])) {
                let slip = 0.5 * (local[a].wind + local[b].wind) - 0.5 * (v[a] + v[b]);
                let filled = 0.5 * (local[a].filled.min(THIN) + local[b].filled.min(THIN)) / THIN;
                let of = segment(p, strand_length, x[b] - x[a], slip, hair.radius[k], hair.fibres[k], filled);
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

/// Whether a segment with its middle there is in the air that is sampled: with `particles` only the mean wind outside
/// their box drags.
fn exposed(p: &Parameters, middle: DVec3) -> bool {
    match p.interaction.model {
        Model::Drag | Model::TwoWay => true,
        Model::Particles => !(middle.cmpge(DVec3::ZERO).all() && middle.cmplt(p.box_size).all()),
        Model::None => false,
    }
}

/// Drag and lift of a segment.
struct Piece {
    /// Drag matrix D \[kg/s\].
    resistance: DMat3,
    /// Larger eigenvalue of D, max(k_n, k_t) \[kg/s\].
    largest: f64,
    /// Lift F \[N\].
    lift: DVec3,
}

/// Drag and lift of a segment of `fibres` fibres along `axis` \[m\] in air that passes with u = `slip` \[m/s\]; its
/// drag is D u. u_n is what of u is normal to the axis, t its direction, A = 2 r l the frontal area.
///
/// ```text
///        t ^       D = k_n (I − t tᵀ) + k_t t tᵀ
///    u     |  l    k_n = ½ρA C_d |u_n|,  C_d = 1 + 10 Re^(−2/3)       a cylinder across (White, Viscous Fluid Flow)
///   ---->  |       k_t = ½ρA 5.4 √(ν |u_n|/2r)                        laminar skin friction (Taylor 1952)
///                  F = ½ρA C_l |u_n| (t × u)
/// ```
/// Re = 2r |u_n|/ν; C_d |u_n| is written without it, for it is 0 at rest and Re^(−2/3) is not.
///
/// The air that was sampled has been slowed by the fibre itself, from s |u_n| to |u_n| where particles fill it: a
/// porous strip of width b in a free flow slows it by 1 + k_n/(2 ρ b l |u_n|) (Taylor 1944, Air resistance of a flat
/// plate of very porous material). So k_n is taken as s k_n(s |u_n|).
///
/// The drag's direction is that of the segment as the step begins. Where the air passes by more than [`LENGTHS`]
/// lengths of the strand in a step, that would throw segments to and fro: k_t goes to k_n, by the part that is more.
fn segment(
    p: &Parameters,
    strand_length: f64,
    axis: DVec3,
    slip: DVec3,
    radius: f64,
    fibres: f64,
    filled: f64,
) -> Piece {
    let length = axis.length();
    if length == 0.0 {
        return Piece { resistance: DMat3::ZERO, largest: 0.0, lift: DVec3::ZERO };
    }
    let tangent = axis / length;
    let speed = (slip - slip.dot(tangent) * tangent).length();
    let (nu, width) = (p.kinematic_viscosity, 2.0 * radius);
    // The value is k_n of one fibre a metre long over ρ/2.
    let across = |speed: f64| width * (speed + 10.0 * (width / nu).powf(-2.0 / 3.0) * speed.cbrt());
    let slowed = if filled > 0.0 && speed > 0.0 {
        (1.0 + filled * 0.25 * across(speed) / (WAKE * p.kernel_radius * speed)).min(OWN_WAKE)
    } else {
        1.0
    };
    let half_rho = 0.5 * p.rest_density * length * fibres;
    let normal = half_rho * slowed * across(slowed * speed);
    let skin = half_rho * width * 5.4 * (nu * speed / width).sqrt();
    let directed = (LENGTHS * strand_length / (p.step * slip.length())).min(1.0);
    let tangential = normal + directed * (skin - normal);
    let along = DMat3::from_cols(tangent * tangent.x, tangent * tangent.y, tangent * tangent.z);
    Piece {
        resistance: normal * (DMat3::IDENTITY - along) + tangential * along,
        largest: normal.max(tangential),
        lift: half_rho * width * p.interaction.lift * speed * tangent.cross(slip),
    }
}
