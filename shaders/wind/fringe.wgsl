// The wind enters: the mean wind's change is given to all air alike, and near the faces through which the wind enters
// the air is drawn toward what the wind brings, so that what left downstream comes in again conditioned.
//
//   dv = U(t + dt) - U(t);  then  v += (1 - exp(-sigma dt)) (U + u' - v)
//   sigma = sum over faces of cos * 30 max(|U|, 0.3 m/s)/l sin^2(pi x/l)  within the thickness l
//   u' = |U| sum_m a_m sin(k_m . (x - way) + phi_m), carried along with the wind: frozen turbulence (Taylor 1938), solenoidal
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, pi::PI, status::frozen,
    wind::{mean_wind, wind_before, way_of_wind, depth_of},
};

const SLOWEST: f32 = 0.3;   // m/s: the fringe keeps some grip while the wind rises
const GRIP: f32 = 30.0;     // of the fringe, per passage

struct Wave {
    number: vec4f,      // xyz: k [1/m], whole periods to the box; w: phase
    amplitude: vec4f,   // a, of the wind's speed
}

@group(0) @binding(2) var<storage, read>       position:    array<vec4f>;
@group(0) @binding(3) var<storage, read>       velocity:    array<vec4f>;
@group(0) @binding(4) var<storage, read>       inflow:      array<Wave>;    // one of no amplitude without inflow turbulence
@group(0) @binding(5) var<storage, read_write> wind_change: array<vec4f>;   // m/s, of this step

fn brought(position: vec3f) -> vec3f {
    let place = position - way_of_wind();
    var eddies = vec3f(0.0);
    for (var m = 0u; m < arrayLength(&inflow); m++) {
        let wave = inflow[m];
        eddies += wave.amplitude.xyz * sin(dot(wave.number.xyz, place) + wave.number.w);
    }
    return eddies;
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = params.hair_points + invocation(id, groups);
    if i >= params.particles || frozen() { return; }
    let wind = mean_wind();
    let change = wind - wind_before();
    let speed = length(wind);
    let place = position[i].xyz;

    var rate = 0.0;
    if params.fringe > 0.0 && speed > 0.0 {
        let depth = depth_of(place, wind);
        let bump = sin(PI * depth / params.fringe);
        let within = select(vec3f(0.0), bump * bump, depth < vec3f(params.fringe));
        rate = dot(abs(wind) / speed, within) * GRIP * max(speed, SLOWEST) / params.fringe;
    }
    var drawn = vec3f(0.0);
    if rate > 0.0 {
        let v = velocity[i].xyz + change;
        drawn = (1.0 - exp(-rate * params.step)) * (wind + speed * brought(place) - v);
    }
    wind_change[i] = vec4f(change + drawn, 0.0);
}
