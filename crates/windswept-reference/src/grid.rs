//! Who is near whom: every pair is looked at.

use glam::DVec3;

use crate::{Parameters, parallel};

/// Neighbours of each particle, in rising order.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Neighbours {
    lists: Vec<Vec<u32>>,
}

impl Neighbours {
    /// Those of particle `i`.
    pub fn of(&self, i: usize) -> impl Iterator<Item = usize> + '_ {
        self.lists[i].iter().map(|&j| j as usize)
    }

    /// How many particle `i` has.
    #[must_use]
    pub fn count(&self, i: usize) -> usize {
        self.lists[i].len()
    }
}

/// All pairs nearer than the kernel radius, i = j left out. O(n²), on all cores.
#[must_use]
pub fn neighbours(p: &Parameters, positions: &[DVec3]) -> Neighbours {
    let h = p.kernel_radius;
    let near = |i: usize| -> Vec<u32> {
        let within = |j: usize| p.separation(i, j, positions[i], positions[j]).length_squared() < h * h;
        let meets = |&j: &usize| !p.far_apart(positions[i] - positions[j], h) && i != j && within(j);
        (0..positions.len()).filter(meets).map(|j| j as u32).collect()
    };
    Neighbours { lists: parallel::map(positions.len(), near) }
}
