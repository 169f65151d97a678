// A grid over the periodic box, with nodes at multiples of the spacing, numbered x first, and the window that carries
// values of particles to them and back: the band filter's grid, and the coarse one of the pressure.

struct Mesh {
    nodes: vec3i,            // number of nodes along each axis
    window: u32,             // QUADRATIC of the coarse grid, MITCHELL of the band filter
    spacing: vec3f,          // distance between nodes along each axis [m]
    gain: f32,               // factor of the gathered sum: -e/2 s^2 over the volume of a cell [1/m]
    axis: u32,               // axis that this dispatch transforms along: 0 is x, 1 is y, 2 is z
    nearest: i32,            // node that the first tap is for, counted from the first node that is made
    first_tap: u32,          // index of the first pair of taps in `taps`
    end_tap: u32,            // end of the pairs of taps in `taps`
    // 1: this dispatch solves for the coarse pressure of the waves that it makes; 0: it does not
    solves: u32,
}

// B-splines; their supports are 2 and 3 spacings wide.
const LINEAR: u32 = 1u;
const QUADRATIC: u32 = 2u;
// The window of the band filter: the cubic of Mitchell & Netravali (1988) with B = 1.2 and C = -0.11, whose transform
// falls off faster beyond the waves that nodes know than that of the cubic B-spline, which is B = 1 and C = 0. Its
// support is 4 spacings wide.
const MITCHELL: u32 = 4u;

// A window of piecewise polynomials.
struct Window {
    half: f32,     // half of its support [spacings]
    outer: vec3f,  // factors of x, x^2, x^3, x the way to the end of the support
    inner: vec3f,  // the same of the way to one spacing before the end
}

fn window_of(kind: u32) -> Window {
    if kind == MITCHELL { return Window(2.0, vec3f(0.0, 0.11, 0.09), vec3f(0.0, -0.16, -0.4)); }
    if kind == QUADRATIC { return Window(1.5, vec3f(0.0, 0.5, 0.0), vec3f(0.0, -1.5, 0.0)); }
    return Window(1.0, vec3f(1.0, 0.0, 0.0), vec3f(-2.0, 0.0, 0.0));
}

// The window at t spacings.
fn weights(window: Window, t: vec4f) -> vec4f {
    let outer = max(window.half - abs(t), vec4f(0.0));
    let inner = max(outer - 1.0, vec4f(0.0));
    return cubic(window.outer, outer) + cubic(window.inner, inner);
}

fn cubic(factors: vec3f, x: vec4f) -> vec4f {
    return x * (factors.x + x * (factors.y + x * factors.z));
}

fn node_index(node: vec3i, nodes: vec3i) -> u32 {
    return u32(node.x + nodes.x * (node.y + nodes.y * node.z));
}
