//! Cosserat rods (Kugelstadt & Schömer 2016) by Gauss-Seidel with compliance (Macklin et al. 2016); design 3.6.

use glam::{DMat3, DQuat, DVec3};
use windswept_scene::Strands;

use crate::{Parameters, State};

/// A strand is strained where a segment is stretched or crushed by more than this.
pub const STRAINED: f64 = 0.5;
/// So many steps of it on end are a warning (design 4).
pub const STRAINED_STEPS: u32 = 50;

/// A strand that went bad in the step before starts again: in its rest pose at the root, at rest.
pub fn reset(s: &mut State, strand: usize) {
    for point in s.hair.points(strand) {
        (s.position[point], s.velocity[point]) = (s.hair.positions[point], DVec3::ZERO);
    }
    for k in s.hair.segments(strand) {
        (s.orientation[k], s.angular_velocity[k]) = (s.hair.orientations[k], DVec3::ZERO);
    }
}

/// A free, damped fall of a point: v* = (v + g Δt)/(1 + c Δt), the move Δt v* capped at `largest` \[m\]. Returns the new
/// position and whether it was capped.
#[must_use]
pub fn predict(p: &Parameters, inverse_mass: f64, position: DVec3, velocity: DVec3, largest: f64) -> (DVec3, bool) {
    if inverse_mass == 0.0 {
        return (position, false);
    }
    let shift = p.step * (velocity + p.step * p.gravity) / (1.0 + p.damping * p.step);
    if shift.length() > largest {
        (position + shift * (largest / shift.length()), true)
    } else {
        (position + shift, false)
    }
}

/// A segment turns freely, damped: q* = normalize(q + ½ Δt ω q).
#[must_use]
pub fn turn(p: &Parameters, orientation: DQuat, angular_velocity: DVec3) -> DQuat {
    turned(orientation, p.step * angular_velocity / (1.0 + p.damping * p.step))
}

/// q turned by the small rotation vector `angle` \[rad\], world axes.
#[must_use]
pub fn turned(q: DQuat, angle: DVec3) -> DQuat {
    let spin = DQuat::from_xyzw(angle.x, angle.y, angle.z, 0.0);
    (q + spin * q * 0.5).normalize()
}

/// Largest move of each point in a step, max(l, 0.03 L) \[m\], l the segment before the point.
#[must_use]
pub fn largest_moves(hair: &Strands) -> Vec<f64> {
    let mut moves = vec![0.0; hair.positions.len()];
    for s in 0..hair.len() {
        let lengths = &hair.rest_length[hair.segments(s)];
        let whole: f64 = lengths.iter().sum();
        for (k, point) in hair.points(s).enumerate() {
            let own = if k == 0 { 0.0 } else { lengths[k - 1] };
            moves[point] = own.max(0.03 * whole);
        }
    }
    moves
}

/// Sweeps over every strand, root to tip: joint k, then segment k. Multipliers start at 0 and persist over the sweeps.
pub fn gauss_seidel(p: &Parameters, hair: &Strands, positions: &mut [DVec3], orientations: &mut [DQuat]) {
    let mut stretch = vec![DVec3::ZERO; orientations.len()];
    let mut bend = vec![DVec3::ZERO; orientations.len()];
    for s in 0..hair.len() {
        for _ in 0..p.rod_iterations {
            for (k, point) in hair.segments(s).zip(hair.points(s)) {
                let first = k == hair.segments(s).start;
                bend_twist(p, hair, orientations, k, first.then_some(hair.root_frame[s]), &mut bend[k]);
                stretch_shear(p, hair, positions, orientations, k, point, &mut stretch[k]);
            }
        }
    }
}

/// α̃/α = (1 + c Δt)/Δt²: damping c, integrated implicitly, divides every force's share of the velocity by 1 + c Δt.
fn softening(p: &Parameters) -> f64 {
    (1.0 + p.damping * p.step) / (p.step * p.step)
}

/// C = Im(q̄₀ q₁) − s Im(rest), s the sign that is nearer in 4-D; dC = A (θ₁ − θ₀), A = ½(p_w I − [p_v]×) R₀ᵀ.
/// `clamp` is the ghost frame that a first joint hangs on.
fn bend_twist(p: &Parameters, hair: &Strands, q: &mut [DQuat], k: usize, clamp: Option<DQuat>, lambda: &mut DVec3) {
    let before = clamp.unwrap_or_else(|| q[k - 1]);
    let before_w = if clamp.is_some() { 0.0 } else { hair.inverse_inertia[k - 1] };
    let own_w = hair.inverse_inertia[k];
    let joint = before.conjugate() * q[k];
    let rest = hair.rest_rotation[k];
    let sign = if (joint - rest).length_squared() <= (joint + rest).length_squared() { 1.0 } else { -1.0 };
    let constraint = joint.xyz() - sign * rest.xyz();
    let a = (DMat3::from_diagonal(DVec3::splat(joint.w)) - cross_matrix(joint.xyz()))
        * DMat3::from_quat(before).transpose()
        * 0.5;
    let compliance = hair.bend_compliance[k] * softening(p);
    let system = a * a.transpose() * (own_w + before_w) + DMat3::from_diagonal(compliance);
    let change = system.inverse() * -(constraint + compliance * *lambda);
    *lambda += change;
    let moment = a.transpose() * change;
    q[k] = turned(q[k], own_w * moment);
    if clamp.is_none() {
        q[k - 1] = turned(before, -before_w * moment);
    }
}

/// C = (x₁ − x₀)/l − d₃; dC = (δx₁ − δx₀)/l + [d₃]× θ. Stiffness, multiplier and system in the material frame.
fn stretch_shear(
    p: &Parameters,
    hair: &Strands,
    x: &mut [DVec3],
    q: &mut [DQuat],
    k: usize,
    point: usize,
    lambda: &mut DVec3,
) {
    let l = hair.rest_length[k];
    let (w0, w1, wq) = (hair.inverse_mass[point], hair.inverse_mass[point + 1], hair.inverse_inertia[k]);
    let tangent = q[k] * DVec3::Z;
    let constraint = q[k].conjugate() * ((x[point + 1] - x[point]) / l - tangent);
    let compliance = hair.stretch_compliance[k] * softening(p);
    let system = DVec3::splat((w0 + w1) / (l * l)) + wq * DVec3::new(1.0, 1.0, 0.0) + compliance;
    let wanted = -(constraint + compliance * *lambda) / system;
    let change = DVec3::select(system.cmpgt(DVec3::ZERO), wanted, DVec3::ZERO);
    *lambda += change;
    let force = q[k] * change;
    x[point] -= w0 / l * force;
    x[point + 1] += w1 / l * force;
    q[k] = turned(q[k], -wq * tangent.cross(force));
}

fn cross_matrix(v: DVec3) -> DMat3 {
    DMat3::from_cols(DVec3::new(0.0, v.z, -v.y), DVec3::new(-v.z, 0.0, v.x), DVec3::new(v.y, -v.x, 0.0))
}

/// max |l/l0 − 1| of a strand; `None` when a point or a frame of it is not finite.
#[must_use]
pub fn finish(hair: &Strands, s: usize, positions: &[DVec3], orientations: &[DQuat]) -> Option<f64> {
    let (points, segments) = (hair.points(s), hair.segments(s));
    let finite = positions[points.clone()].iter().all(|x| x.is_finite())
        && orientations[segments.clone()].iter().all(|q| q.is_finite());
    let stretches = points
        .zip(segments)
        .map(|(point, k)| ((positions[point + 1] - positions[point]).length() / hair.rest_length[k] - 1.0).abs());
    finite.then(|| stretches.fold(0.0, f64::max))
}

/// A bad strand stays where it was for this step, so that it spoils no neighbour.
pub fn hold(s: &State, strand: usize, positions: &mut [DVec3], orientations: &mut [DQuat]) {
    let (points, segments) = (s.hair.points(strand), s.hair.segments(strand));
    positions[points.clone()].copy_from_slice(&s.position[points]);
    orientations[segments.clone()].copy_from_slice(&s.orientation[segments]);
}

/// ω = 2 Im(q* q̄)/Δt \[rad/s\].
#[must_use]
pub fn angular_velocity(p: &Parameters, before: DQuat, after: DQuat) -> DVec3 {
    let turn = after * before.conjugate();
    turn.xyz() * (2.0 * turn.w.signum() / p.step)
}
