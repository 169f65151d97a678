//! Surfaces that strands are rooted on, and the roots there of the hairs about a strand.

use std::f32::consts::TAU;

use glam::{DVec3, Quat, Vec3};
use windswept_scene::{CheckedScene, CheckedShape, RootPatch, RootShape, Roots};

use super::chance;

/// Surface that the strands of a group are rooted on, where it is known.
pub(super) enum Ground {
    Unknown,
    Patch(RootPatch),
    /// A body where it is at the start.
    Body(CheckedShape),
}

impl Ground {
    pub(super) fn new(scene: &CheckedScene, roots: Option<&Roots>) -> Self {
        if let Some(Roots::Mesh(scalp)) = roots {
            let body = scene.bodies.iter().find(|body| body.name == scalp.body);
            return body.map_or(Self::Unknown, |body| Self::Body(body.at(0.0)));
        }
        roots.and_then(Roots::patch).map_or(Self::Unknown, Self::Patch)
    }

    /// The root of a hair of a strand, `seat` away in the strand's cross-section: beside it on what that is rooted on.
    pub(super) fn place(&self, root: Vec3, frame: Quat, seat: Vec3) -> Vec3 {
        let across = root + frame * seat;
        match self {
            Self::Unknown => across,
            Self::Patch(patch) => beside(patch, root, frame, seat),
            Self::Body(shape) => {
                // A second time takes what the first left where the surface curves.
                let onto = |x: DVec3| {
                    let (distance, normal) = shape.signed_distance(x);
                    x - distance * normal
                };
                onto(onto(across.as_dvec3())).as_vec3()
            }
        }
    }
}

/// The place on a patch that is `seat` away from a root there.
fn beside(roots: &RootPatch, root: Vec3, frame: Quat, seat: Vec3) -> Vec3 {
    let across = root + frame * seat;
    let [center, normal] = [roots.center, roots.normal].map(|v| Vec3::from_array(v.map(|x| x as f32)));
    let radius = roots.radius as f32;
    match roots.shape {
        RootShape::Disc => {
            // Hair may lean on it.
            let x = root - center + Quat::from_rotation_arc(frame * Vec3::Z, normal) * frame * seat;
            center + within(x.length(), radius) * x.normalize_or_zero()
        }
        RootShape::Cap => center + radius * (across - center).normalize_or(normal),
        RootShape::Line => {
            let level = Vec3::Y.cross(normal);
            let along = if level.length() > 1e-6 { level.normalize() } else { Vec3::X };
            center + within((root - center).dot(along) + seat.x, radius) * along
        }
    }
}

/// Mirrors what would be beyond an end to as far before it.
fn within(x: f32, end: f32) -> f32 {
    x - 2.0 * (x - x.clamp(-end, end))
}

/// Hair k of a strand: even over the disc that the strand has for itself (a sunflower), about its root.
pub(super) fn seat(spacing: f32, k: usize, of: usize, seed: u32) -> Vec3 {
    let part = (k as f32 + 0.7 * (chance(seed, 2) - 0.5)) / of as f32;
    let radius = 0.75 * spacing * part.max(0.0).sqrt();
    let angle = TAU * (0.381_966 * k as f32 + 0.4 * chance(seed, 3));
    Vec3::new(radius * angle.cos(), radius * angle.sin(), 0.0)
}
