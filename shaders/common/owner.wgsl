// Whose a hair point is.
import package::common::{params::{params, TWO_WAY}, cells::is_air, rod::Strand};

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

// Points of a strand.
struct Points { first: u32, end: u32 }

// The points that a particle exchanges no velocity with: with the model TWO_WAY those of its own strand.
fn points_with(i: u32) -> Points {
    if (params.model != TWO_WAY) | is_air(i) { return Points(0u, 0u); }
    let strand = strands[strand_of(i)];
    return Points(strand.first_point, strand.first_point + strand.points);
}

fn holds(points: Points, i: u32) -> bool {
    return i >= points.first && i < points.end;
}
