//! Stage `turbulence`: vorticity confinement by bands of eddies (eqs. 2 to 6), air only.
//!
//! Arrays run over all particles, hair first; a quantity that only air has is zero at hair. *Band* is the accurate law,
//! *published* the law as the paper prints it, in mg and mm. Every sum is direct: over all particles, through all
//! periodic images in reach.

mod mesh;

use std::f64::consts::{E, PI, TAU};

use glam::DVec3;
pub use mesh::{Mesh, b_spline, deposit, gather, smooth, smooth_along, window};
pub(crate) use mesh::{places, spline_nodes, transformed};
use windswept_scene::{Band, Filter, Law};

use crate::{
    Parameters, State,
    forcing::depth,
    neighbours::Neighbours,
    parallel,
    sph_kernels::gradient,
    step::{Observer, Scratch},
};

/// Coefficient ε of eq. 3, read as an acceleration: a = ε ê (N × ω).
const PUBLISHED_GAIN: f64 = 0.008;
/// Millimetres in a metre.
pub const MM: f64 = 1e3;
/// Milligrams in a kilogram.
pub const MG: f64 = 1e6;
/// Most that the speed of a band may grow by in a step, of itself.
const LARGEST_GROWTH: f64 = 0.5;

/// Runs the stage: the eddies of each band are strengthened.
pub fn run(s: &mut State, w: &mut Scratch, p: &Parameters, see: &mut Observer<'_>) {
    if p.bands.is_empty() {
        return;
    }
    w.confinement = vec![DVec3::ZERO; w.predicted.len()];
    if p.turbulence.law == Law::Published {
        w.vorticity = vorticity(p, &w.predicted, &w.new_velocity, &s.volume, &w.near);
        see("turbulence/vorticity", s, w);
    }
    for (index, band) in p.bands.iter().enumerate() {
        w.band = index;
        (w.band_velocity, w.grids) = band_velocity(p, band, w.blowing, &w.predicted, &w.new_velocity, &s.volume);
        see(if p.turbulence.filter.is_grid() { "turbulence/gather" } else { "turbulence/band" }, s, w);
        if p.turbulence.law == Law::Band {
            w.vorticity = vorticity(p, &w.predicted, &w.band_velocity, &s.volume, &w.near);
            see("turbulence/vorticity", s, w);
        }
        let own = confine(
            p,
            band,
            w.blowing,
            &w.predicted,
            &w.band_velocity,
            &w.vorticity,
            &s.volume,
            &s.inverse_mass,
            &w.near,
        );
        w.confinement.iter_mut().zip(own).for_each(|(sum, own)| *sum += own);
        see("turbulence/confine", s, w);
    }
    let mean = if p.turbulence.conserve_momentum { mean(p, &w.confinement) } else { DVec3::ZERO };
    let stronger = strengthen(p, &w.new_velocity, &w.confinement, mean);
    s.confinement_impulse += impulse(p, &s.inverse_mass, &w.new_velocity, &stronger);
    w.new_velocity = stronger;
    see("turbulence/strengthen", s, w);
}

/// Mexican hat ψ(r, s) = 2/(√15 π^(3/4) s^(3/2)) (3 − r²/s²) exp(−r²/2s²) of L2 norm 1 in space (eq. 6, with the
/// radical over 15 only). The unit is that of s to the power −3/2.
#[must_use]
pub fn mexican_hat(r: f64, s: f64) -> f64 {
    let square = (r / s).powi(2);
    2.0 / (15.0_f64.sqrt() * PI.powf(0.75) * s.powf(1.5)) * (3.0 - square) * (-0.5 * square).exp()
}

/// Largest gain of the hat, at k s = √2: 2.535871705 s^(3/2).
#[must_use]
pub fn peak_gain(s: f64) -> f64 {
    2.0 / (15.0_f64.sqrt() * PI.powf(0.75)) * TAU.powf(1.5) * s.powf(1.5) * 2.0 / E
}

/// Velocity of a band of eddies at each air particle by the scene's filter: [`band`], or [`deposit`], [`smooth`] and
/// [`gather`]; and the grids that they leave, empty without a grid.
#[must_use]
pub fn band_velocity(
    p: &Parameters,
    band: &Band,
    wind: DVec3,
    x: &[DVec3],
    v: &[DVec3],
    volume: &[f64],
) -> (Vec<DVec3>, [Mesh; 2]) {
    match p.turbulence.filter {
        Filter::Direct(_) => (self::band(p, band, wind, x, v, volume), Default::default()),
        Filter::Grid(_) => {
            let deposited = deposit(p, p.grid_scale(band), wind, x, v, volume);
            let curved = smooth(p, band.scale, &deposited);
            (gather(p, band, &curved, x), [deposited, curved])
        }
    }
}

/// Velocity of a band of eddies at each air particle (eq. 5), of what lies within the cut-off, itself included.
///
/// Band: û_i = Σ_j V_j (v_j − U) ψ/peak over air \[m/s\], gain 1 at the band's centre. Published: v̂_i = Σ_j v_j ψ over
/// air and hair in mm and s \[mm^(−1/2)/s\]. `wind` U, `v` in m/s, `x` in m, `volume` in m³.
#[must_use]
pub fn band(p: &Parameters, band: &Band, wind: DVec3, x: &[DVec3], v: &[DVec3], volume: &[f64]) -> Vec<DVec3> {
    let s = band.scale;
    let hat = |i: usize, j: usize, unit: f64| {
        over_images(p, i, j, x[i] - x[j], p.cutoff * s, |r| mexican_hat(unit * r, unit * s))
    };
    parallel::map(x.len(), |i| {
        if !p.is_air(i) {
            return DVec3::ZERO;
        }
        match p.turbulence.law {
            Law::Band => {
                let sum: DVec3 = (p.hair_points..x.len()).map(|j| volume[j] * hat(i, j, 1.0) * (v[j] - wind)).sum();
                sum / peak_gain(s)
            }
            Law::Published => (0..x.len()).map(|j| hat(i, j, MM) * MM * v[j]).sum(),
        }
    })
}

/// Sum of f(r) over the images of j that are within `reach` of i, with `gap` = x_i − x_j: all periodic images where
/// both are air, else j itself.
fn over_images(p: &Parameters, i: usize, j: usize, gap: DVec3, reach: f64, f: impl Fn(f64) -> f64) -> f64 {
    if p.far_apart(gap, reach) {
        return 0.0;
    }
    let periodic = p.is_air(i) && p.is_air(j);
    let shifts = |axis: usize| {
        let (gap, side) = (gap[axis], p.box_size[axis]);
        if periodic { ((-reach - gap) / side).ceil() as i32..=((reach - gap) / side).floor() as i32 } else { 0..=0 }
    };
    let mut sum = 0.0;
    for a in shifts(0) {
        for b in shifts(1) {
            for c in shifts(2) {
                let r = (gap + p.box_size * DVec3::new(a.into(), b.into(), c.into())).length();
                if r <= reach {
                    sum += f(r);
                }
            }
        }
    }
    sum
}

/// Sum of the cosines to `wind` of the faces whose fringe `position` is in.
fn fringed(p: &Parameters, wind: DVec3, position: DVec3) -> f64 {
    let cosines = wind.try_normalize().unwrap_or(DVec3::ZERO);
    let within = |axis: &usize| p.fringe > 0.0 && depth(p, wind, *axis, position) < p.fringe;
    (0..3).filter(within).map(|axis| cosines[axis].abs()).sum()
}

/// Whether a particle takes part in the sums over neighbours: hair does in the published law only.
fn counts(p: &Parameters, i: usize) -> bool {
    p.is_air(i) || p.turbulence.law == Law::Published
}

/// Vorticity ω_i = Σ_j V_j (v_j − v_i) × ∇_j W \[1/s\], the curl of a velocity field `v` \[m/s\] (eq. 2 with its
/// 1/ρ_j), the plain sum: 0.945 of it on the paper's simple cubic lattice. Zero at particles that do not count.
#[must_use]
pub fn vorticity(p: &Parameters, x: &[DVec3], v: &[DVec3], volume: &[f64], near: &Neighbours) -> Vec<DVec3> {
    let pair = |i: usize, j: usize| {
        let own_gradient = gradient(p.separation(i, j, x[i], x[j]), p.kernel_radius);
        volume[j] * (v[j] - v[i]).cross(-own_gradient)
    };
    let at = |i: usize| {
        let others = near.of(i).filter(|&j| counts(p, i) && counts(p, j));
        others.map(|j| pair(i, j)).sum()
    };
    (0..x.len()).map(at).collect()
}

/// Change Δv of each air particle's velocity by a band in a step \[m/s\] (eqs. 3, 4). In the fringe of the wind
/// `wind` it is smaller by the cosines of the faces.
///
/// N = η/(|η| + 1e-3 |ω|/h) points to where the vorticity is larger, η_i = Σ_j V_j (|ω_j| − |ω_i|) ∇_i W.
///
/// * Band: Δv = |û| min(½, [`growth`]) along N × ω, of the law a = S |û| max(0, 1 − |û|²/u²) (N × ω) with u = min(I U,
///   h/Δt); ω that of û.
/// * Published: Δv = Δt a, a = 0.008 ê (N × ω) mm/s², ê = ½ m |v̂|² in mg, mm, s; ω that of v.
///
/// `eddies` is what [`band`] returns, `omega` what [`vorticity`] returns; `volume` in m³, `inverse_mass` in 1/kg.
#[must_use]
pub fn confine(
    p: &Parameters,
    band: &Band,
    wind: DVec3,
    x: &[DVec3],
    eddies: &[DVec3],
    omega: &[DVec3],
    volume: &[f64],
    inverse_mass: &[f64],
    near: &Neighbours,
) -> Vec<DVec3> {
    let change = |i: usize| {
        let left = (1.0 - fringed(p, wind, x[i])).max(0.0);
        if !p.is_air(i) || left == 0.0 {
            return DVec3::ZERO;
        }
        let own = omega[i].length();
        let toward = |j: usize| {
            let gradient = gradient(p.separation(i, j, x[i], x[j]), p.kernel_radius);
            volume[j] * (omega[j].length() - own) * gradient
        };
        let eta: DVec3 = near.of(i).filter(|&j| counts(p, j)).map(toward).sum();
        let scale = eta.length() + 1e-3 * own / p.kernel_radius;
        if scale == 0.0 {
            return DVec3::ZERO;
        }
        let swirl = (eta / scale).cross(omega[i]);
        let speed = eddies[i].length();
        let change = match p.turbulence.law {
            Law::Band => {
                let rate = band.strength * swirl.length();
                let largest = (band.intensity * p.turbulence.speed).min(p.kernel_radius / p.step);
                let growth = growth(speed / largest, rate, p.step);
                speed * growth.min(LARGEST_GROWTH) * swirl.normalize_or_zero()
            }
            Law::Published => {
                let energy = 0.5 * MG / inverse_mass[i] * speed * speed;
                p.step * PUBLISHED_GAIN * energy * swirl / MM
            }
        };
        left * change
    };
    (0..x.len()).map(change).collect()
}

/// Growth u/u_0 − 1 by du/dt = `rate` u (1 − u²) in the time `step` \[s\], from u_0 = `part`; 0 where that is 1 or
/// more.
#[must_use]
pub fn growth(part: f64, rate: f64, step: f64) -> f64 {
    let (square, x) = (part.powi(2).min(1.0), -2.0 * rate * step);
    let left = (square + (1.0 - square) * x.exp()).max(f64::MIN_POSITIVE).sqrt();
    (1.0 - square) * -x.exp_m1() / (left + left * left)
}

/// Mean change of all air \[m/s\], which is taken out where momentum is conserved: confinement drives no wind.
#[must_use]
pub fn mean(p: &Parameters, change: &[DVec3]) -> DVec3 {
    let air = &change[p.hair_points..];
    air.iter().sum::<DVec3>() / air.len() as f64
}

/// Velocities v_i + change_i − mean of air; hair keeps its own \[m/s\].
#[must_use]
pub fn strengthen(p: &Parameters, v: &[DVec3], change: &[DVec3], mean: DVec3) -> Vec<DVec3> {
    let own = |i: usize| if p.is_air(i) { change[i] - mean } else { DVec3::ZERO };
    (0..v.len()).map(|i| v[i] + own(i)).collect()
}

/// Impulse Σ m Δv on the air \[kg m/s\].
#[must_use]
pub fn impulse(p: &Parameters, inverse_mass: &[f64], before: &[DVec3], after: &[DVec3]) -> DVec3 {
    (p.hair_points..after.len()).map(|i| (after[i] - before[i]) / inverse_mass[i]).sum()
}
