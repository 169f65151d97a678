//! Who is near whom: every pair is looked at.

use std::thread;

use glam::DVec3;

use crate::Parameters;

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
    // Most pairs are far apart on the first axis already, in whichever image: no need of their distance.
    let far = |gap: f64, side: f64| gap.abs() > h && gap.abs() < side - h;
    let clear = |a: DVec3, b: DVec3| far(a.x - b.x, p.box_size.x) || far(a.y - b.y, p.box_size.y);
    let near = |i: usize| -> Vec<u32> {
        let within = |j: usize| p.separation(i, j, positions[i], positions[j]).length_squared() < h * h;
        let meets = |&j: &usize| !clear(positions[i], positions[j]) && i != j && within(j);
        (0..positions.len()).filter(meets).map(|j| j as u32).collect()
    };
    let share = positions.len().div_ceil(thread::available_parallelism().map_or(1, usize::from)).max(1);
    let mut lists = vec![Vec::new(); positions.len()];
    thread::scope(|scope| {
        for (part, lists) in lists.chunks_mut(share).enumerate() {
            let near = &near;
            scope.spawn(move || {
                for (k, list) in lists.iter_mut().enumerate() {
                    *list = near(part * share + k);
                }
            });
        }
    });
    Neighbours { lists }
}
