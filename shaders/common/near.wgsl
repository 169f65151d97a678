// Who is near a particle: a stretch of the neighbour list. With the model TWO_WAY kinds stand apart: hair has the points of
// other strands first, then those of its own, then air; air has air first, then hair. With any other model all are of one kind.

struct Near {
    first: u32,    // entry of the list
    apart: u32,    // end of the own kind without the own strand
    middle: u32,   // end of the own kind
    end: u32,      // of the list's stretch
}
