// The quadratic B-spline of the coarse grid of the pressure, at t spacings from a node.
import package::common::mesh::{b_spline, spline_of};

fn quadratic(t: vec4f) -> vec4f {
    return b_spline(spline_of(2u), t);
}

// The slope of the quadratic B-spline: the difference of two B-splines of the order below.
fn slope(t: vec4f) -> vec4f {
    let linear = spline_of(1u);
    return b_spline(linear, t + 0.5) - b_spline(linear, t - 0.5);
}
