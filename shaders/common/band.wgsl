// One band of eddies, and the stretch of the box that one dispatch of the filter covers.

struct Band {
    scale: f32,            // m, s of the Mexican hat
    reach: f32,            // m, the filter's cut
    gain: f32,             // before the filter's sum: 1/m^3, published mm^(-3/2) * mm/m
    strength: f32,         // S; published: 1/2 epsilon m, so that the acceleration is strength |u|^2 (N x omega)
    largest_speed: f32,    // m/s, I U: the band is not strengthened beyond
    first_block: u32,      // of this dispatch
    end_block: u32,
    blocks_in_row: u32,
    cells_in_block: i32,
    rows: i32,             // of cells on either side of a block that the filter reaches, in y
    layers: i32,           // the same in z
    first_row: i32,        // of this dispatch: (2 rows + 1) (2 layers + 1) there are, y first
    end_row: i32,
    @size(204) comes_first: u32,    // of the bands of a step; uniforms are bound at multiples of 256 bytes
}
