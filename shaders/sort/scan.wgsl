// Exclusive sums, over the rows of cells, of their entries and their clusters, in one workgroup.
//
// Each invocation sums a range of rows, the workgroup scans the 256 sums, and each invocation writes its range.
import package::common::{cells::rows, row::Row};

const LANES: u32 = 256u;   // invocations of the one workgroup: the most that WebGPU's default allows

// exclusive sums per row of cells; one extra element at the end has the totals
@group(0) @binding(2) var<storage, read_write> cell_rows: array<Row>;

var<workgroup> sums: array<vec2u, LANES>;

@compute @workgroup_size(LANES)
fn main(@builtin(local_invocation_id) id: vec3u) {
    let lane = id.x;
    let stretch = (rows() + LANES - 1u) / LANES;
    let begin = min(lane * stretch, rows());
    let end = min(begin + stretch, rows());

    var own = vec2u(0u);
    for (var r = begin; r < end; r++) {
        own += vec2u(cell_rows[r].entries, cell_rows[r].clusters);
    }
    sums[lane] = own;
    workgroupBarrier();
    for (var reach = 1u; reach < LANES; reach *= 2u) {
        var before = vec2u(0u);
        if lane >= reach {
            before = sums[lane - reach];
        }
        workgroupBarrier();
        sums[lane] += before;
        workgroupBarrier();
    }

    var running = sums[lane] - own;
    for (var r = begin; r < end; r++) {
        let row = cell_rows[r];
        cell_rows[r] = Row(running.x, running.y);
        running += vec2u(row.entries, row.clusters);
    }
    if lane == LANES - 1u {
        cell_rows[rows()] = Row(sums[lane].x, sums[lane].y);
    }
}
