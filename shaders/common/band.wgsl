// One band of eddies, and the part of the box that one dispatch of the filter covers.

struct Band {
    scale: f32,            // scale of the eddies: s of the Mexican hat [m]
    reach: f32,            // distance at which the filter is cut [m]
    gain: f32,             // factor of the filter's sum [1/m^3]; as published [mm^(-3/2) * mm/m]
    // S, a number; as published 1/2 epsilon m, so that the acceleration is strength |u|^2 (N x omega)
    strength: f32,
    largest_speed: f32,    // beyond which the band is not strengthened: I U, at most a kernel radius in a substep [m/s]
    first_block: u32,      // first block of cells that this dispatch covers
    end_block: u32,        // end of the blocks that this dispatch covers
    blocks_in_row: u32,    // number of blocks in a row of cells along x
    cells_in_block: i32,   // number of cells in a block, all in a row along x
    rows: i32,             // number of rows of cells, in y, that the filter reaches on either side of a block
    layers: i32,           // number of layers of cells, in z, that the filter reaches on either side of a block
    first_row: i32,        // first row that this dispatch looks at, of (2 rows + 1) (2 layers + 1), counted y first
    end_row: i32,          // end of the rows that this dispatch looks at
    comes_first: u32,      // 1 for the first band of a step, else 0
}
