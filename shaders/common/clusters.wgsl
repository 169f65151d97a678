// The loop over neighbours, which all passes share.
//
// A cluster is up to eight particles of one kind that are next to one another in the order of cells. One list says who is nearer
// than the kernel radius to any of them. Its eight invocations, one per particle, read a batch of eight entries at once, one
// each; then each of them meets all eight. A pass says what it needs of a neighbour, in `see`, and what a pair adds to its sums, in `meet`.
// A pair that was not nearer than the kernel radius when the list was made does not meet, wherever it is by now.
import package::common::{params::params, dispatch::{invocation, WORKGROUP}};
import package::common::lanes::{Near, LANES, lane_of, show, shown_by, largest_of_all};
import package::common::list::{HEADER, BATCH, NOBODY, INDEX, IMAGE_BITS, FRAME_BITS, FAR};
import package::pass::{see, meet};

@group(0) @binding(20) var<storage, read> neighbour_list: array<u32>;

struct Cluster {
    first: u32,    // word of its first particle
    own: u32,      // batches of its own kind
    others: u32,   // batches of the other kind
}

var<private> cluster: Cluster;
var<private> place: u32;    // of the invocation in its workgroup
var<private> box: vec3f;    // m, sides of the box of air
var<private> frame: vec3f;  // m, by which the cluster is moved towards 0 to meet others
var<private> meets: u32;    // bit by bit, which entries of the batch that is shown the invocation meets
var<private> nobody: bool;  // the invocation reads for the others, and has no particle
var<private> member: u32;   // a particle of the cluster, which is read where an entry is none: what it has is of the cluster's kind

// The particle of an invocation, whose cluster `meet_own_kind` and `meet_other_kind` go through from now on. Where `has_none` says that the
// invocation has none, it is another one of the cluster.
fn take_particle(entry: u32, local: u32) -> u32 {
    place = local;
    box = params.box_size;
    cluster = Cluster();
    let c = entry / LANES;
    if c < params.clusters {
        let own = neighbour_list[HEADER * c + 1u];
        let moved = vec3u(own >> FRAME_BITS, own >> (FRAME_BITS + 1u), own >> (FRAME_BITS + 2u)) & vec3u(1u);
        frame = box * vec3f(moved);
        cluster = Cluster(neighbour_list[HEADER * c], own & ((1u << FRAME_BITS) - 1u), neighbour_list[HEADER * c + 2u]);
    }
    let own = neighbour_list[cluster.first + lane_of(local)];
    member = select(neighbour_list[cluster.first], 0u, cluster.first == 0u);
    nobody = cluster.first == 0u || own == NOBODY;
    return select(own, member, nobody);
}

fn has_none() -> bool {
    return nobody;
}

// The place of an invocation in the order of clusters, in a pass over all of them or over those of air. Clusters of hair come first.
fn of_all(id: vec3u, groups: vec3u) -> u32 {
    return invocation(id, groups);
}

fn of_air(id: vec3u, groups: vec3u) -> u32 {
    return LANES * params.hair_clusters + invocation(id, groups);
}

// Meets those of the own kind, or all unless the model is TWO_WAY.
fn meet_own_kind() {
    meet_batches(cluster.first + LANES, cluster.own);
}

// Meets those of the other kind, if the model is TWO_WAY.
fn meet_other_kind() {
    meet_batches(cluster.first + LANES + BATCH * cluster.own, cluster.others);
}

fn meet_batches(first: u32, count: u32) {
    let lane = lane_of(place);
    let batches = largest_of_all(place, count);
    var at = first;
    for (var b = 0u; b < batches; b++) {
        let there = b < count;
        let batch = select(0u, at, there);
        let bytes = neighbour_list[batch + LANES + (lane >> 2u)];
        meets = select(0u, bytes >> (8u * (lane & 3u)), there);
        show(place, seen(batch, lane, there));
        meet_one(0u);
        meet_one(1u);
        meet_one(2u);
        meet_one(3u);
        meet_one(4u);
        meet_one(5u);
        meet_one(6u);
        meet_one(7u);
        at += BATCH;
    }
}

// Meets the one that another of the eight has read, if it is a neighbour: else it is far.
fn meet_one(other: u32) {
    var near = shown_by(other);
    near.at.x = select(FAR, near.at.x, (meets & (1u << other)) != 0u);
    meet(near);
}

// What this invocation reads of a batch.
fn seen(batch: u32, lane: u32, there: bool) -> Near {
    let entry = neighbour_list[batch + lane];
    let none = !there || entry == NOBODY;
    var near = see(select(entry & INDEX, member, none));
    let image = vec3u(entry >> IMAGE_BITS, entry >> (IMAGE_BITS + 2u), entry >> (IMAGE_BITS + 4u)) & vec3u(3u);
    near.at += box * (vec3f(image) - 1.0);
    return near;
}
