// Who is near a particle: a stretch of the neighbour list, own kind first (hair for hair, air for air). With the model
// PARTICLES all are one kind.

struct Near {
    first: u32,    // entry of the list
    middle: u32,   // end of the own kind
    end: u32,      // of the list's stretch
}
