//! The neighbour list as the GPU makes it (`shaders/common/list.wgsl`), read on the CPU.

use glam::IVec3;
use windswept_shaders::common::{
    lanes::LANES,
    list::{BATCH, FRAME_BITS, HEADER, IMAGE_BITS, INDEX, NOBODY},
};

/// A particle that is near a cluster.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Seen {
    /// Index of the particle.
    pub index: u32,
    /// Boxes by which the particle is moved to where it is seen.
    pub image: IVec3,
    /// Which of the cluster's particles it is a neighbour of, bit by bit.
    pub met_by: u32,
}

/// Up to eight particles, and who is near any of them.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Cluster {
    /// The particles, all of one kind.
    pub particles: Vec<u32>,
    /// Those near them of their own kind; of both kinds unless the model is `two-way`.
    pub own_kind: Vec<Seen>,
    /// Those near them of the other kind.
    pub other_kind: Vec<Seen>,
}

/// The clusters that have particles, from the words of the list for so many clusters.
#[must_use]
pub fn read(list: &[u32], clusters: u32) -> Vec<Cluster> {
    let headers = list.chunks_exact(HEADER as usize).take(clusters as usize).filter(|header| header[0] > 0);
    let cluster = |header: &[u32]| {
        let near = header[0] + LANES;
        let moved = |bit: u32| (header[1] >> (FRAME_BITS + bit) & 1).cast_signed();
        let frame = IVec3::new(moved(0), moved(1), moved(2));
        let own = header[1] & ((1 << FRAME_BITS) - 1);
        let part = |first: u32, count: u32| -> Vec<Seen> {
            let words = &list[first as usize..(first + BATCH * count) as usize];
            words.chunks_exact(BATCH as usize).flat_map(|words| batch(words, frame)).collect()
        };
        let particles = &list[header[0] as usize..near as usize];
        Cluster {
            particles: particles.iter().copied().filter(|word| *word != NOBODY).collect(),
            own_kind: part(near, own),
            other_kind: part(near + BATCH * own, header[2]),
        }
    };
    headers.map(cluster).collect()
}

fn batch(words: &[u32], frame: IVec3) -> Vec<Seen> {
    let (entries, bytes) = words.split_at(LANES as usize);
    let meets = |particle: usize, k: usize| bytes[particle / 4] >> (8 * (particle % 4) + (particle ^ k)) & 1;
    let seen = |(k, word): (usize, &u32)| {
        let turns = |bit: u32| (word >> (IMAGE_BITS + bit) & 3).cast_signed() - 1;
        Seen {
            index: word & INDEX,
            image: IVec3::new(turns(0), turns(2), turns(4)) + frame,
            met_by: (0..LANES as usize).map(|particle| meets(particle, k) << particle).sum(),
        }
    };
    entries.iter().enumerate().filter(|(_, word)| **word != NOBODY).map(seen).collect()
}

/// Neighbours of each of so many particles, in rising order.
#[must_use]
pub fn neighbours(clusters: &[Cluster], particles: u32) -> Vec<Vec<u32>> {
    let mut all = vec![Vec::new(); particles as usize];
    for cluster in clusters {
        for (k, i) in cluster.particles.iter().enumerate() {
            let both = cluster.own_kind.iter().chain(&cluster.other_kind);
            let near = &mut all[*i as usize];
            *near = both.filter(|seen| seen.met_by >> k & 1 == 1).map(|seen| seen.index).collect();
            near.sort_unstable();
        }
    }
    all
}
