// Finds the first entry of each cell, the exclusive sum of the counts, in one workgroup; empties the counts for
// `scatter`.
//
// Each invocation sums a stretch of cells, the workgroup scans the 256 sums, and each invocation writes its stretch.
import package::common::cells::buckets;

const LANES: u32 = 256u;   // invocations of the one workgroup: the most that WebGPU's default allows

@group(0) @binding(2) var<storage, read_write> cell_count: array<u32>;
@group(0) @binding(3) var<storage, read_write> cell_start: array<u32>;   // first entry of each cell, and the end of the last

var<workgroup> sums: array<u32, LANES>;

@compute @workgroup_size(LANES)
fn main(@builtin(local_invocation_id) id: vec3u) {
    let lane = id.x;
    let stretch = (buckets() + LANES - 1u) / LANES;
    let begin = min(lane * stretch, buckets());
    let end = min(begin + stretch, buckets());

    var own = 0u;
    for (var b = begin; b < end; b++) {
        own += cell_count[b];
    }
    sums[lane] = own;
    workgroupBarrier();
    for (var reach = 1u; reach < LANES; reach *= 2u) {
        var before = 0u;
        if lane >= reach {
            before = sums[lane - reach];
        }
        workgroupBarrier();
        sums[lane] += before;
        workgroupBarrier();
    }

    var running = sums[lane] - own;
    for (var b = begin; b < end; b++) {
        cell_start[b] = running;
        running += cell_count[b];
        cell_count[b] = 0u;
    }
    if lane == LANES - 1u {
        cell_start[buckets()] = sums[lane];
    }
}
