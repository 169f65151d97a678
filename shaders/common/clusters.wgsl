// The loop over neighbours, which all passes share.
//
// A cluster is up to eight particles of one kind that are next to one another in the order of cells. Its list has the
// particles nearer than the kernel radius to any of them. Its eight invocations, one per particle, read a batch of
// eight entries at once, one each; then each invocation visits all eight. A pass reads a neighbour in `load_neighbour`,
// and adds a pair's part to its sums in `accumulate`. A pair that was not nearer than the kernel radius when the list
// was made is left out, wherever the particles are by now.
import package::common::{params::{params, TWO_WAY}, cells::is_air, dispatch::{invocation, WORKGROUP}};
import package::common::lanes::{Near, LANES, lane_of, publish, from_lane, largest_of_all};
import package::common::list::{BATCHES, NOBODY, INDEX, NONE, IMAGE_BITS, FRAME_BITS, FAR, elements_of, heads};
import package::common::pairs::{Pair, set_origin, meet_four};
import package::pass::{load_neighbour, accumulate};

@group(0) @binding(20) var<storage, read> neighbour_list: array<vec4u>;

struct Cluster {
    first: u32,    // element at which its groups begin
    own: u32,      // batches of its own kind
    others: u32,   // batches of the other kind
}

var<private> cluster: Cluster;
var<private> place: u32;    // of the invocation in its workgroup
var<private> box: vec3f;    // m, sides of the box of air
var<private> frame: vec3f;  // m, box shift: by how much the cluster is moved towards 0 to visit neighbours
var<private> meets: u32;    // bit by bit, which entries of the published batch are neighbours of the particle
var<private> nobody: bool;  // the invocation only reads for the others: it has no particle, or shares another's
// a particle of the cluster, which is read in place of an unused entry, since its values are of the cluster's kind
var<private> member: u32;

// Clusters of hair are few and have long lists, and their passes are bound by memory latency: in a pass that calls
// `of_shared` four times eight invocations share a cluster, and each eight read every fourth group of its list.
@if(subgroups && !software) const SHARE: u32 = 4u;

// First group of the list that an invocation reads, and the distance to its next one.
@if(subgroups && !software) var<private> first_group: u32;
@if(subgroups && !software) var<private> group_stride: u32 = 1u;
@if(!subgroups || software) const first_group: u32 = 0u;
@if(!subgroups || software) const group_stride: u32 = 1u;

@if(subgroups && !software) var<workgroup> all_sums: array<vec4f, WORKGROUP>;

// Particle at this place in the page; selects its cluster for the functions that visit neighbours. Where has_none()
// holds, the index is another invocation's: do not write to it.
fn take_particle(place_in_page: u32, local: u32) -> u32 {
    place = local;
    box = params.box_size;
    let inside = place_in_page < heads();
    let head = select(vec4u(0u), neighbour_list[select(0u, place_in_page, inside)], inside);
    let moved = vec3u(head.z >> FRAME_BITS, head.z >> (FRAME_BITS + 1u), head.z >> (FRAME_BITS + 2u)) & vec3u(1u);
    frame = box * vec3f(moved);
    cluster = Cluster(head.y, head.z & ((1u << FRAME_BITS) - 1u), head.w);
    member = head.x & INDEX;
    nobody = (head.y == 0u) | ((head.x & NONE) != 0u) | (first_group > 0u);
    return member;
}

fn has_none() -> bool {
    return nobody;
}

// has_none() in a pass over hair alone: where its workgroups fold into rows, the last ones are beyond hair and have
// air.
fn has_no_hair(particle: u32) -> bool {
    return nobody || is_air(particle);
}

// The place of an invocation in its page of the list, in a pass over all clusters of the page or over those of air.
// Clusters of hair come first.
fn of_all(id: vec3u, groups: vec3u) -> u32 {
    return invocation(id, groups);
}

fn of_air(id: vec3u, groups: vec3u) -> u32 {
    return params.page_of_hair + invocation(id, groups);
}

// The place in a pass over all clusters or over those of hair, in which several invocations share a particle: only the
// first of them writes it.
@if(subgroups && !software)
fn of_shared(id: vec3u, groups: vec3u) -> u32 {
    let n = invocation(id, groups);
    first_group = n / LANES % SHARE;
    group_stride = SHARE;
    return n / (LANES * SHARE) * LANES + lane_of(n);
}

@if(!subgroups || software)
fn of_shared(id: vec3u, groups: vec3u) -> u32 {
    return of_all(id, groups);
}

// Sum over the invocations that share a particle. Every invocation of the workgroup calls it, from the same place.
@if(subgroups && !software)
fn added_up(own: vec4f) -> vec4f {
    workgroupBarrier();
    all_sums[place] = own;
    workgroupBarrier();
    let first = place - LANES * first_group;
    var sum = vec4f(0.0);
    for (var k = 0u; k < SHARE; k++) { sum += all_sums[first + LANES * k]; }
    return sum;
}
@if(!subgroups || software)
fn added_up(own: vec4f) -> vec4f {
    return own;
}

// The place in a pass over the particles that pressure acts on: with the model TWO_WAY air alone.
fn of_flow(id: vec3u, groups: vec3u) -> u32 {
    return select(of_all(id, groups), of_air(id, groups), params.model == TWO_WAY);
}

// Visits the neighbours of the own kind, or all unless the model is TWO_WAY, of the particle at `at`.
fn meet_own_kind(at: vec3f) {
    set_origin(at - frame);
    meet_batches(cluster.first, cluster.own);
}

// Visits the neighbours of the other kind, if the model is TWO_WAY, of the particle at `at`.
fn meet_other_kind(at: vec3f) {
    set_origin(at - frame);
    meet_batches(cluster.first + elements_of(cluster.own), cluster.others);
}

// Visits the neighbours of the own kind, then those of the other kind, of the particle at `at`.
fn meet_both_kinds(at: vec3f) {
    set_origin(at - frame);
    for (var part = 0u; part < 2u; part++) {
        let second = part == 1u;
        meet_batches(cluster.first + select(0u, elements_of(cluster.own), second),
            select(cluster.own, cluster.others, second));
    }
}

// All lanes of a subgroup or workgroup loop as often as the longest list needs, since lanes exchange data in every
// iteration.
fn meet_batches(first: u32, count: u32) {
    let lane = lane_of(place);
    let batches = largest_of_all(place, count);
    var at = first + LANES * first_group;
    for (var turn = 0u; turn < batches; turn += BATCHES * group_stride) {
        let b = turn + BATCHES * first_group;
        var element = neighbour_list[select(0u, at, b < count) + lane];
        let end = min(BATCHES, batches - turn);
        for (var k = 0u; k < end; k++) {
            let there = b + k < count;
            meets = select(0u, element.w, there);
            publish(place, seen(element.x, there));
            let first = meet_four(shown_to(0u), shown_to(1u), shown_to(2u), shown_to(3u));
            let second = meet_four(shown_to(4u), shown_to(5u), shown_to(6u), shown_to(7u));
            accumulate(first.a);
            accumulate(first.b);
            accumulate(first.c);
            accumulate(first.d);
            accumulate(second.a);
            accumulate(second.b);
            accumulate(second.c);
            accumulate(second.d);
            element = vec4u(element.yzz, element.w >> 8u);
        }
        at += LANES * group_stride;
    }
}

// Neighbour read by lane `other`; moved to FAR (kernel 0) if it is no neighbour of this particle.
fn shown_to(other: u32) -> Near {
    var near = from_lane(other);
    near.at.x = select(FAR, near.at.x, (meets & (1u << other)) != 0u);
    return near;
}

// The neighbour that this invocation reads for its cluster, by its entry of a batch.
fn seen(entry: u32, there: bool) -> Near {
    let none = !there || entry == NOBODY;
    var near = load_neighbour(select(entry & INDEX, member, none));
    let image = vec3u(entry >> IMAGE_BITS, entry >> (IMAGE_BITS + 2u), entry >> (IMAGE_BITS + 4u)) & vec3u(3u);
    near.at += box * (vec3f(image) - 1.0);
    return near;
}
