//! Segments of followers keep the lengths that they have at the start.
//!
//! Strands that part, cross or turn unlike average to segments that are shorter or longer than any of theirs. A
//! follower keeps the directions of the average, and is laid along them root to tip:
//!
//! ```text
//! y_k = y_(k-1) + l_k u_k                                 u_k = d_k / |d_k|     d_k = x_k - x_(k-1)
//! w_k = w_(k-1) + l_k/|d_k| (e_k - u_k (u_k . e_k))                             e_k = v_k - v_(k-1)
//! ```
//!
//! where `x_k` and `v_k` are place and velocity of a point of the average, `l_k` is the length at the start of the
//! segment before it, and `w_k` is the derivative of `y_k` by time.

use glam::Vec3;

/// Part of its length to which the average may shorten a segment before its turning is taken for slower than it is. A
/// segment that is shortened to nothing turns at once, and with no speed that means anything.
const SHORTEST: f32 = 0.1;

/// Lays a hair along the directions of its segments with the lengths that they have in `start`: `positions` \[m\] from
/// root to tip, and `velocities` \[m/s\] with them, unless these are empty. The root stays.
pub(super) fn keep(start: &[[f32; 3]], positions: &mut [[f32; 3]], velocities: &mut [[f32; 3]]) {
    let vector = Vec3::from_array;
    let first = |rows: &[[f32; 3]]| rows.first().copied().map_or(Vec3::ZERO, vector);
    let (mut place, mut speed) = (first(positions), first(velocities));
    let (mut moved, mut sped, mut way) = (Vec3::ZERO, Vec3::ZERO, Vec3::ZERO);
    for k in 1..positions.len() {
        let at_start = vector(start[k]) - vector(start[k - 1]);
        let length = at_start.length();
        let x = vector(positions[k]);
        let segment = x - place;
        let before = way.normalize_or(at_start.normalize_or_zero());
        way = segment.normalize_or(before);
        moved += length * way - segment;
        positions[k] = (x + moved).to_array();
        place = x;
        if let Some(velocity) = velocities.get_mut(k) {
            let v = vector(*velocity);
            let change = v - speed;
            let grown = length / segment.length().max(SHORTEST * length).max(f32::MIN_POSITIVE);
            sped += grown * change.reject_from_normalized(way) - change;
            *velocity = (v + sped).to_array();
            speed = v;
        }
    }
}
