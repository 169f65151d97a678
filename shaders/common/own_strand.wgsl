// Points of a hair point's own strand, with which it exchanges no velocity.
import package::common::{params::{params, TWO_WAY}, cells::is_air, rod::Point};

@group(0) @binding(4) var<storage, read> points: array<Point>;

// Points of a strand.
struct Points { first: u32, end: u32 }

// The points that a particle exchanges no velocity with: with the model TWO_WAY those of its own strand.
fn points_with(i: u32) -> Points {
    if (params.model != TWO_WAY) | is_air(i) { return Points(0u, 0u); }
    return Points(points[i].first, points[i].end);
}

fn holds(points: Points, i: u32) -> bool {
    return i >= points.first && i < points.end;
}
