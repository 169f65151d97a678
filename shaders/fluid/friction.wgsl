// Friction of hair on hair, Coulomb's law over the pairs that the density constraint squeezes: equal and opposite impulses
// between points of different strands, across the line that joins them.
//
//   J_ij = -k_ij u_ij,   k_ij = min(p_ij/(P_i + P_j), mu p_ij/|u_ij|)   u: what of the difference of pulls is normal to x_i - x_j
//   g_i <- c_i (g_i + w_i sum_j k_ij s_ij)                              s: of the velocities of the last step, as u of pulls
//   c_i  = sum_j k_ij / sum_j p_ij/(P_i + P_j)                          1 where all pairs stick, towards 0 where they slide
//
// The first term of k is the largest that cannot overshoot, whatever the masses; the second is Coulomb's cap (Macklin et al.
// 2014, eq. 24), with the constraint's own impulse p for the depth. The grip g is the spring of Cundall & Strack (1979), kept
// by points instead of pairs: it holds what sticks where it is, and what slides lets go of it.
import package::common::{
    params::params, near::Near, dispatch::{invocation, WORKGROUP}, rub::{Rub, pressed}, status::frozen,
};

@group(0) @binding(2) var<storage, read>       predicted:       array<vec4f>;   // xyz [m], w: volume [m^3]
@group(0) @binding(3) var<storage, read>       neighbour_range: array<Near>;
@group(0) @binding(4) var<storage, read>       neighbour_list:  array<u32>;
@group(0) @binding(5) var<storage, read>       rubbing:         array<Rub>;
@group(0) @binding(6) var<storage, read>       squeezed:        array<f32>;     // P [m/s]
@group(0) @binding(7) var<storage, read_write> shift:           array<vec4f>;   // m, by friction
@group(0) @binding(8) var<storage, read_write> grip:            array<vec4f>;   // in: before this step [m/s]; out: after it

const SLOWEST: f32 = 1e-15;   // m/s: slower than this a pair sticks
const LEAST: f32 = 1e-30;     // kg, for points that nothing squeezes

// What of v is normal to `gap`.
fn across(v: vec3f, gap: vec3f) -> vec3f {
    return v - dot(v, gap) / dot(gap, gap) * gap;
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = invocation(id, groups);
    if frozen() { return; }
    if i >= params.hair_points {
        // `move` runs next in as many workgroups: what air is in the last of them has been moved already.
        if i < params.particles { shift[i] = vec4f(0.0); }
        return;
    }
    let own = rubbing[i];
    let x = predicted[i];
    let range = neighbour_range[i];
    var change = vec3f(0.0);   // kg m/s
    var slid = vec3f(0.0);     // kg m/s
    var held = 0.0;            // sum of k [kg]
    var most = 0.0;            // were all to stick [kg]
    for (var n = range.first; n < range.apart; n++) {
        let j = neighbour_list[n];
        let gap = x.xyz - predicted[j].xyz;
        let both = squeezed[i] + squeezed[j];
        if both == 0.0 || dot(gap, gap) == 0.0 { continue; }
        let other = rubbing[j];
        let squeeze = pressed(own, x.w, other, predicted[j].w, length(gap));
        let pull = across(own.pull - other.pull, gap);
        let speed = max(length(pull), SLOWEST);
        let sticks = squeeze / both;
        let share = min(sticks, min(own.friction, other.friction) * squeeze / speed);
        change -= share * pull;
        slid += share * across(own.moved - other.moved, gap);
        held += share;
        most += sticks;
    }
    shift[i] = vec4f(params.step * own.inverse_mass * change, 0.0);
    let kept = grip[i].xyz + own.inverse_mass * slid;
    grip[i] = vec4f(held / max(most, LEAST) * kept, 0.0);
}
