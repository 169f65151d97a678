//! Friction of hair on hair: Coulomb's law over the pairs that the density constraint squeezes.

use glam::DVec3;

use crate::{Parameters, State, neighbours::Neighbours, sph_kernels::spiky_slope};

/// Stiffness of the tangential spring, over the largest that one step bears: with it a point that sticks comes to rest
/// without swinging, whatever share of the friction is its own.
pub const STIFFNESS: f64 = 0.25;

/// State of a hair point that friction needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrictionPoint {
    /// Velocity at which the point would go through this step without friction, and the pull of its tangential spring
    /// \[m/s\].
    pub pull: DVec3,
    /// Velocity at which the point went through the last step \[m/s\].
    pub moved: DVec3,
    /// Sum Λ of the point's multipliers times the relaxation over the iterations of this step \[kg m²\].
    pub multiplier: f64,
}

/// State of hair point `i` that friction needs. The constraint has moved the point by `correction` \[m\] in this step.
/// The change by rod and gravity is that of the point's last step awake.
#[must_use]
pub fn slip(p: &Parameters, s: &State, i: usize, correction: DVec3, multiplier: f64) -> FrictionPoint {
    let ahead = s.velocity[i] + s.own[i] + correction / p.step;
    FrictionPoint { pull: ahead + STIFFNESS * s.tangential_spring[i], moved: s.displacement[i] / p.step, multiplier }
}

/// Points of other strands near hair point `i`.
fn others<'a>(p: &'a Parameters, near: &'a Neighbours, i: usize) -> impl Iterator<Item = usize> + 'a {
    near.of(i).filter(move |&j| !p.is_air(j) && p.strand_of[i] != p.strand_of[j])
}

/// Impulse p_ij = |(Λ_i V_j + Λ_j V_i) ∇W|/Δt by which the density constraint squeezes a pair \[N s\].
fn pressed(p: &Parameters, x: &[DVec3], volume: &[f64], points: &[FrictionPoint], i: usize, j: usize) -> f64 {
    let both = points[i].multiplier * volume[j] + points[j].multiplier * volume[i];
    both.abs() * spiky_slope((x[i] - x[j]).length(), p.kernel_radius) / p.step
}

/// Squeeze w_i Σ_j p_ij of each hair point between the points of other strands \[m/s\].
#[must_use]
pub fn normal_impulse(
    p: &Parameters,
    x: &[DVec3],
    inverse_mass: &[f64],
    volume: &[f64],
    points: &[FrictionPoint],
    near: &Neighbours,
) -> Vec<f64> {
    let sum = |i: usize| others(p, near, i).map(|j| pressed(p, x, volume, points, i, j)).sum::<f64>();
    (0..p.hair_points).map(|i| inverse_mass[i] * sum(i)).collect()
}

/// Change of the velocity of each hair point by friction \[m/s\], and its next tangential spring \[m/s\]. The impulses
/// are equal and opposite between points of different strands, across the line that joins them:
///
/// ```text
///   J_ij = −k_ij u_ij,  k_ij = min(p_ij/(P_i + P_j), μ p_ij/|u_ij|)
///       u: component of the difference of pulls that is normal to x_i − x_j
///   P_i  = w_i Σ_j p_ij,  the squeeze
///   g_i ← c_i (g_i + w_i Σ_j k_ij s_ij)
///       s: of the velocities of the last step, as u of pulls
///   c_i  = Σ_j k_ij / Σ_j p_ij/(P_i + P_j)
///       1 where all pairs stick, towards 0 where they slide
/// ```
/// The first term of k_ij is the largest with which friction cannot overshoot, whatever the masses: with it the
/// impulses of all pairs take no more from any relative motion than there is. The second term is Coulomb's cap (Macklin
/// et al. 2014, eq. 24), with the constraint's own impulse for the depth. The tangential spring g is that of Cundall &
/// Strack (1979), kept by points instead of pairs: it holds a sticking point in place, and fades as the point slides.
#[must_use]
pub fn friction(
    p: &Parameters,
    x: &[DVec3],
    springs: &[DVec3],
    inverse_mass: &[f64],
    volume: &[f64],
    points: &[FrictionPoint],
    normal_impulses: &[f64],
    near: &Neighbours,
) -> (Vec<DVec3>, Vec<DVec3>) {
    let each = |i: usize| {
        let (mut change, mut slid) = (DVec3::ZERO, DVec3::ZERO);
        let (mut held, mut most) = (0.0, 0.0);
        for j in others(p, near, i) {
            let gap = x[i] - x[j];
            let (pressed, both) = (pressed(p, x, volume, points, i, j), normal_impulses[i] + normal_impulses[j]);
            if both == 0.0 || gap == DVec3::ZERO {
                continue;
            }
            let pull = (points[i].pull - points[j].pull).reject_from(gap);
            let coefficient = p.friction[p.strand_of[i]].min(p.friction[p.strand_of[j]]);
            let sticks = pressed / both;
            let share = if pull == DVec3::ZERO { sticks } else { sticks.min(coefficient * pressed / pull.length()) };
            change -= inverse_mass[i] * share * pull;
            slid += inverse_mass[i] * share * (points[i].moved - points[j].moved).reject_from(gap);
            held += share;
            most += sticks;
        }
        let spring = if most > 0.0 { held / most * (springs[i] + slid) } else { DVec3::ZERO };
        (change, spring)
    };
    (0..p.hair_points).map(each).unzip()
}
