//! The rest shape of a strand that hangs as it is given: its shape without weight.
//!
//! A strand that is clamped at its root and free at its tip is statically determinate: forces and moments follow from
//! its shape alone, from the tip to the root, and the rest shape from them joint by joint. A tip that is held as well
//! is given the rest shape of a free one, so that what holds it bears nothing. With the constraints of
//! `docs/decisions/rods.md`, C + α μ = 0, and F the force that holds up what is beyond a segment,
//!
//! ```text
//! F_k = F_(k+1) − m_(k+1) g                     m the mass of the point between two segments
//! c_k / l_k = d3 − F_⊥ / GA − d3 F_∥ / EA       gives the rest length l_k and the frame's d3; c_k the chord
//! M_k = M_(k+1) + d3 × l_k F_k                  the moment of joint k
//! M_k = R ½ (Re(p_k) + [Im(p_k)]×) ν_k          gives ν_k; p_k the turn from frame to frame, R the frame before
//! Im(rest_k) = Im(p_k) + α_k ν_k
//! ```

use glam::{DMat3, DQuat, DVec3};

use crate::{
    scene::Fibre,
    strand::{Shape, turned_onto},
    strands::End,
};

/// Largest sine of half a turn at rest: near 1 a joint forgets which way it turned.
const LARGEST: f64 = 0.9;
/// Rounds in which lengths, frames and masses, each of which follows from the others, are found. Strain is below 1e-2,
/// and a round gains as many digits.
const ROUNDS: usize = 8;
/// Result of [`Shape::hang`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Hung {
    /// The strand stays where it is.
    Held,
    /// A joint would have to turn by more than it can: the strand is too soft for its shape.
    TooSoft,
    /// The strand is in balance, but the least push takes it away: an upright one that is too soft.
    Unstable,
    /// Its root is not clamped, so that no rest shape holds it: it falls, or swings about its root.
    Loose,
}

impl Shape {
    /// Changes the rest shape such that `gravity` alone leaves the strand, made of `fibre`, as it is. That of a strand
    /// whose root is not clamped stays.
    pub(crate) fn hang(&mut self, fibre: &Fibre, gravity: DVec3) -> Hung {
        let [root, tip] = self.ends;
        if root != End::Clamped {
            return if gravity == DVec3::ZERO { Hung::Held } else { Hung::Loose };
        }
        let segments = self.lengths.len();
        let chords: Vec<DVec3> = self.points.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let part = |at: f64| at / segments as f64;
        let mut forces = vec![DVec3::ZERO; segments];
        for _ in 0..ROUNDS {
            let masses = self.masses(fibre);
            let mut force = DVec3::ZERO;
            for k in (0..segments).rev() {
                force -= masses[k + 1] * gravity;
                forces[k] = force;
                let (stretch, shear) = fibre.stretch(part(k as f64 + 0.5));
                let d3 = self.frames[k] * DVec3::Z;
                let along = force.dot(d3);
                let across = force - along * d3;
                let d3 = (chords[k] / self.lengths[k] + across / shear).normalize_or(d3);
                self.frames[k] = turned_onto(self.frames[k], d3);
                self.lengths[k] = chords[k].dot(d3) / (1.0 - along / stretch);
            }
        }
        let mut held = true;
        let mut joints = vec![Joint::FREE; segments + 1];
        for k in (0..segments).rev() {
            let moment = joints[k + 1].moment + (self.frames[k] * DVec3::Z).cross(self.lengths[k] * forces[k]);
            let before = if k == 0 { self.root_frame } else { self.frames[k - 1] };
            let compliance = self.bend_compliance(fibre, k);
            joints[k] = Joint::of(before, self.frames[k], moment, compliance);
            let (rest, fits) = joints[k].rest_turn(compliance);
            self.turns[k] = rest;
            held &= fits;
        }
        let (tip_frame, _) = self.tip;
        self.tip.1 = (self.frames[segments - 1].conjugate() * tip_frame).normalize();
        if !held {
            Hung::TooSoft
        } else if tip != End::Free || self.is_stable(&joints, &forces) {
            Hung::Held
        } else {
            Hung::Unstable
        }
    }

    /// Whether the energy of bending, twisting and weight grows with every turn of the frames: whether its second
    /// derivative,
    ///
    /// ```text
    /// ½ Σ (θ_k − θ_(k−1))ᵀ B_k (θ_k − θ_(k−1)) + M_k · (θ_(k−1) × θ_k)
    ///   − ½ Σ l_k ((F_k · d3) |θ_k|² − (F_k · θ_k)(d3 · θ_k)),      B = Aᵀ α⁻¹ A + ¼ (ν · Im(p)),  A = ½ (Re(p) − [Im(p)]×) Rᵀ
    /// ```
    ///
    /// is positive. It is a chain of blocks, which Gauss eliminates from the root on. Strands hardly stretch, and this
    /// takes them as if they did not.
    fn is_stable(&self, joints: &[Joint], forces: &[DVec3]) -> bool {
        let mut eliminated = DMat3::ZERO;
        (0..self.lengths.len()).all(|k| {
            let (force, d3) = (self.lengths[k] * forces[k], self.frames[k] * DVec3::Z);
            let weight = outer(force, d3) + outer(d3, force);
            let own = joints[k].stiffness + joints[k + 1].stiffness + 0.5 * weight
                - DMat3::from_diagonal(DVec3::splat(force.dot(d3)))
                - eliminated;
            let ahead = joints[k + 1].stiffness + 0.5 * cross_matrix(joints[k + 1].moment);
            eliminated = ahead.transpose() * own.inverse() * ahead;
            let corner = own.x_axis.x * own.y_axis.y - own.x_axis.y * own.y_axis.x;
            own.x_axis.x > 0.0 && corner > 0.0 && own.determinant() > 0.0
        })
    }
}

/// A joint under load.
#[derive(Debug, Clone, Copy)]
struct Joint {
    /// Im(p), of the turn from the frame before to the one after.
    turn: DVec3,
    /// Re(p), at least 0.
    cosine: f64,
    /// ν \[N m\].
    multiplier: DVec3,
    /// M \[N m\].
    moment: DVec3,
    /// B \[N m\].
    stiffness: DMat3,
}

impl Joint {
    /// The end beyond the tip, which bears nothing.
    const FREE: Self =
        Self { turn: DVec3::ZERO, cosine: 1.0, multiplier: DVec3::ZERO, moment: DVec3::ZERO, stiffness: DMat3::ZERO };

    /// The joint that bears `moment` between these frames.
    fn of(before: DQuat, after: DQuat, moment: DVec3, compliance: DVec3) -> Self {
        let p = before.conjugate() * after;
        let p = if p.w < 0.0 { -p } else { p };
        let (cosine, turn) = (p.w, p.xyz());
        let system = DMat3::from_diagonal(DVec3::splat(cosine)) + cross_matrix(turn);
        let multiplier = 2.0 * (system.inverse() * (before.conjugate() * moment));
        let gradient = 0.5 * system.transpose() * DMat3::from_quat(before).transpose();
        let stiffness = gradient.transpose() * DMat3::from_diagonal(compliance.recip()) * gradient
            + DMat3::from_diagonal(DVec3::splat(0.25 * multiplier.dot(turn)));
        Self { turn, cosine, multiplier, moment, stiffness }
    }

    /// The turn at rest, and whether it is one that the rods know from its opposite.
    fn rest_turn(&self, compliance: DVec3) -> (DQuat, bool) {
        let rest = self.turn + compliance * self.multiplier;
        let bounded = if rest.is_finite() { rest.clamp_length_max(LARGEST) } else { self.turn };
        let cosine = (1.0 - bounded.length_squared()).max(0.0).sqrt();
        // The rods take the turn with the sign that is nearer to the present one.
        let near = bounded.dot(self.turn) + cosine * self.cosine > 0.0;
        (DQuat::from_vec4(bounded.extend(cosine)), bounded == rest && near)
    }
}

fn cross_matrix(v: DVec3) -> DMat3 {
    DMat3::from_cols(DVec3::new(0.0, v.z, -v.y), DVec3::new(-v.z, 0.0, v.x), DVec3::new(v.y, -v.x, 0.0))
}

fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}
