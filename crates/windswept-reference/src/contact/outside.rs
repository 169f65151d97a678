//! Where bodies let points and segments of hair go.

use glam::DVec3;

use super::{Placed, ROUNDS};
use crate::Parameters;

/// Largest speed at which hair that starts inside comes out \[m/s\].
pub(super) const RECOVERY: f64 = 0.2;
/// Cosine of the angle between normals on one side of a body.
const SAME_SIDE: f64 = 0.5;
/// Depths of a place of a segment that an end of it is moved by, at most.
pub(super) const AT_MOST: f64 = 2.0;

/// A place of the hair after bodies have had their say.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kept {
    /// Where it may go \[m\].
    pub place: DVec3,
    /// Depth at which it begins the step below a surface \[m\]; 0 if it begins outside.
    pub inside: f64,
}

/// A segment after bodies have had their say.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cleared {
    /// Where its ends may go \[m\].
    pub ends: [DVec3; 2],
    /// Longest way by which one of its places was pushed \[m\].
    pub push: f64,
    /// Depth at which one of these places begins the step below a surface \[m\]; 0 if they begin outside.
    pub inside: f64,
}

impl Placed {
    /// Place of the hair that was at `position` and would be at `predicted`, kept out of the body.
    ///
    /// Seen from the body, the way of the place ends at the plane that touches the body where the way enters it. If the place
    /// starts inside, the plane lies at the place's own depth, less what it may recover in a step. The way along the plane is
    /// shortened by up to μ times the depth that the place would have had (Macklin et al. 2014, eq. 24).
    fn keep(&self, p: &Parameters, position: DVec3, predicted: DVec3) -> Kept {
        let Self { body, before, after } = self;
        let (a, b) = (before.back(position), after.back(predicted));
        let Some(contact) = body.entry(a, b) else { return Kept { place: predicted, inside: 0.0 } };
        let (distance, normal) = body.shape.signed_distance(contact);
        let inside = (-distance).max(0.0);
        let depth = inside.min(RECOVERY * p.step) - (b - contact).dot(normal);
        Kept { place: self.stopped(a, b, normal, depth).unwrap_or(predicted), inside }
    }

    /// Place, seen from the body, on a way from `a` to `b` that a plane lifts by a depth, and along which friction holds it back.
    fn stopped(&self, a: DVec3, b: DVec3, normal: DVec3, depth: f64) -> Option<DVec3> {
        let friction = self.body.friction;
        let way = b + depth * normal - a;
        let slide = way.reject_from_normalized(normal);
        let kept = if slide.length() > friction * depth { 1.0 - friction * depth / slide.length() } else { 0.0 };
        (depth > 0.0).then(|| self.after.out(a + way - slide + kept * slide))
    }

    /// The same of a place that is the nearest of its segment where it goes: the plane touches the body where the place ends, unless
    /// that is on another side than where its way enters.
    fn keep_nearest(&self, p: &Parameters, position: DVec3, predicted: DVec3) -> Kept {
        let Self { body, before, after } = self;
        let (a, b) = (before.back(position), after.back(predicted));
        let Some(contact) = body.entry(a, b) else { return Kept { place: predicted, inside: 0.0 } };
        let (distance, normal) = body.shape.signed_distance(contact);
        let (distance_there, normal_there) = body.shape.signed_distance(b);
        let inside = (-distance).max(0.0);
        let recovered = inside.min(RECOVERY * p.step);
        let stopped = if normal.dot(normal_there) > SAME_SIDE {
            self.stopped(a, b, normal_there, recovered - inside - distance_there)
        } else {
            self.stopped(a, b, normal, recovered - (b - contact).dot(normal))
        };
        Kept { place: stopped.unwrap_or(predicted), inside }
    }

    /// Part of a segment at which it is nearest to the body after the step.
    pub(super) fn nearest(&self, [first, second]: [DVec3; 2]) -> f64 {
        self.body.nearest(self.after.back(first), self.after.back(second))
    }

    /// Signed distance of a place after the step \[m\], and the way out.
    pub(super) fn surface(&self, x: DVec3) -> (f64, DVec3) {
        let (distance, normal) = self.body.shape.signed_distance(self.after.back(x));
        (distance, self.after.rotation * normal)
    }
}

/// Place of a hair point that was at `position` and would be at `predicted`, kept out of all bodies.
#[must_use]
pub fn hair(p: &Parameters, placed: &[Placed], position: DVec3, predicted: DVec3) -> Kept {
    (0..ROUNDS).flat_map(|_| placed).fold(Kept { place: predicted, inside: 0.0 }, |x, placed| {
        let kept = placed.keep(p, position, x.place);
        Kept { place: kept.place, inside: x.inside.max(kept.inside) }
    })
}

/// Whether a depth \[m\] takes hair more than a step to come out of.
pub(super) fn is_deep(p: &Parameters, inside: f64) -> bool {
    inside > RECOVERY * p.step
}

/// Segment with ends of the inverse masses `give` that were at `before` and would be at `ends`, kept out of all bodies.
///
/// The segment's place nearest to a body, (1 − t) x₀ + t x₁, is kept out like a point. To push the place by d, the ends are pushed by
/// (1 − t) w₀ d/r and t w₁ d/r, with r = (1 − t)² w₀ + t² w₁. Where its second end is held inside a body the
/// segment is left as it is.
#[must_use]
pub fn clear(p: &Parameters, placed: &[Placed], give: [f64; 2], before: [DVec3; 2], ends: [DVec3; 2]) -> Cleared {
    let mut x = Cleared { ends, push: 0.0, inside: 0.0 };
    for placed in placed {
        let t = placed.nearest(x.ends);
        let share = [(1.0 - t) * give[0], t * give[1]];
        let response = (1.0 - t) * share[0] + t * share[1];
        let held_inside = give[1] == 0.0 && placed.surface(x.ends[1]).0 < 0.0;
        if response == 0.0 || held_inside {
            continue;
        }
        let goes = x.ends[0].lerp(x.ends[1], t);
        let kept = placed.keep_nearest(p, before[0].lerp(before[1], t), goes);
        let push = kept.place - goes;
        for (end, share) in x.ends.iter_mut().zip(share) {
            *end += (share / response).min(AT_MOST) * push;
        }
        x.push = x.push.max(push.length());
        x.inside = x.inside.max(kept.inside);
    }
    x
}
