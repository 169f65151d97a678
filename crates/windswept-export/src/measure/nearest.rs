//! Nearest neighbours among points.

use glam::DVec3;

/// Number of neighbours.
const FOUR: usize = 4;

/// Distance [m] and index of the four nearest others of each point, one point after the other; of all others where they
/// are fewer.
pub(super) fn nearest(points: &[DVec3]) -> Vec<(f64, usize)> {
    let count = FOUR.min(points.len().saturating_sub(1));
    let axis = longest_axis(points);
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&a, &b| points[a][axis].total_cmp(&points[b][axis]));
    let mut found = vec![(0.0, 0); count * points.len()];
    for rank in 0..order.len() {
        let best = around(points, &order, rank, axis);
        found[count * order[rank]..][..count].copy_from_slice(&best[..count]);
    }
    found
}

/// The nearest others of the point at `rank` of the order along an axis.
fn around(points: &[DVec3], order: &[usize], rank: usize, axis: usize) -> [(f64, usize); FOUR] {
    let point = points[order[rank]];
    let gap = |other: usize| (points[other][axis] - point[axis]).abs();
    let (mut below, mut above) = (order[..rank].iter().rev().peekable(), order[rank + 1..].iter().peekable());
    let mut best = [(f64::INFINITY, 0); FOUR];
    loop {
        let next = match (below.peek(), above.peek()) {
            (Some(&&a), Some(&&b)) if gap(a) <= gap(b) => below.next(),
            (Some(_), None) => below.next(),
            _ => above.next(),
        };
        // The remaining points are farther away along the axis alone than the fourth nearest.
        let Some(&next) = next.filter(|next| gap(**next) < best[FOUR - 1].0) else { return best };
        let distance = points[next].distance(point);
        if distance < best[FOUR - 1].0 {
            best[FOUR - 1] = (distance, next);
            best.sort_by(|a, b| a.0.total_cmp(&b.0));
        }
    }
}

/// The axis along which points are spread farthest.
fn longest_axis(points: &[DVec3]) -> usize {
    let low = points.iter().fold(DVec3::INFINITY, |low, point| low.min(*point));
    let high = points.iter().fold(DVec3::NEG_INFINITY, |high, point| high.max(*point));
    let spread = (high - low).to_array();
    (0..3).max_by(|&a, &b| spread[a].total_cmp(&spread[b])).unwrap_or(0)
}
