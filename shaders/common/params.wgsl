// Parameters, which stay the same from step to step. Lengths are in local coordinates: world minus the scene's origin.

struct Params {
    box_size: vec3f,              // m, periodic box of air, [0, box_size)
    step: f32,                    // s, of one engine step (substeps already divided out)
    gravity: vec3f,               // m/s^2, on hair only
    fringe: f32,                  // m, thickness
    cells: vec3i,                 // of the box; 0 without air
    kernel_radius: f32,           // m
    cell_size: vec3f,             // m; of the neighbour search at least a kernel radius, and a quarter of it along x
    air_volume: f32,              // m^3
    spacing: f32,                 // m, of air particles: the cube root of their volume
    particles: u32,               // hair points first, then air
    hair_points: u32,
    segments: u32,
    strands: u32,
    box_cells: u32,               // product of cells
    first_sorted: u32,            // particle from which on all are sorted into cells: 0, or air's first
    clusters: u32,                // most clusters of the neighbour list; 0 where it is not made from these cells
    hair_clusters: u32,           // of them hair's, which come first
    pages: u32,                   // of the neighbour list (`list.wgsl`)
    page: u32,                    // the one that a pass over clusters is for
    page_clusters: u32,           // clusters that a page has room for
    page_of_hair: u32,            // invocations of the page that are hair's, which come first
    neighbour_capacity: u32,      // elements of a page
    newton_steps: u32,            // of the rods' direct solver, at most
    newton_part: u32,             // of them, in one dispatch
    rod_sweeps: u32,              // of one dispatch of Gauss-Seidel
    air_inverse_mass: f32,        // 1/kg
    constrained: u32,             // particles that the density constraint moves, from the first on: hair, or all
    relaxation: f32,
    density_softening: f32,       // alpha of the multiplier, 1/(kg m^2)
    viscosity_hair: f32,          // c of eq. 7, for one engine step
    viscosity_air: f32,
    viscosity_eddies: f32,      // c over the deformation |G| dt
    spreading: f32,             // f of `fluid/spread`
    settling: f32,              // part of its unevenness that still air takes out in a step
    damping: f32,               // 1/s
    failed_strand_limit: u32,   // more than this in one step end the run
    air_density: f32,           // kg/m^3
    kinematic_viscosity: f32,   // m^2/s, of the drag on segments
    lift: f32,                  // C_l
    skin_friction: f32,         // C_f, of air along bodies
    published_law: u32,         // confinement as printed, else the band law
    direct_rods: u32,           // rods by the direct solver, else by Gauss-Seidel
    bdf2: u32,                  // rods by BDF2, else by implicit Euler
    sleep: u32,                 // strands at rest are left alone
    substeps: u32,              // engine steps of a time step
    conserve_momentum: u32,     // take the mean change by confinement out
    sampled: u32,               // drag finds the air at each hair point in `sampled`, else it is the mean wind
    model: u32,                 // of hair and air: PARTICLES, TWO_WAY, DRAG, NONE
}

// How hair and air meet: in one fluid of particles, by exchanging drag, in the mean wind without air, or not at all.
const PARTICLES: u32 = 0u;
const TWO_WAY: u32 = 1u;
const DRAG: u32 = 2u;
const NONE: u32 = 3u;

@group(0) @binding(0) var<uniform> params: Params;
