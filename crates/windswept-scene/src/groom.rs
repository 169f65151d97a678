//! Strands from `[[hair]]`: roots, rest shapes, masses, compliances.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DQuat, DVec3};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;

use crate::{
    initial::Strands,
    scene::{Curl, Hair, RootShape, Roots, Scene, Stiffness},
};

/// Turns between successive points of a sunflower.
const GOLDEN_TURN: f64 = 0.381_966_011_250_105;
/// Roots leave their sunflower seat by up to this part of the spacing.
const JITTER: f64 = 0.15;
/// A joint that turns by more than this samples its curl too coarsely.
const COARSE_TURN: f64 = PI / 2.0;

/// The strands of every group. `parcel` is the volume of an air particle \[m³\], `kernel_radius` in m.
///
/// Chance is PCG XSL 128/64 (`rand_pcg`), seeded by the scene's seed and the group's index: the same on every machine.
pub(crate) fn strands(scene: &Scene, parcel: f64, kernel_radius: f64, warnings: &mut Vec<String>) -> Strands {
    let mut all = Strands { point_offsets: vec![0], ..Strands::default() };
    for (group, hair) in scene.hair.iter().enumerate() {
        let mut rng = Pcg64::seed_from_u64(scene.seed.wrapping_mul(0x9e37_79b9).wrapping_add(group as u64));
        for i in 0..hair.strands {
            let (root, axis) = seat(&hair.roots, i, hair.strands, &mut rng);
            // Where the motion has it at the start.
            let (center, turn) = (DVec3::from_array(hair.roots.center), hair.motion.at(0.0).1);
            let root = hair.motion.place(center, root, 0.0);
            let length = hair.length * (1.0 - hair.length_variation * rng.random::<f64>());
            let phase = rng.random::<f64>();
            let strand = Strand { hair, root, axis, turn, length, phase, inextensible: scene.rods.inextensible };
            strand.append(&mut all, parcel * (strand.segment() / kernel_radius).min(1.0));
            all.group.push(group as u32);
        }
        let turn = darboux(hair.curl).length() * hair.length / f64::from(hair.points - 1);
        if turn > COARSE_TURN {
            warnings.push(format!(
                "hair {}: the curl turns by {:.0} degrees per segment; more points would follow it better",
                hair.name,
                turn.to_degrees()
            ));
        }
    }
    all
}

/// Position and direction of root `i` of `n`: a jittered sunflower on disc and cap, equal parts of a line. A lone root
/// is in the middle.
fn seat(roots: &Roots, i: u32, n: u32, rng: &mut Pcg64) -> (DVec3, DVec3) {
    let [center, axis, normal] = [roots.center, roots.direction, roots.normal].map(DVec3::from_array);
    if n == 1 {
        let height = if roots.shape == RootShape::SphereCap { roots.radius } else { 0.0 };
        return (center + height * axis, axis);
    }
    let level = DVec3::Y.cross(normal);
    let across = if level.length() > 1e-6 { level.normalize() } else { DVec3::X };
    let up = normal.cross(across);
    let part = (f64::from(i) + 0.5) / f64::from(n);
    let jitter = [rng.random::<f64>() - 0.5, rng.random::<f64>() - 0.5].map(|u| 2.0 * JITTER * u);
    match roots.shape {
        RootShape::Line => (center + roots.radius * (2.0 * part - 1.0 + 2.0 * jitter[0] / f64::from(n)) * across, axis),
        RootShape::Disc => {
            let spacing = roots.radius * (PI / f64::from(n)).sqrt();
            let angle = TAU * GOLDEN_TURN * f64::from(i);
            let seat = roots.radius * part.sqrt() * (angle.cos() * across + angle.sin() * up);
            let seat = seat + spacing * (jitter[0] * across + jitter[1] * up);
            // Chance must not lead off the disc.
            (center + seat.clamp_length_max(roots.radius), axis)
        }
        RootShape::SphereCap => {
            let angle = TAU * (GOLDEN_TURN * f64::from(i) + jitter[0] / f64::from(n).sqrt());
            let height = 1.0 - part;
            let ring = (1.0 - height * height).sqrt();
            let normal = height * axis + ring * (angle.cos() * across + angle.sin() * up);
            (center + roots.radius * normal, normal)
        }
    }
}

/// Rest Darboux vector of a helix of radius a and pitch 2π b: (0, κ, τ) = (0, a, b)/(a² + b²) \[1/m\].
fn darboux(curl: Option<Curl>) -> DVec3 {
    curl.map_or(DVec3::ZERO, |curl| {
        let (a, b) = (curl.radius, curl.pitch / TAU);
        DVec3::new(0.0, a, b) / (a * a + b * b)
    })
}

/// d3 along `axis`, d1 by the smallest rotation from +x, from +z if that is parallel.
fn frame(axis: DVec3) -> DQuat {
    let from = if axis.cross(DVec3::X).length() > 1e-6 { DVec3::X } else { DVec3::Z };
    let d1 = (from - from.dot(axis) * axis).normalize();
    DQuat::from_mat3(&DMat3::from_cols(d1, axis.cross(d1), axis)).normalize()
}

/// exp(½ κ l): the turn by |κ| l about κ.
fn turn(darboux: DVec3, length: f64) -> DQuat {
    DQuat::from_scaled_axis(darboux * length)
}

struct Strand<'a> {
    hair: &'a Hair,
    root: DVec3,
    /// The strand's axis: of the fibre, or of its helix.
    axis: DVec3,
    /// What the motion of the roots turns the strand by at the start.
    turn: DQuat,
    length: f64,
    phase: f64,
    inextensible: bool,
}

impl Strand<'_> {
    /// Length of a segment \[m\].
    fn segment(&self) -> f64 {
        self.length / f64::from(self.hair.points - 1)
    }

    /// `volume` is that of the parcel about each point \[m³\].
    fn append(&self, all: &mut Strands, volume: f64) {
        let hair = self.hair;
        let segments = hair.points as usize - 1;
        let l = self.segment();
        let kappa = darboux(hair.curl);
        let root_frame = self.turn * self.root_frame(kappa);
        let masses: Vec<f64> =
            (0..segments).map(|k| hair.density * self.area(k as f64 + 0.5) * l * hair.fibres_per_strand).collect();

        let mut frame = root_frame;
        let mut x = self.root;
        for k in 0..hair.points as usize {
            let before = if k > 0 { masses[k - 1] } else { 0.0 };
            let after = masses.get(k).copied().unwrap_or_default();
            let mass = hair.point_mass.unwrap_or(0.5 * (before + after));
            all.positions.push(x);
            all.velocities.push(DVec3::ZERO);
            all.inverse_mass.push(if k == 0 { 0.0 } else { 1.0 / mass });
            all.volume.push(volume);
            if k == segments {
                break;
            }
            let joint = if k == 0 { 0.5 * l } else { l };
            let rest = turn(kappa, joint);
            frame = (frame * rest).normalize();
            x += l * (frame * DVec3::Z);
            let (stretch, shear) = self.stretch(k as f64 + 0.5);
            let (bend, twist) = self.bend(k as f64);
            let loose = if self.inextensible { 0.0 } else { 1.0 / (stretch * l) };
            let inertia = 0.5 * hair.point_mass.unwrap_or(masses[k]) * l * l;
            all.orientations.push(frame);
            all.angular_velocities.push(DVec3::ZERO);
            all.rest_length.push(l);
            all.radius.push(self.radius(k as f64 + 0.5));
            all.fibres.push(hair.fibres_per_strand);
            all.inverse_inertia.push(1.0 / inertia);
            all.stretch_compliance.push(DVec3::new(1.0 / (shear * l), 1.0 / (shear * l), loose));
            all.bend_compliance.push(0.25 * joint * DVec3::new(1.0 / bend, 1.0 / bend, 1.0 / twist));
            all.rest_rotation.push(rest);
        }
        all.root_frame.push(root_frame);
        all.point_offsets.push(all.positions.len() as u32);
    }

    /// The clamp: a helix is tilted so that its axis, the direction of the Darboux vector, runs along the strand's.
    fn root_frame(&self, kappa: DVec3) -> DQuat {
        let straight = frame(self.axis);
        let Some(curl) = self.hair.curl else {
            return straight;
        };
        let phase = DQuat::from_rotation_z(TAU * curl.phase * self.phase);
        (straight * phase * DQuat::from_rotation_arc(kappa.normalize(), DVec3::Z)).normalize()
    }

    /// Radius of a fibre \[m\] `at` that many segments from the root.
    fn radius(&self, at: f64) -> f64 {
        self.hair.radius * (1.0 - self.hair.taper * at / f64::from(self.hair.points - 1))
    }

    fn area(&self, at: f64) -> f64 {
        PI * self.radius(at).powi(2)
    }

    /// EA and GA \[N\].
    fn stretch(&self, at: f64) -> (f64, f64) {
        match self.hair.stiffness {
            Stiffness::Moduli { youngs_modulus, poissons_ratio } => {
                let stretch = youngs_modulus * self.area(at) * self.hair.fibres_per_strand;
                (stretch, stretch / (2.0 * (1.0 + poissons_ratio)))
            }
            Stiffness::Direct { stretch, poissons_ratio, .. } => (stretch, stretch / (2.0 * (1.0 + poissons_ratio))),
        }
    }

    /// EI and GJ \[N m²\].
    fn bend(&self, at: f64) -> (f64, f64) {
        match self.hair.stiffness {
            Stiffness::Moduli { youngs_modulus, poissons_ratio } => {
                let second_moment = 0.25 * PI * self.radius(at).powi(4) * self.hair.fibres_per_strand;
                let shear_modulus = youngs_modulus / (2.0 * (1.0 + poissons_ratio));
                (youngs_modulus * second_moment, shear_modulus * 2.0 * second_moment)
            }
            Stiffness::Direct { bend, twist, .. } => (bend, twist),
        }
    }
}
