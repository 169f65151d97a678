//! The shape of one strand: its turning angle, its turns, its undulation.

use std::f64::consts::TAU;

use glam::DVec3;

/// Directions of the segments of a strand, of length 1; those of segments without length are left out.
pub(super) fn directions(points: &[DVec3]) -> Vec<DVec3> {
    points.windows(2).filter_map(|ends| (ends[1] - ends[0]).try_normalize()).collect()
}

/// Angle between two vectors, exact near 0 and π too.
pub(super) fn angle(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}

/// Turning angle [rad].
pub(super) fn turning(directions: &[DVec3]) -> f64 {
    let mut sum = DVec3::ZERO;
    let mut sums = vec![sum];
    for pair in directions.windows(2) {
        sum += rotation(pair[0], pair[1]);
        sums.push(sum);
    }
    let apart = |(k, a): (usize, &DVec3)| sums[..k].iter().map(|b| a.distance_squared(*b)).fold(0.0, f64::max);
    sums.iter().enumerate().map(apart).fold(0.0, f64::max).sqrt()
}

/// Vector of the smallest rotation that takes one direction to another: its axis times its angle [rad].
fn rotation(from: DVec3, to: DVec3) -> DVec3 {
    let axis = from.cross(to);
    // Opposite directions have no axis of their own.
    let otherwise = if from.dot(to) < 0.0 { from.any_orthonormal_vector() } else { DVec3::ZERO };
    axis.try_normalize().unwrap_or(otherwise) * angle(from, to)
}

/// Turns of a curl about the chord, a vector of length 1.
pub(super) fn turns(directions: &[DVec3], chord: DVec3) -> f64 {
    // The bend at a point, seen along the chord. On a helix bends have one length, and each is turned from the last by
    // the same angle; a chord that is not quite the axis changes that angle in second order only.
    let bends: Vec<_> = directions.windows(2).map(|pair| (pair[1] - pair[0]).reject_from_normalized(chord)).collect();
    let pairs = || bends.windows(2).map(|pair| (pair[0], pair[1]));
    let sine: f64 = pairs().map(|(a, b)| a.cross(b).dot(chord)).sum();
    let cosine: f64 = pairs().map(|(a, b)| a.dot(b)).sum();
    let straight = bends.iter().map(|bend| bend.length_squared()).sum::<f64>() < 1e-6 * bends.len() as f64;
    let step = sine.abs().atan2(cosine);
    if straight || step > TAU / 3.0 { 0.0 } else { directions.len() as f64 * step / TAU }
}

/// ∫|p|² ds [m] and ∫|dp/ds|² ds [1/m] over a strand, of the part p of its direction that is across the chord, a vector
/// of length 1.
pub(super) fn undulation(points: &[DVec3], chord: DVec3) -> [f64; 2] {
    let segments = points.windows(2).map(|ends| ends[1] - ends[0]).filter(|segment| segment.length() > 0.0);
    let segments: Vec<_> = segments.map(|s| (s.length(), s.normalize().reject_from_normalized(chord))).collect();
    let length: f64 = segments.iter().map(|(length, _)| length).sum();
    let across: f64 = segments.iter().map(|(length, across)| length * across.length_squared()).sum();
    let (mut bends, mut inner) = (0.0, 0.0);
    for pair in segments.windows(2) {
        let [(l0, p0), (l1, p1)] = [pair[0], pair[1]];
        let between = 0.5 * (l0 + l1);
        bends += p0.distance_squared(p1) / between;
        inner += between;
    }
    // No bend is known in the outer halves of the first and of the last segment; it is taken as the mean of the others.
    [across, if inner > 0.0 { bends * length / inner } else { 0.0 }]
}

/// Length of a strand [m].
pub(super) fn length(points: &[DVec3]) -> f64 {
    points.windows(2).map(|ends| ends[0].distance(ends[1])).sum()
}

/// Place at a part, 0 to 1, of a strand's length.
pub(super) fn at(points: &[DVec3], part: f64) -> DVec3 {
    let mut left = part * length(points);
    for ends in points.windows(2) {
        let length = ends[0].distance(ends[1]);
        if left < length {
            return ends[0].lerp(ends[1], left / length);
        }
        left -= length;
    }
    points[points.len() - 1]
}
