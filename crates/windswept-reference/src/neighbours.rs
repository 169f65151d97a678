//! Stage `neighbours`: lists of neighbours, by a test of every pair.

use glam::DVec3;

use crate::{Parameters, parallel, step::Scratch};

/// Runs the stage: the pairs that are nearer than the kernel radius are listed.
pub fn run(w: &mut Scratch, p: &Parameters) {
    if p.air {
        w.near = list(p, &w.predicted);
    }
}

/// Neighbours of each particle, in rising order.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Neighbours {
    lists: Vec<Vec<u32>>,
}

impl Neighbours {
    /// Neighbours of particle `i`.
    pub fn of(&self, i: usize) -> impl Iterator<Item = usize> + '_ {
        self.lists[i].iter().map(|&j| j as usize)
    }

    /// Number of neighbours of particle `i`.
    #[must_use]
    pub fn count(&self, i: usize) -> usize {
        self.lists[i].len()
    }
}

/// Pairs nearer than the kernel radius, i = j left out: of particles sorted along x those in reach, on all cores.
#[must_use]
pub fn list(p: &Parameters, positions: &[DVec3]) -> Neighbours {
    let h = p.kernel_radius;
    // Along x each particle stands where it is, and where its images are that air may meet through the faces.
    let images = |(j, x): (usize, &DVec3)| {
        let x = x.x;
        [-1.0, 0.0, 1.0]
            .map(|image| (x + image * p.box_size.x, j as u32))
            .into_iter()
            .enumerate()
            .filter_map(move |(k, image)| (k == 1 || p.is_air(j)).then_some(image))
    };
    let mut along: Vec<(f64, u32)> = positions.iter().enumerate().flat_map(images).collect();
    along.sort_by(|a, b| a.0.total_cmp(&b.0));
    let near = |i: usize| -> Vec<u32> {
        let x = positions[i];
        let first = along.partition_point(|(at, _)| *at < x.x - h);
        let beside = along[first..].iter().take_while(|(at, _)| *at <= x.x + h).map(|(_, j)| *j as usize);
        let within = |j: usize| p.separation(i, j, x, positions[j]).length_squared() < h * h;
        let meets = |&j: &usize| !p.far_apart(x - positions[j], h) && i != j && within(j);
        let mut near: Vec<u32> = beside.filter(meets).map(|j| j as u32).collect();
        near.sort_unstable();
        near.dedup();
        near
    };
    Neighbours { lists: parallel::map(positions.len(), near) }
}
