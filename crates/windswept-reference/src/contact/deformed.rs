//! A mesh that deforms in a step: the distances of two poses are mixed node by node, and so are the moves of the
//! surface.

use glam::DVec3;
use windswept_scene::{DistanceGrid, Frames, Lattice, Phase};

/// A mesh that deforms, in its own place.
#[derive(Debug, Clone, PartialEq)]
pub struct Deformed {
    /// Distances after the step \[m\].
    pub grid: DistanceGrid,
    /// Move of the surface in the step near each node \[m\].
    pub moves: Vec<DVec3>,
}

impl Deformed {
    /// The mesh in a step between two times \[s\].
    #[must_use]
    pub fn new(frames: &Frames, before: f64, after: f64) -> Self {
        let [left, reached] = [before, after].map(|time| frames.phase(time));
        let Lattice { origin, spacing, counts } = *frames.lattice();
        let nodes = frames.lattice().nodes();
        let values = |pose: usize| frames.bake(pose.min(frames.len() - 1));
        let (now, next) = (values(reached.pose), values(reached.pose + 1));
        let mix = |(a, b): (&f32, &f32)| (f64::from(*a) + reached.part * f64::from(b - a)) as f32;
        let distances = now.iter().zip(&next).take(nodes).map(mix).collect();
        let mut moves = vec![DVec3::ZERO; nodes];
        // Each pose on the way is reached by a part of its own move.
        for pose in left.pose..=reached.pose + 1 {
            let gone = |at: Phase| (at.pose as f64 + at.part - (pose as f64 - 1.0)).clamp(0.0, 1.0);
            let part = gone(reached) - gone(left);
            if part > 0.0 {
                let values = values(pose);
                let own = values[nodes..].chunks_exact(3).map(|x| DVec3::new(x[0].into(), x[1].into(), x[2].into()));
                moves.iter_mut().zip(own).for_each(|(sum, own)| *sum += part * own);
            }
        }
        Self { grid: DistanceGrid { origin, spacing, counts, values: distances }, moves }
    }

    /// Move of the surface in the step near a place \[m\].
    #[must_use]
    pub fn moved(&self, x: DVec3) -> DVec3 {
        let counts = self.grid.counts.map(|count| count as usize);
        let last = DVec3::from_array(counts.map(|count| count as f64 - 1.0));
        let place = ((x - self.grid.origin) / self.grid.spacing).clamp(DVec3::ZERO, last);
        let cell = place.floor().min(last - 1.0);
        let corner = |k: usize| DVec3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
        let term = |k: usize| {
            let seat = cell + corner(k);
            let weight = (DVec3::ONE - (place - seat).abs()).element_product();
            weight * self.moves[(seat.z as usize * counts[1] + seat.y as usize) * counts[0] + seat.x as usize]
        };
        (0..8).map(term).sum()
    }
}
