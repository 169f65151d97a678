// Where a position belongs, and how far apart two particles are.
//
// The box of air is cut into cells at least a kernel radius wide, numbered x first. Hair may be anywhere: cells
// outside the box are hashed into a table behind the box's own cells, and whoever looks there compares cells.
import package::common::params::params;

fn is_air(i: u32) -> bool {
    return i >= params.hair_points;
}

fn cell_of(position: vec3f) -> vec3i {
    return vec3i(floor(position / params.cell_size));
}

// Air is in the box by construction; rounding must not put it into the cell behind the last.
fn air_cell_of(position: vec3f) -> vec3i {
    return clamp(cell_of(position), vec3i(0), params.cells - vec3i(1));
}

fn in_box(cell: vec3i) -> bool {
    return all(cell >= vec3i(0)) && all(cell < params.cells);
}

// How many boxes away a cell outside the box is, per axis. In integers: a quotient of f32 may miss a whole number.
fn turns_of(cell: vec3i) -> vec3i {
    return select(cell / params.cells, (cell + vec3i(1)) / params.cells - vec3i(1), cell < vec3i(0));
}

fn box_bucket(cell: vec3i) -> u32 {
    return u32(cell.x + params.cells.x * (cell.y + params.cells.y * cell.z));
}

fn hashed_bucket(cell: vec3i) -> u32 {
    let mixed = (u32(cell.x) * 73856093u) ^ (u32(cell.y) * 19349663u) ^ (u32(cell.z) * 83492791u);
    return params.box_cells + (mixed & (params.hashed_cells - 1u));
}

fn bucket_of(i: u32, position: vec3f) -> u32 {
    if is_air(i) {
        return box_bucket(air_cell_of(wrap(position)));
    }
    let cell = cell_of(position);
    if in_box(cell) {
        return box_bucket(cell);
    }
    return hashed_bucket(cell);
}

fn buckets() -> u32 {
    return params.box_cells + params.hashed_cells;
}

fn wrap(position: vec3f) -> vec3f {
    let inside = position - params.box_size * floor(position / params.box_size);
    return select(inside, vec3f(0.0), inside >= params.box_size);
}
