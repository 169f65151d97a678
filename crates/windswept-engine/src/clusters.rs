//! The neighbour list as the GPU makes it (`shaders/common/list.wgsl`), read on the CPU.

use glam::IVec3;
use windswept_shaders::common::{
    lanes::LANES,
    list::{BATCHES, FRAME_BITS, IMAGE_BITS, INDEX, NOBODY, NONE},
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

/// Number of workgroups in a page, of the first `workgroups` of all clusters: they take turns among the pages of the
/// list.
pub(crate) fn workgroups_of_page(workgroups: u32, page: u32, pages: u32) -> u32 {
    workgroups.saturating_sub(page).div_ceil(pages.max(1))
}

/// The clusters that have particles, from a page of the list that has room for so many clusters.
#[must_use]
pub fn read(list: &[[u32; 4]], clusters: u32) -> Vec<Cluster> {
    let heads = list.chunks_exact(LANES as usize).take(clusters as usize).filter(|heads| heads[0][1] > 0);
    let cluster = |heads: &[[u32; 4]]| {
        let [_, groups, own, others] = heads[0];
        let moved = |bit: u32| (own >> (FRAME_BITS + bit) & 1).cast_signed();
        let frame = IVec3::new(moved(0), moved(1), moved(2));
        let own = own & ((1 << FRAME_BITS) - 1);
        let part = |first: u32, batches: u32| -> Vec<Seen> {
            let group = |k: u32| &list[(first + LANES * (k / BATCHES)) as usize..][..LANES as usize];
            (0..batches).flat_map(|k| batch(group(k), (k % BATCHES) as usize, frame)).collect()
        };
        Cluster {
            particles: heads.iter().map(|head| head[0]).filter(|particle| particle & NONE == 0).collect(),
            own_kind: part(groups, own),
            other_kind: part(groups + LANES * own.div_ceil(BATCHES), others),
        }
    };
    heads.map(cluster).collect()
}

/// A batch of a group, by its place among the group's.
fn batch(group: &[[u32; 4]], place: usize, frame: IVec3) -> Vec<Seen> {
    let meets = |particle: usize, k: usize| group[particle][BATCHES as usize] >> (8 * place + (particle ^ k)) & 1;
    let seen = |(k, words): (usize, &[u32; 4])| {
        let word = words[place];
        let turns = |bit: u32| (word >> (IMAGE_BITS + bit) & 3).cast_signed() - 1;
        let met_by = (0..LANES as usize).map(|particle| meets(particle, k) << particle).sum();
        let image = IVec3::new(turns(0), turns(2), turns(4)) + frame;
        (word != NOBODY).then_some(Seen { index: word & INDEX, image, met_by })
    };
    group.iter().enumerate().filter_map(seen).collect()
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
