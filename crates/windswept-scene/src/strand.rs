//! A strand made of fibres: masses, inertias and compliances of a row of points.

use std::f64::consts::PI;

use glam::{DMat3, DQuat, DVec3};

use crate::{
    profile::Profile,
    scene::{Fibre, Moduli, Stiffness, StrandStiffness},
    strands::{End, Ends, Strands},
};

impl Fibre {
    /// Radius \[m\], `part` of the way to the tip.
    pub(crate) fn radius_at(&self, part: f64) -> f64 {
        self.radius * (1.0 - self.taper * part)
    }

    /// Area of all fibres' cross-sections \[m²\]: π a b of each.
    fn area(&self, part: f64) -> f64 {
        PI * self.radius_at(part).powi(2) * self.aspect * self.fibres_per_strand
    }

    /// Stiffness to stretch and to shear, EA and GA \[N\].
    pub(crate) fn stretch(&self, part: f64) -> (f64, f64) {
        let (stretch, poissons_ratio) = match self.stiffness {
            Stiffness::Moduli(Moduli { youngs_modulus, poissons_ratio }) => {
                (youngs_modulus * self.area(part), poissons_ratio)
            }
            Stiffness::Direct(StrandStiffness { stretch, poissons_ratio, .. }) => (stretch, poissons_ratio),
        };
        (stretch, stretch / (2.0 * (1.0 + poissons_ratio)))
    }

    /// Stiffness to bend and twist: EI about d1 and d2, GJ \[N m²\]. An ellipse with semi-axes b along d1 and a along
    /// d2 has the moments π a³ b/4, π a b³/4 and Saint-Venant's π a³ b³/(a² + b²).
    pub(crate) fn bend(&self, part: f64) -> DVec3 {
        match self.stiffness {
            Stiffness::Moduli(Moduli { youngs_modulus, poissons_ratio }) => {
                let shear_modulus = youngs_modulus / (2.0 * (1.0 + poissons_ratio));
                let (a, b) = (self.radius_at(part), self.aspect * self.radius_at(part));
                let (along, across) = (0.25 * PI * a.powi(3) * b, 0.25 * PI * a * b.powi(3));
                let twist = PI * (a * b).powi(3) / (a * a + b * b);
                self.fibres_per_strand
                    * DVec3::new(youngs_modulus * along, youngs_modulus * across, shear_modulus * twist)
            }
            Stiffness::Direct(StrandStiffness { bend, twist, .. }) => DVec3::new(bend, bend, twist),
        }
    }
}

/// The air particle that a hair point stands in.
#[derive(Debug, Clone, Copy)]
pub(crate) struct AirParticle {
    /// Volume of an air particle \[m³\].
    pub(crate) volume: f64,
    /// Kernel radius \[m\].
    pub(crate) kernel_radius: f64,
}

/// The shape of a strand at the start and at rest: n points, n - 1 segments with a joint before each.
#[derive(Debug, Clone)]
pub(crate) struct Shape {
    /// Points \[m\].
    pub(crate) points: Vec<DVec3>,
    /// Ghost frame behind the root.
    pub(crate) root_frame: DQuat,
    /// Frames of the segments.
    pub(crate) frames: Vec<DQuat>,
    /// Rest lengths of the segments \[m\].
    pub(crate) lengths: Vec<f64>,
    /// Rest rotations of the joints.
    pub(crate) turns: Vec<DQuat>,
    /// Ways in which the root and the tip are held.
    pub(crate) ends: [End; 2],
    /// Ghost frame beyond the tip, and its rest rotation from the last frame.
    pub(crate) tip: (DQuat, DQuat),
    /// Factor of the stiffness to bend and twist along the strand, where it is not 1.
    pub(crate) stiffness: Option<Profile>,
}

impl Shape {
    /// Appends the strand, made of `fibre` and standing in `particle`s, to `all`.
    pub(crate) fn append(&self, fibre: &Fibre, particle: AirParticle, all: &mut Strands) {
        let segments = self.lengths.len();
        let part = |at: f64| at / segments as f64;
        let masses = self.masses(fibre);
        let [root, tip] = self.ends;
        for (i, x) in self.points.iter().enumerate() {
            // The segments on both sides; at an end the one.
            let beside = i.saturating_sub(1)..(i + 1).min(segments);
            let length = self.lengths[beside.clone()].iter().sum::<f64>() / beside.len() as f64;
            let held = (i == 0 && root != End::Free) || (i == segments && tip != End::Free);
            all.positions.push(*x);
            all.velocities.push(DVec3::ZERO);
            all.inverse_mass.push(if held { 0.0 } else { 1.0 / masses[i] });
            all.volume.push(particle.volume * (length / particle.kernel_radius).min(1.0));
        }
        for (k, &l) in self.lengths.iter().enumerate() {
            let (stretch, shear) = fibre.stretch(part(k as f64 + 0.5));
            let inertia = 0.5 * fibre.point_mass.unwrap_or_else(|| self.mass(fibre, k)) * l * l;
            all.orientations.push(self.frames[k]);
            all.angular_velocities.push(DVec3::ZERO);
            all.rest_length.push(l);
            all.radius.push(fibre.radius_at(part(k as f64 + 0.5)));
            all.fibres.push(fibre.fibres_per_strand);
            all.inverse_inertia.push(1.0 / inertia);
            all.stretch_compliance.push(DVec3::new(1.0 / (shear * l), 1.0 / (shear * l), 1.0 / (stretch * l)));
            all.bend_compliance.push(self.bend_compliance(fibre, k));
            all.rest_rotation.push(self.turns[k]);
        }
        all.root_frame.push(self.root_frame);
        all.point_offsets.push(all.positions.len() as u32);
        all.ends.push(match tip {
            End::Clamped => Ends {
                root,
                tip,
                tip_frame: self.tip.0,
                tip_rest_rotation: self.tip.1,
                tip_compliance: 0.125 * self.lengths[segments - 1] / (self.stiffness_at(segments) * fibre.bend(1.0)),
            },
            _ => Ends { root, tip, ..Ends::default() },
        });
    }
}

impl Shape {
    /// Mass of segment `k` \[kg\].
    fn mass(&self, fibre: &Fibre, k: usize) -> f64 {
        let part = (k as f64 + 0.5) / self.lengths.len() as f64;
        fibre.density * fibre.area(part) * self.lengths[k]
    }

    /// Mass of each point \[kg\]: half of the segments on both sides, where the fibre does not say it.
    pub(crate) fn masses(&self, fibre: &Fibre) -> Vec<f64> {
        let segments = self.lengths.len();
        let own = |i: usize| (i.saturating_sub(1)..(i + 1).min(segments)).map(|k| 0.5 * self.mass(fibre, k)).sum();
        (0..=segments).map(|i| fibre.point_mass.unwrap_or_else(|| own(i))).collect()
    }

    /// Compliance l̄/(4EI), l̄/(4EI), l̄/(4GJ) of joint `k` \[1/(N m)\].
    pub(crate) fn bend_compliance(&self, fibre: &Fibre, k: usize) -> DVec3 {
        let l = self.lengths[k];
        let joint = if k == 0 { 0.5 * l } else { 0.5 * (self.lengths[k - 1] + l) };
        0.25 * joint / (self.stiffness_at(k) * fibre.bend(k as f64 / self.lengths.len() as f64))
    }

    /// Factor of the stiffness at the root of segment `k`, or at the tip.
    fn stiffness_at(&self, k: usize) -> f64 {
        let part = || self.lengths[..k].iter().sum::<f64>() / self.lengths.iter().sum::<f64>();
        self.stiffness.as_ref().map_or(1.0, |profile| profile.at(part()))
    }
}

/// A frame turned onto the tangent `d3` by the smallest rotation.
pub(crate) fn turned_onto(frame: DQuat, d3: DVec3) -> DQuat {
    (DQuat::from_rotation_arc(frame * DVec3::Z, d3) * frame).normalize()
}

/// Frame with d3 along `axis` and d1 by the smallest rotation from +x, from +z if that is parallel.
pub(crate) fn frame(axis: DVec3) -> DQuat {
    let from = if axis.cross(DVec3::X).length() > 1e-6 { DVec3::X } else { DVec3::Z };
    let d1 = (from - from.dot(axis) * axis).normalize();
    DQuat::from_mat3(&DMat3::from_cols(d1, axis.cross(d1), axis)).normalize()
}

/// Rotation exp(½ κ l): the turn by |κ| l about κ.
pub(crate) fn turn(darboux: DVec3, length: f64) -> DQuat {
    DQuat::from_scaled_axis(darboux * length)
}
