// A particle and its neighbours: how far they are, and the kernels between them, of four pairs at once. Each step of a
// root and a division waits for the one before; those of four pairs wait together.
import package::common::{params::params, lanes::Near, sph_kernels::{poly6_factor, spiky_factor}};

// A neighbour as a pass meets it.
struct Pair {
    index: u32,      // j, of the neighbour
    gap: vec3f,      // m, x_i - x_j
    volume: f32,     // m^3, V_j
    slope: f32,      // 1/m^5, of Spiky: grad_i W is this times the gap
    kernel: f32,     // 1/m^3, W of Poly6
    coincide: bool,  // they lie on one another
    value: vec4f,    // values of the neighbour that the pass needs,
    more: vec4f,     // and more of that
}

// Four neighbours.
struct Four {
    a: Pair,
    b: Pair,
    c: Pair,
    d: Pair,
}

const NEAREST: f32 = 1e-12;   // h^2, square of the distance below which particles lie on one another

var<private> here: vec3f;        // m, position of the particle, where it meets the others
var<private> per_square: f32;    // 1/m^2, 1/h^2
var<private> steepest: f32;      // 1/m^4, slope of Spiky at r = 0: -45/(pi h^4)
var<private> steepest_per: f32;  // 1/m^5, that over h
var<private> height: f32;        // 1/m^3, Poly6 at r = 0: 315/(64 pi h^3)

// Sets the particle's position, and the kernel factors that all its pairs share.
fn set_origin(at: vec3f) {
    let h = params.kernel_radius;
    here = at;
    per_square = 1.0 / (h * h);
    steepest = -spiky_factor();
    steepest_per = steepest / h;
    height = poly6_factor();
}

fn meet_four(a: Near, b: Near, c: Near, d: Near) -> Four {
    let gaps = mat4x3f(here - a.at, here - b.at, here - c.at, here - d.at);
    let squares = per_square
        * vec4f(dot(gaps[0], gaps[0]), dot(gaps[1], gaps[1]), dot(gaps[2], gaps[2]), dot(gaps[3], gaps[3]));
    // Lengths are those over h. Particles that lie on one another have no direction: the slope is its limit at r = 0.
    let per_length = inverseSqrt(max(squares, vec4f(NEAREST)));
    let left = max(1.0 - squares * per_length, vec4f(0.0));
    let slopes = steepest_per * left * left * per_length;
    let left_of_square = max(1.0 - squares, vec4f(0.0));
    let kernels = height * left_of_square * left_of_square * left_of_square;
    let coincide = squares < vec4f(NEAREST);
    return Four(
        Pair(a.index, gaps[0], a.volume, slopes.x, kernels.x, coincide.x, a.value, a.more),
        Pair(b.index, gaps[1], b.volume, slopes.y, kernels.y, coincide.y, b.value, b.more),
        Pair(c.index, gaps[2], c.volume, slopes.z, kernels.z, coincide.z, c.value, c.more),
        Pair(d.index, gaps[3], d.volume, slopes.w, kernels.w, coincide.w, d.value, d.more),
    );
}

// V_j grad_i W of Spiky [1/m].
fn gradient_to(pair: Pair) -> vec3f {
    return (pair.volume * pair.slope) * pair.gap;
}

// grad_i W of Spiky [1/m^4], with a direction for particles that lie on one another, so that they separate.
fn gradient_apart(pair: Pair, i: u32) -> vec3f {
    return select(pair.slope * pair.gap, steepest * apart(i, pair.index), pair.coincide);
}

// A unit vector drawn from the indices of two particles, and its opposite for (j, i).
fn apart(i: u32, j: u32) -> vec3f {
    var word = (min(i, j) * 2654435769u) ^ (max(i, j) * 2246822519u);
    word = (word ^ (word >> 15u)) * 3266489917u;
    let drawn = vec3f(vec3u(word, word >> 10u, word >> 20u) & vec3u(1023u)) - 511.5;
    return select(-1.0, 1.0, i < j) * normalize(drawn);
}
