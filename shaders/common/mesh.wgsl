// A grid over the periodic box, with nodes at multiples of the spacing, numbered x first, and the B-spline that carries what
// particles have to them and back: the band filter's grid, and the coarse one of the pressure.

struct Mesh {
    nodes: vec3i,            // number of nodes along each axis
    order: u32,              // order of the B-spline: 1 cloud in cell, 2 triangular-shaped cloud, 3 cubic
    spacing: vec3f,          // distance between nodes along each axis [m]
    gain: f32,               // factor of what is gathered: -e/2 s^2 over the volume of a cell [1/m]
    cell: f32,               // volume of a cell [m^3]
    normalise: u32,          // 1: what is gathered is divided by the smoothed volume fraction; 0: it is not
    axis: u32,               // axis that this dispatch transforms along: 0 is x, 1 is y, 2 is z
    nearest: i32,            // node that the first tap is for, counted from the first node that is made
    first_tap: u32,          // index of the first pair of taps in `taps`
    end_tap: u32, // end of the pairs of taps in `taps`
}

// A central B-spline, told by its order before any loop over particles or nodes.
struct Spline {
    half: f32,       // half of its support [spacings]
    powers: vec3f,   // factors of x, x^2, x^3: 1/p! of the order p, and zeros
}

fn spline_of(order: u32) -> Spline {
    let factors = vec3f(1.0, 0.5, 1.0 / 6.0);
    return Spline(0.5 * f32(order + 1u), select(vec3f(0.0), factors, vec3u(order) == vec3u(1u, 2u, 3u)));
}

// The B-spline at t spacings: ((n/2 - |t|)+^p - n (n/2 - 1 - |t|)+^p)/p!, n = p + 1 up to 4.
fn b_spline(spline: Spline, t: vec4f) -> vec4f {
    let outer = max(spline.half - abs(t), vec4f(0.0));
    let inner = max(outer - 1.0, vec4f(0.0));
    return power(spline, outer) - 2.0 * spline.half * power(spline, inner);
}

fn power(spline: Spline, x: vec4f) -> vec4f {
    return x * (spline.powers.x + x * (spline.powers.y + x * spline.powers.z));
}

fn node_index(node: vec3i, nodes: vec3i) -> u32 {
    return u32(node.x + nodes.x * (node.y + nodes.y * node.z));
}
