// The wind enters: all air gets the change of the mean wind and the deficit L of the air in the fringe; and air in the
// fringe, the layer behind the faces of entry, relaxes to the incoming velocity U + u', so that air that left
// downstream enters again with it.
//
//   dv = U(t + dt) - U(t) + L;  then  v += (1 - exp(-sigma dt)) (U + u' - v)
//   L = n (n . sum_i sigma_i (U + u' - v_i - dU))/sum_i sigma_i,  n = U/|U|,  dU = U(t + dt) - U(t)
//       over all air, by the term of `forcing/fringe_deficit`
//   sigma = sum over faces of cos * 10 max(|U|, 0.3 m/s)/l sin^2(pi x/l)  within the thickness l
//   u' = |U| sum_m a_m sin(k_m . (x - way) + phi_m), carried along with the wind:
//       frozen turbulence (Taylor 1938), solenoidal
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, status::frozen, wind::{mean_wind, wind_before},
    inflow::rate_at,
};

@group(0) @binding(2) var<storage, read>       position:    array<vec4f>;
// sums over air of the term of `forcing/fringe_deficit` [m/s^2]; w: of sigma [1/s]
@group(0) @binding(5) var<storage, read>       fringe_deficit:      array<vec4f>;
// m/s: in the fringe the deficit U + u' - v - dU of `forcing/fringe_deficit`, then the change of this step
@group(0) @binding(6) var<storage, read_write> wind_change: array<vec4f>;

// L: deficit of the air in the fringe to the wind, along the wind. Given to all air, it keeps up the flow through the
// box.
fn wind_deficit() -> vec3f {
    let wind = mean_wind();
    // The sum of sigma is 0 without wind, or without a particle in the fringe.
    let along = dot(fringe_deficit[0].xyz, wind) / max(dot(wind, wind) * fringe_deficit[0].w, 1e-30);
    return select(vec3f(0.0), along * wind, fringe_deficit[0].w > 0.0);
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = params.hair_points + invocation(id, groups);
    if (i >= params.particles) | frozen() { return; }
    let given = wind_deficit();
    let part = 1.0 - exp(-rate_at(position[i].xyz) * params.step);
    var drawn = vec3f(0.0);
    if part > 0.0 { drawn = part * (wind_change[i].xyz - given); }
    wind_change[i] = vec4f(mean_wind() - wind_before() + given + drawn, 0.0);
}
