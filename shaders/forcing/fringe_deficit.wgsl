// Deficit of the air in the fringe to the wind, of each particle and summed over those of each workgroup, in a fixed
// order; u' and sigma are those of `forcing/fringe`.
//
//   d_i = U + u' - v_i - (U(t + dt) - U(t));  sum_i sigma_i d_i,  and sum_i sigma_i
import package::common::{
    dispatch::WORKGROUP, terms::sum_terms, status::finite3, wind::{mean_wind, wind_before},
    inflow::{incoming_velocity, rate_at},
};

@group(0) @binding(2) var<storage, read> position: array<vec4f>;
@group(0) @binding(3) var<storage, read> velocity: array<vec4f>;
@group(0) @binding(6) var<storage, read_write> wind_change: array<vec4f>;   // m/s: d, for `forcing/fringe`

// xyz [m/s^2], w: [1/s].
fn term(i: u32) -> mat2x4f {
    let place = position[i].xyz;
    let rate = rate_at(place);
    if rate <= 0.0 { return mat2x4f(); }
    let change = mean_wind() - wind_before();
    let deficit = incoming_velocity(place) - velocity[i].xyz - change;
    wind_change[i] = vec4f(deficit, 0.0);
    // Air that is not finite ends the run; left out of the sum, it does not spread to all other air.
    if !finite3(deficit) { return mat2x4f(); }
    return mat2x4f(rate * vec4f(deficit, 1.0), vec4f(0.0));
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_id) lane: vec3u, @builtin(workgroup_id) group: vec3u,
) {
    sum_terms(id, groups, lane.x, group);
}
