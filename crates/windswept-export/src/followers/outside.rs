//! Hairs that are kept out of bodies.
//!
//! A follower is an average of strands, and an average of hairs that go around a body can go through it. Such a
//! follower is laid anew from its first point inside on, root to tip: each point goes where it was to be, as far from
//! the point before it as it was, and from there to the nearest place outside that is as far. The follower keeps the
//! lengths of its segments, lies on the body, and goes on behind it to where it was to be. Its root stays, and so do
//! the points before the first one inside.

use glam::{DVec3, Vec3};
use windswept_engine::Frame;
use windswept_scene::{CheckedBody, CheckedShape};

use crate::bodies::in_frame;

/// Depth at which a point still counts as one of the surface \[m\]: a quarter of a hair's radius.
const DEPTH: f64 = 1e-5;
/// Steps to the surface that a point takes at most. On a ball of 10 mm two do, for a segment of 4 mm.
const STEPS: usize = 16;
/// Halvings of the turn that leads out of a body where those steps do not.
const HALVINGS: usize = 12;
/// Part of a distance that is certain: the interpolant of a grid of distances can grow by more than a metre in a metre,
/// by the square root of 3 at most.
const CERTAIN: f64 = 0.5;

/// Bodies at one time.
pub(super) struct Bodies {
    shapes: Vec<CheckedShape>,
}

impl Bodies {
    /// The bodies where they are in a frame.
    pub(super) fn of(bodies: &[CheckedBody], frame: &Frame) -> Self {
        Self { shapes: in_frame(bodies, frame).collect() }
    }

    /// Keeps a hair out, whose points these are \[m\], from root to tip.
    pub(super) fn keep_out(&self, points: &mut [[f32; 3]]) {
        let Some(first) = self.first_inside(points) else { return };
        let place = |x: [f32; 3]| Vec3::from_array(x).as_dvec3();
        let mut meant = place(points[first - 1]);
        let mut before = meant;
        for point in &mut points[first..] {
            let next = place(*point);
            before = self.outside(before, next, next.distance(meant));
            meant = next;
            *point = before.as_vec3().to_array();
        }
    }

    /// Index of the first point inside a body, without the root.
    fn first_inside(&self, points: &[[f32; 3]]) -> Option<usize> {
        if self.shapes.is_empty() {
            return None;
        }
        // Length of the hair that is certain to be outside, from the point on.
        let mut clear = 0.0;
        for (k, pair) in points.windows(2).enumerate() {
            let [a, b] = [0, 1].map(|i| Vec3::from_array(pair[i]).as_dvec3());
            clear -= a.distance(b);
            if clear > 0.0 {
                continue;
            }
            let distance = self.distance(b);
            if distance < -DEPTH {
                return Some(k + 1);
            }
            clear = CERTAIN * distance;
        }
        None
    }

    /// The place at `length` from `start` that is outside and near to `meant`.
    fn outside(&self, start: DVec3, meant: DVec3, length: f64) -> DVec3 {
        let way = (meant - start).normalize_or(DVec3::NEG_Y);
        let mut x = start + length * way;
        for _ in 0..STEPS {
            if self.distance(x) >= -DEPTH {
                return x;
            }
            for shape in &self.shapes {
                let (distance, normal) = shape.signed_distance(x);
                x -= distance.min(0.0) * normal;
            }
            x = start + length * (x - start).normalize_or(way);
        }
        // In a corner: the least turn toward the way out from `start`, between the bodies about it.
        let about = self.shapes.iter().map(|shape| shape.signed_distance(start));
        let out: DVec3 = about.map(|(distance, normal)| (1.0 - distance / length).max(0.0) * normal).sum();
        let out = out.normalize_or(-way);
        let (mut least, mut most) = (0.0, 1.0);
        let turned = |part: f64| start + length * way.lerp(out, part).normalize_or(out);
        for _ in 0..HALVINGS {
            let part = 0.5 * (least + most);
            if self.distance(turned(part)) < -DEPTH { least = part } else { most = part }
        }
        turned(most)
    }

    /// Signed distance of a point from the nearest body \[m\].
    fn distance(&self, x: DVec3) -> f64 {
        self.shapes.iter().map(|shape| shape.signed_distance(x).0).fold(f64::INFINITY, f64::min)
    }
}
