// Friction of hair on hair, Coulomb's law over the pairs that the density constraint squeezes: equal and opposite
// impulses between points of different strands, across the line that joins them.
//
//   J_ij = -k_ij u_ij,   k_ij = min(p_ij/(P_i + P_j), mu p_ij/|u_ij|)
//       u: component of the difference of pulls that is normal to x_i - x_j
//   g_i <- c_i (g_i + w_i sum_j k_ij s_ij)
//       s: of the velocities of the last step, as u of pulls
//   c_i  = sum_j k_ij / sum_j p_ij/(P_i + P_j)
//       1 where all pairs stick, towards 0 where they slide
//
// The first term of k is the largest that cannot overshoot, whatever the masses; the second is Coulomb's cap (Macklin
// et al. 2014, eq. 24), with the constraint's own impulse p for the depth. The tangential spring g is that of Cundall &
// Strack (1979), kept by points instead of pairs: it holds a sticking point in place, and fades as the point slides.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, status::frozen, lanes::Near, pairs::Pair,
    friction_point::{FrictionPoint, pressed},
    clusters::{take_particle, has_no_hair, of_shared, added_up, meet_own_kind},
    own_strand::{Points, points_with, holds},
    page::of_page,
};

@group(0) @binding(2) var<storage, read>       predicted: array<vec4f>;   // xyz [m], w: volume [m^3]
@group(0) @binding(3) var<storage, read>       friction_points:   array<FrictionPoint>;
@group(0) @binding(5) var<storage, read>       normal_impulses:  array<f32>;   // P [m/s]
@group(0) @binding(6) var<storage, read_write> shift:     array<vec4f>;        // m, by friction
// g [m/s]: read as the step before left it, written for the next
@group(0) @binding(7) var<storage, read_write> tangential_spring: array<vec4f>;

const SLOWEST: f32 = 1e-15;   // m/s, floor of the divisor |u|
const LEAST: f32 = 1e-30;     // kg, for points without a squeezed pair

var<private> own_strand: Points;
var<private> x: vec4f;
var<private> own: FrictionPoint;
var<private> own_squeezed: f32;
var<private> change: vec3f;   // kg m/s
var<private> slid: vec3f;     // kg m/s
var<private> held: f32;       // sum of k [kg]
var<private> most: f32;       // were all to stick [kg]

// The part of v that is normal to `gap`.
fn across(v: vec3f, gap: vec3f) -> vec3f {
    return v - dot(v, gap) / dot(gap, gap) * gap;
}

fn load_neighbour(j: u32) -> Near {
    let other = predicted[j];
    let rub = friction_points[j];
    return Near(j, other.xyz, other.w, vec4f(rub.pull, rub.multiplier),
        vec4f(normal_impulses[j], rub.friction, 0.0, 0.0));
}

fn accumulate(other: Pair) {
    let gap = other.gap;
    let both = own_squeezed + other.more.x;
    if both == 0.0 || dot(gap, gap) == 0.0 || holds(own_strand, other.index) { return; }
    let squeeze = pressed(own.multiplier, x.w, other.value.w, other.volume, length(gap));
    let pull = across(own.pull - other.value.xyz, gap);
    let speed = max(length(pull), SLOWEST);
    let sticks = squeeze / both;
    let share = min(sticks, min(own.friction, other.more.y) * squeeze / speed);
    change -= share * pull;
    slid += share * across(own.moved - friction_points[other.index].moved, gap);
    held += share;
    most += sticks;
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let place = of_shared(id, groups);
    let entry = of_page(place);
    // `fluid/move` runs next over hair in whole workgroups: air in the last of them has been moved already.
    if (entry >= params.hair_points) & (entry < params.particles) & !frozen() { shift[entry] = vec4f(0.0); }
    let i = take_particle(place, local);
    own_strand = points_with(i);
    x = predicted[i];
    own = friction_points[i];
    own_squeezed = normal_impulses[i];
    meet_own_kind(x.xyz);
    let changes = added_up(vec4f(change, held));
    let slides = added_up(vec4f(slid, most));
    if has_no_hair(i) { return; }
    shift[i] = vec4f(params.step * own.inverse_mass * changes.xyz, 0.0);
    let kept = tangential_spring[i].xyz + own.inverse_mass * slides.xyz;
    tangential_spring[i] = vec4f(changes.w / max(slides.w, LEAST) * kept, 0.0);
}
