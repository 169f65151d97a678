// The grid of the band filter: nodes of the periodic box at multiples of the spacing, numbered x first, and the B-spline
// that carries what particles have to them and back.

struct Mesh {
    nodes: vec3i,            // number of nodes along each axis
    order: u32,              // order of the B-spline: 1 cloud in cell, 2 triangular-shaped cloud, 3 cubic
    spacing: vec3f,          // distance between nodes along each axis [m]
    gain: f32,               // factor of what is gathered: -e/2 s^2 over the volume of a cell [1/m]
    cell: f32,               // volume of a cell [m^3]
    normalise: u32,          // 1: what is gathered is divided by the smoothed volume fraction; 0: it is not
    axis: u32,               // axis that this dispatch smooths along: 0 is x, 1 is y, 2 is z
    nearest: i32,            // node that the first tap is for, counted from the first node that is made
    first_tap: u32,          // index of the first tap in `taps`
    end_tap: u32, // end of the taps in `taps`
}

// Half of the B-spline's support, in spacings.
fn half_width(order: u32) -> f32 {
    return 0.5 * f32(order + 1u);
}

// Central B-spline at t spacings: ((n/2 - |t|)+^p - n (n/2 - 1 - |t|)+^p)/p!, n = p + 1 up to 4.
fn b_spline(order: u32, t: vec4f) -> vec4f {
    let outer = max(vec4f(half_width(order)) - abs(t), vec4f(0.0));
    let inner = max(outer - 1.0, vec4f(0.0));
    let two = select(vec4f(1.0), vec4f(0.5), order >= 2u);
    let three = select(vec4f(1.0), vec4f(1.0 / 3.0), order >= 3u);
    return two * three * (power(order, outer) - f32(order + 1u) * power(order, inner));
}

fn power(order: u32, x: vec4f) -> vec4f {
    return x * select(vec4f(1.0), x, order >= 2u) * select(vec4f(1.0), x, order >= 3u);
}

// The node in the box of which `node` is a periodic image.
fn node_in_box(node: vec3i, nodes: vec3i) -> vec3i {
    return (node % nodes + nodes) % nodes;
}

fn node_index(node: vec3i, nodes: vec3i) -> u32 {
    return u32(node.x + nodes.x * (node.y + nodes.y * node.z));
}
