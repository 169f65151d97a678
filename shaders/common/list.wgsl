// How the neighbour list is laid out, in elements of four words.
//
// It has pages, as many as it takes for a pass to bind one at a time: most GPUs bind 2 GiB and more, WebGPU by default 128 MiB.
// Workgroups of clusters take turns among the pages, so that all are about as full. Passes over clusters run once for each page.
//
// A page begins with an element per cluster: where its own elements begin, how many batches it has of its own kind and of the other kind, and its
// first particle. With the number of its own kind's batches come three bits, its frame: along which axes the cluster is moved by a box
// towards 0 to meet the others. A cluster at the upper faces is, so that who comes through them stands where it is: to add a box to a
// position would round it, to take one away does not, and the impulses of a pair are opposite to the last bit.
// The elements of a cluster are its particles, a word each, then two parts: those of the cluster's kind, or of both kinds unless the
// model is TWO_WAY, then those of the other kind.
// A part is batches of eight entries, one for each invocation of the cluster to read. Four batches make a group, and a part ends with
// a group that may be full in part. A group is eight elements, which are what each invocation reads in the four batches, and two
// more, with a word for each particle of the cluster: a byte per batch says which of its entries the particle meets. Bit k stands for
// the entry whose place differs from the particle's in the bits of k, which is the one that `lanes::shown_by(k)` shows.
// What is left over in a part's last batch is NOBODY, and a cluster's particles are filled up with it too.

const PAGES: u32 = 4u;            // at most
const PARTICLES: u32 = 2u;        // elements that are a cluster's particles
const BATCHES: u32 = 4u;          // of a group
const GROUP: u32 = 10u;           // elements of a group
const NOBODY: u32 = 0xffffffffu;  // an entry that is no particle
const INDEX: u32 = 0x03ffffffu;   // bits of an entry that are the particle's index
const IMAGE_BITS: u32 = 26u;      // bit from which on an entry says which image its particle is in, as seen from the frame: 1 and -1, 0 or 1 per axis
const FRAME_BITS: u32 = 29u;      // bit from which on the number of the own kind's batches has the frame
const FAR: f32 = 1e9;             // m, where nobody is

// Groups of so many batches.
fn groups_of(batches: u32) -> u32 {
    return (batches + BATCHES - 1u) / BATCHES;
}
