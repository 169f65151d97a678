// Invocations that work for a strand, a row of cells, or a block of nodes.
//
// One invocation that walks along a strand waits for memory at each point, and a GPU has thousands more than there are
// strands: eight side by side share the work, each with a range of the points (`Range`). A software adapter gains
// nothing by that, and without subgroup operations invocations cannot ask one another: in the texts for these each has
// a strand alone.
//
// One of the invocations that share writes for all after it has exchanged a value with the others: by then they have
// made their reads.
import package::common::lanes::LANES;

// Invocations that share the work. The engine dispatches so many for each strand, row or block.
@if(subgroups && !software) const SHARE: u32 = LANES;
@if(!subgroups || software) const SHARE: u32 = 1u;

// The strand, row or block that an invocation shares.
fn item_of(invocation: u32) -> u32 {
    return invocation / SHARE;
}

// Place of an invocation among those that share.
fn lane_of_item(invocation: u32) -> u32 {
    return invocation % SHARE;
}

// A worker's range of so many points.
struct Range {
    before: u32,   // the point before it, or the first point: the start for passes that look at segments
    begin: u32,
    end: u32,
}

fn range_of(points: u32, worker: u32) -> Range {
    let length = (points + SHARE - 1u) / SHARE;
    let begin = min(worker * length, points);
    return Range(max(begin, 1u) - 1u, begin, min(begin + length, points));
}

// Over the invocations that share: the largest value; the least; whether any is true.
@if(subgroups && !software)
fn largest_shared(own: f32) -> f32 {
    var largest = own;
    largest = max(largest, subgroupShuffleXor(largest, 1u));
    largest = max(largest, subgroupShuffleXor(largest, 2u));
    return max(largest, subgroupShuffleXor(largest, 4u));
}
@if(!subgroups || software)
fn largest_shared(own: f32) -> f32 {
    return own;
}

@if(subgroups && !software)
fn least_shared(own: u32) -> u32 {
    var least = own;
    least = min(least, subgroupShuffleXor(least, 1u));
    least = min(least, subgroupShuffleXor(least, 2u));
    return min(least, subgroupShuffleXor(least, 4u));
}
@if(!subgroups || software)
fn least_shared(own: u32) -> u32 {
    return own;
}

@if(subgroups && !software)
fn any_shared(own: bool) -> bool {
    return least_shared(u32(!own)) == 0u;
}
@if(!subgroups || software)
fn any_shared(own: bool) -> bool {
    return own;
}

// Counts of those that share, added up: of the workers before this one, and of all.
struct Added { before: u32, all: u32 }

@if(subgroups && !software)
fn added(own: u32, worker: u32) -> Added {
    var sums = Added(0u, own);
    for (var reach = 1u; reach < SHARE; reach *= 2u) {
        let beside = subgroupShuffleXor(sums.all, reach);
        sums.before += select(0u, beside, (worker & reach) != 0u);
        sums.all += beside;
    }
    return sums;
}
@if(!subgroups || software)
fn added(own: u32, worker: u32) -> Added {
    return Added(0u, own);
}
