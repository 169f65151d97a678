// Strand of a hair point, for passes in which bodies push hair: found among the strands, which they read in any case.
import package::common::{params::params, rod::Strand};

@group(0) @binding(4) var<storage, read> strands: array<Strand>;

// The strand to which a point belongs: the last strand that starts at or before the point.
fn strand_of(point: u32) -> u32 {
    var low = 0u;
    var high = params.strands;
    while high - low > 1u {
        let middle = (low + high) / 2u;
        if strands[middle].first_point <= point { low = middle; } else { high = middle; }
    }
    return low;
}
