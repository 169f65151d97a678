//! The closed form of bodies without triangles: all points within a radius of a box.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DQuat, DVec3};

/// Half of a side that does not end \[m\].
pub(crate) const ENDLESS: f64 = 1e9;
/// Half of an endless side where it is drawn \[m\].
const DRAWN: f64 = 1.0;
/// Radius of the largest ball in a body without an end, where a rule asks for one \[m\]: that of a head.
const HEAD: f64 = 0.1;

/// All points within `radius` of a box, which stands at `center`, turned by `rotation`.
///
/// The box is a point for a sphere and a line along x for a capsule; for a plane it has an end in one direction only,
/// its own +y.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoundBox {
    /// The point that the body turns about \[m\].
    pub center: DVec3,
    /// Rotation from the box's own axes to the world's.
    pub rotation: DQuat,
    /// Corner of the box with the least coordinates, from the center, in its own axes \[m\].
    pub low: DVec3,
    /// Corner of the box with the largest coordinates, from the center, in its own axes \[m\].
    pub high: DVec3,
    /// Distance of the surface from the box \[m\].
    pub radius: f64,
}

impl RoundBox {
    pub(crate) fn sphere(center: DVec3, radius: f64) -> Self {
        Self { center, rotation: DQuat::IDENTITY, low: DVec3::ZERO, high: DVec3::ZERO, radius }
    }

    pub(crate) fn capsule(start: DVec3, end: DVec3, radius: f64) -> Self {
        let half = 0.5 * (end - start);
        let rotation = DQuat::from_rotation_arc(DVec3::X, half.normalize_or(DVec3::X));
        let high = half.length() * DVec3::X;
        Self { center: 0.5 * (start + end), rotation, low: -high, high, radius }
    }

    /// A box with sharp edges.
    pub(crate) fn cuboid(center: DVec3, rotation: DQuat, size: DVec3) -> Self {
        Self { center, rotation, low: -0.5 * size, high: 0.5 * size, radius: 0.0 }
    }

    /// All points behind a plane, away from its normal.
    pub(crate) fn plane(point: DVec3, normal: DVec3) -> Self {
        let rotation = DQuat::from_rotation_arc(DVec3::Y, normal);
        let high = ENDLESS * DVec3::ONE.with_y(0.0);
        Self { center: point, rotation, low: DVec3::splat(-ENDLESS), high, radius: 0.0 }
    }

    /// Signed distance of `x` from the surface \[m\], negative inside, and its gradient. In the box it is that of the
    /// nearest side.
    pub(crate) fn signed_distance(&self, x: DVec3) -> (f64, DVec3) {
        let own = self.rotation.inverse() * (x - self.center);
        let gap = own - own.clamp(self.low, self.high);
        if let Some(normal) = gap.try_normalize() {
            return (gap.length() - self.radius, self.rotation * normal);
        }
        let beyond = (self.low - own).max(own - self.high);
        // Of sides that are equally near, one across the longest.
        let side = [1, 2, 0].into_iter().fold(1, |best, side| if beyond[side] > beyond[best] { side } else { best });
        let sign = if own[side] - self.high[side] < self.low[side] - own[side] { -1.0 } else { 1.0 };
        (beyond[side] - self.radius, self.rotation * (sign * DVec3::AXES[side]))
    }

    /// Radius of the largest ball that fits inside \[m\].
    pub(crate) fn inradius(&self) -> f64 {
        let half = 0.5 * (self.high - self.low).min_element();
        if self.low.min_element() <= -ENDLESS { HEAD } else { half + self.radius }
    }

    /// Corners of the box about the body \[m\]; a body without an end has its center twice.
    pub(crate) fn bounds(&self) -> [DVec3; 2] {
        if self.low.min_element() <= -ENDLESS {
            return [self.center; 2];
        }
        let turn = DMat3::from_quat(self.rotation);
        let reach = DMat3::from_cols(turn.x_axis.abs(), turn.y_axis.abs(), turn.z_axis.abs()) * self.high;
        [self.center - reach - self.radius, self.center + reach + self.radius]
    }

    /// Points and normals of [`crate::CheckedShape::skin`], and the triangles between them.
    pub(crate) fn skin(&self, rows: u32, sides: u32) -> (Vec<(DVec3, DVec3)>, Vec<[u32; 3]>) {
        if self.radius > 0.0 { self.round_skin(rows, sides) } else { self.sides() }
    }

    fn round_skin(&self, rows: u32, sides: u32) -> (Vec<(DVec3, DVec3)>, Vec<[u32; 3]>) {
        let ends = [self.low, self.high].map(|end| self.center + self.rotation * end);
        let axis = (ends[1] - ends[0]).normalize_or(DVec3::Y);
        let across = axis.any_orthonormal_vector();
        let basis = DMat3::from_cols(across, axis.cross(across), axis);
        let points = (0..rows).flat_map(|i| (0..=sides).map(move |k| (i, k)));
        let point = |(i, k)| {
            // Two half spheres; the side is between their equators.
            let far = i >= rows / 2;
            let latitude = PI * (f64::from(i - u32::from(far)) / f64::from(rows - 2) - 0.5);
            let around = TAU * f64::from(k) / f64::from(sides);
            let normal = DVec3::new(latitude.cos() * around.cos(), latitude.cos() * around.sin(), latitude.sin());
            let normal = basis * normal;
            (ends[usize::from(far)] + self.radius * normal, normal)
        };
        let squares = (0..rows - 1).flat_map(|i| (0..sides).map(move |k| i * (sides + 1) + k));
        let corners = squares.flat_map(|a| [[a, a + 1, a + sides + 1], [a + 1, a + sides + 2, a + sides + 1]]);
        (points.map(point).collect(), corners.collect())
    }

    /// Four corners of each side that ends.
    fn sides(&self) -> (Vec<(DVec3, DVec3)>, Vec<[u32; 3]>) {
        let all = (0..3).flat_map(|axis| [(axis, self.low, -1.0), (axis, self.high, 1.0)]);
        let points = all.filter(|(axis, end, _)| end[*axis].abs() < ENDLESS).flat_map(|(axis, end, sign)| {
            [[-1.0, -sign], [1.0, -sign], [1.0, sign], [-1.0, sign]].map(|way| {
                let mut x = DVec3::ZERO;
                x[axis] = end[axis];
                for (side, way) in [(axis + 1) % 3, (axis + 2) % 3].into_iter().zip(way) {
                    let end = if way > 0.0 { self.high[side] } else { self.low[side] };
                    x[side] = if end.abs() < ENDLESS { end } else { way * DRAWN };
                }
                (self.center + self.rotation * x, self.rotation * (sign * DVec3::AXES[axis]))
            })
        });
        let points: Vec<_> = points.collect();
        let corners = (0..points.len() as u32).step_by(4).flat_map(|a| [[a, a + 1, a + 2], [a, a + 2, a + 3]]);
        let corners = corners.collect();
        (points, corners)
    }
}
