//! Followers that gather to locks, `hair.clump`.
//!
//! Of a group's strands some are centres: in their order those whose roots are at least the clump's size from that of
//! each centre before. A follower is drawn to the centre whose root is nearest to its own, and then keeps the lengths
//! of its segments:
//!
//! ```text
//! x'(t) = x(t) + a s (c(t) - x(t))        s = strength (1 - noise u)
//! ```
//!
//! where a goes from 0 at the root to 1 at the tip, c is the point as far along the centre, and u is a number from 0 to
//! 1 of the follower's own.

use std::collections::HashMap;

use glam::{IVec3, Vec3};
use windswept_scene::Clump;

use super::places::Places;
use super::{chance, hash};

/// Draws followers of a group to its centres.
pub(super) struct Locks {
    /// Indices of the strands that are centres.
    centres: Vec<usize>,
    places: Places,
    clump: Clump,
    seed: u32,
}

/// The lock that a follower gathers to.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lock {
    /// The strand at its centre.
    pub(super) centre: u32,
    /// Part of the way there that the follower's tip is drawn.
    pub(super) strength: f32,
}

impl Locks {
    /// The locks of a group whose first strand has index `first` and whose roots are these.
    pub(super) fn new(clump: Clump, seed: u64, first: usize, roots: &[Vec3]) -> Self {
        let size = clump.size as f32;
        // Centres by cells as wide as they are apart: those near a root are in the cells about its own.
        let mut cells: HashMap<IVec3, Vec<Vec3>> = HashMap::new();
        let mut centres = Vec::new();
        for (i, &root) in roots.iter().enumerate() {
            let cell = (root / size).floor().as_ivec3();
            let about = (0..27).map(|k| cell.saturating_add(IVec3::new(k % 3, k / 3 % 3, k / 9) - 1));
            if about.filter_map(|cell| cells.get(&cell)).flatten().all(|centre| centre.distance(root) >= size) {
                cells.entry(cell).or_default().push(root);
                centres.push(i);
            }
        }
        let places = Places::new(centres.iter().map(|&i| roots[i]).collect());
        Self { centres: centres.iter().map(|i| first + i).collect(), places, clump, seed: seed as u32 }
    }

    /// The lock of follower `k` of the group, whose root is here.
    pub(super) fn of(&self, k: usize, root: Vec3) -> Option<Lock> {
        let (nearest, _) = *self.places.nearest(root, 1).first()?;
        let without = self.clump.noise as f32 * chance(self.seed ^ hash(k as u32 + 1), 4);
        Some(Lock { centre: self.centres[nearest] as u32, strength: self.clump.strength as f32 * (1.0 - without) })
    }
}
