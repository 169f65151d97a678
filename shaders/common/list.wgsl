// Layout of the neighbour list, in elements of four words.
//
// It has pages, as many as it takes for a pass to bind one at a time: most GPUs bind 2 GiB and more, WebGPU by default
// 128 MiB. Workgroups of clusters are dealt to the pages in turn, so that all are about as full. Passes over clusters
// run once for each page.
//
// A page begins with the heads of its clusters, eight elements for each, one for each invocation: its particle, where
// the cluster's groups begin, and how many batches the cluster has of its own kind and of the other kind. An invocation
// without a particle has the cluster's first one, marked with NONE. With the number of the own kind's batches come
// three bits, the cluster's box shift: along which axes it is moved by a box towards 0 to meet its neighbours. A
// cluster at an upper face is shifted down by one box, so neighbours across the face keep their stored coordinates:
// adding a box to a position would round it, subtracting one does not, and the impulses of a pair are opposite to the
// last bit.
//
// The groups of a cluster are two parts: those of the cluster's kind, or of both kinds unless the model is TWO_WAY,
// then those of the other kind. A part is batches of eight entries, one for each invocation of the cluster to read.
// Three batches make a group, which is eight elements, one for each invocation; the last group of a part may be full in
// part. An element has the three entries that its invocation reads, and a word with the neighbours of its particle, a
// byte per batch. Bit k stands for the entry of lane own ^ k, which `lanes::from_lane(k)` returns. Unused entries of a
// part's last batch are NOBODY.
import package::common::{lanes::LANES, params::params};

const PAGES: u32 = 4u;            // at most
const BATCHES: u32 = 3u;          // of a group
const NOBODY: u32 = 0xffffffffu;  // an entry that is no particle
const INDEX: u32 = 0x03ffffffu;   // bits of an entry, or of a head, that are the particle's index
const NONE: u32 = 0x80000000u;    // bit of a head that says that the invocation has no particle
// bit from which on an entry has its particle's periodic image, relative to the cluster's box shift: 1 plus the offset
// -1, 0 or 1 in boxes, per axis
const IMAGE_BITS: u32 = 26u;
const FRAME_BITS: u32 = 29u;      // bit from which on the number of the own kind's batches has the box shift
const FAR: f32 = 1e9;             // m, beyond the kernel radius of any particle

// Elements of a page that are heads: its first.
fn heads() -> u32 {
    return LANES * params.page_clusters;
}

// Elements of the groups of so many batches.
fn elements_of(batches: u32) -> u32 {
    return LANES * ((batches + BATCHES - 1u) / BATCHES);
}
