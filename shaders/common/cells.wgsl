// Cells of positions.
//
// The box of air is cut into cells, numbered x first. Air is sorted into them, and hair into as many cells of its own
// behind them. The box repeats: hair outside it is in the cell that it would be in by whole boxes, and a search
// there compares distances.
import package::common::params::params;

fn is_air(i: u32) -> bool {
    return i >= params.hair_points;
}

fn cell_of(position: vec3f) -> vec3i {
    return vec3i(floor(position / params.cell_size));
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

// The cell of the box that a position is in by whole boxes. Rounding must not put it into the cell behind the last.
fn home_of(position: vec3f) -> vec3i {
    return clamp(cell_of(wrap(position)), vec3i(0), params.cells - vec3i(1));
}

fn bucket_of(i: u32, position: vec3f) -> u32 {
    return box_bucket(home_of(position)) + select(params.box_cells, 0u, is_air(i));
}

// Kinds that are sorted: air, and hair.
fn kinds() -> u32 {
    return select(1u, 2u, params.first_sorted < params.hair_points);
}

// Rows of cells along x: air's, then hair's.
fn rows() -> u32 {
    return kinds() * u32(params.cells.y * params.cells.z);
}

fn buckets() -> u32 {
    return kinds() * params.box_cells;
}

fn wrap(position: vec3f) -> vec3f {
    let inside = position - params.box_size * floor(position / params.box_size);
    // A quotient that is rounded up to a whole number leaves less than 0; one that is rounded up to the box is its
    // lower face.
    return select(inside, vec3f(0.0), (inside >= params.box_size) | (inside < vec3f(0.0)));
}
