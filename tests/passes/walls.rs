//! Bodies as walls to the pressure of the air, in stage `fluid`.

use glam::DVec3;
use windswept_reference::fluid;
use windswept_shaders::common::by_body::CHUNKS;

use crate::{
    fixture::xyz,
    walk::{Both, largest},
};

/// Largest difference of the impulses that bodies have from particles from `first` on so far, in parts of the largest
/// if that is more than 10 m/s.
pub fn impulses_apart(b: &Both<'_>, first: usize) -> f64 {
    let walls = b.read(&b.state().wall);
    let both = walls.iter().zip(&b.w.walls).skip(first);
    let most = largest(both.clone().map(|(_, wanted)| wanted.impulse.length())).max(10.0) / 10.0;
    largest(both.map(|(got, wanted)| (xyz(&got.impulse) - wanted.impulse).length())) / most
}

/// Differences of walls: how many are of another body, distances \[m\], normals, ways and weights, speeds \[m/s\].
pub fn walls_apart(b: &Both<'_>) -> [f64; 4] {
    let p = b.p();
    let walls = b.read(&b.state().wall);
    // Farther off a wall does nothing.
    let near = 8.0 * p.spacing();
    let both = || walls.iter().zip(&b.w.walls).skip(b.flowing()).filter(|(_, wanted)| wanted.distance < near);
    let bodies = both().filter(|(got, wanted)| got.body as usize != wanted.body).count();
    let lengths = largest(both().map(|(got, wanted)| (f64::from(got.distance) - wanted.distance).abs()));
    let normals = largest(both().map(|(got, wanted)| (xyz(&got.normal) - wanted.normal).length()));
    let speeds = both().map(|(got, wanted)| (f64::from(got.speed) - wanted.velocity.dot(wanted.normal)).abs());
    let ways = largest(both().map(|(got, wanted)| (f64::from(got.way) - wanted.way).abs()));
    let weights = both().map(|(got, wanted)| {
        p.kernel_radius * (f64::from(got.weight) - fluid::gradient_beyond(p, wanted.distance)).abs()
    });
    [bodies as f64, lengths, normals.max(ways).max(largest(weights)), largest(speeds)]
}

/// Sums over each body as if air filled it, of the parts that the engine has.
pub fn sums_by_body(b: &Both<'_>) -> Vec<[f64; 8]> {
    let parts = b.read(&b.state().partial_by_body);
    let sum = |parts: &[[f32; 8]]| std::array::from_fn(|k| parts.iter().map(|part| f64::from(part[k])).sum());
    parts.chunks(CHUNKS as usize).map(sum).collect()
}

/// Largest difference of these sums, over the particles that would fill the body.
pub fn solids_apart(b: &Both<'_>, got: impl Iterator<Item = [f64; 8]>) -> f64 {
    largest(got.zip(&b.w.solids).map(|(got, wanted)| {
        let count = wanted.particles.max(1.0);
        let change = (DVec3::new(got[0], got[1], got[2]) - wanted.change).length().max((got[3] - wanted.work).abs());
        let velocity = (DVec3::new(got[4], got[5], got[6]) - wanted.velocity).length();
        change.max(velocity).max((got[7] - wanted.particles).abs()) / count
    }))
}
