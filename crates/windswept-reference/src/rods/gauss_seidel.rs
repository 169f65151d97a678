//! Gauss-Seidel with compliance (Macklin et al. 2016) over the constraints of Kugelstadt & Schömer 2016.

use glam::{DMat3, DQuat, DVec3};
use windswept_scene::{End, Strands};

use super::{Moving, State, StrandMotion, cross_matrix, damping, nearest_rest, response, turned};
use crate::Parameters;

/// Sweeps over strand `s` from root to tip: joint k, then segment k. Multipliers persist over the sweeps.
pub fn gauss_seidel(p: &Parameters, hair: &Strands, s: usize, motion: &StrandMotion, m: &mut Moving) {
    if motion.state != State::Free {
        return;
    }
    let clamped = hair.ends(s).root == End::Clamped;
    for _ in 0..p.rods.iterations {
        for (k, point) in hair.segments(s).zip(hair.points(s)) {
            let first = k == hair.segments(s).start;
            if !first || clamped {
                bend_twist(p, hair, m, k, first.then_some(motion.root_frame));
            }
            stretch_shear(p, hair, m, k, point);
        }
    }
}

/// Solves bend-twist C = Im(q̄₀ q₁) − s Im(rest), s the sign that is nearer in 4-D; dC = A (θ₁ − θ₀), A = ½(p_w I −
/// [p_v]×) R₀ᵀ. `clamp` is the ghost frame that a first joint hangs on.
fn bend_twist(p: &Parameters, hair: &Strands, m: &mut Moving, k: usize, clamp: Option<DQuat>) {
    let own = &m.segments[k];
    let before = clamp.unwrap_or_else(|| m.segments[k - 1].frame);
    let before_w = if clamp.is_some() { 0.0 } else { hair.inverse_inertia[k - 1] };
    let own_w = hair.inverse_inertia[k];
    let joint = before.conjugate() * own.frame;
    let constraint = joint.xyz() - nearest_rest(joint, hair.rest_rotation[k]);
    let a = (DMat3::from_diagonal(DVec3::splat(joint.w)) - cross_matrix(joint.xyz()))
        * DMat3::from_quat(before).transpose()
        * 0.5;
    let compliance = hair.bend_compliance[k] / response(p.rods.damping, own.step);
    let system = a * a.transpose() * (own_w + before_w) + DMat3::from_diagonal(compliance);
    let change = system.inverse() * -(constraint + compliance * own.bend);
    let moment = a.transpose() * change;
    m.segments[k].bend += change;
    m.segments[k].frame = turned(m.segments[k].frame, own_w * moment);
    if clamp.is_none() {
        m.segments[k - 1].frame = turned(before, -before_w * moment);
    }
}

/// Solves stretch-shear C = (x₁ − x₀)/l − d₃; dC = (δx₁ − δx₀)/l + [d₃]× θ. Stiffness, multiplier and system in the
/// material frame.
fn stretch_shear(p: &Parameters, hair: &Strands, m: &mut Moving, k: usize, point: usize) {
    let l = hair.rest_length[k];
    // Multipliers are forces times the response of frames; a point that more than that resists moves by less.
    let weight = |i: usize| {
        let point = &m.points[i];
        point.inverse_mass * (response(damping(p, point), point.step) / response(p.rods.damping, point.step))
    };
    let (w0, w1, wq) = (weight(point), weight(point + 1), hair.inverse_inertia[k]);
    let own = &m.segments[k];
    let q = own.frame;
    let tangent = q * DVec3::Z;
    let chord = own.chord + m.points[point + 1].displacement - m.points[point].displacement;
    let constraint = q.conjugate() * (chord / l - tangent);
    let compliance = hair.stretch_compliance[k] / response(p.rods.damping, own.step);
    let system = DVec3::splat((w0 + w1) / (l * l)) + wq * DVec3::new(1.0, 1.0, 0.0) + compliance;
    let wanted = -(constraint + compliance * own.stretch) / system;
    let change = DVec3::select(system.cmpgt(DVec3::ZERO), wanted, DVec3::ZERO);
    let force = q * change;
    m.segments[k].stretch += change;
    m.segments[k].frame = turned(q, -wq * tangent.cross(force));
    m.points[point].displacement -= w0 / l * force;
    m.points[point + 1].displacement += w1 / l * force;
}
