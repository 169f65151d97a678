// The wind enters: the mean wind's change is given to all air alike, and near the faces through which the wind enters
// the air is drawn toward it, so that what left downstream comes in again undisturbed.
//
//   dv = U(t + dt) - U(t);  then  v += (1 - exp(-sigma dt)) (U - v)
//   sigma = sum over faces of cos * 10 max(|U|, 0.3 m/s)/l sin^2(pi x/l)  within the thickness l
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, sph_kernels::PI, status::{status, frozen},
    wind::{mean_wind, depth_of},
};

const SLOWEST: f32 = 0.3;   // m/s: the fringe keeps some grip while the wind rises
const GRIP: f32 = 10.0;     // of the fringe, per passage

@group(0) @binding(2) var<storage, read>       position:    array<vec4f>;
@group(0) @binding(3) var<storage, read>       velocity:    array<vec4f>;
@group(0) @binding(4) var<storage, read_write> wind_change: array<vec4f>;   // m/s, of this step

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = params.hair_points + invocation(id, groups);
    if i >= params.particles || frozen() { return; }
    let wind = mean_wind(status.step + 1u);
    let change = wind - mean_wind(status.step);
    let speed = length(wind);

    var rate = 0.0;
    if params.fringe > 0.0 {
        let depth = depth_of(position[i].xyz);
        let bump = sin(PI * depth / params.fringe);
        let within = select(vec3f(0.0), bump * bump, depth < vec3f(params.fringe));
        rate = dot(abs(wind) / speed, within) * GRIP * max(speed, SLOWEST) / params.fringe;
    }

    let v = velocity[i].xyz + change;
    wind_change[i] = vec4f(change + (1.0 - exp(-rate * params.step)) * (wind - v), 0.0);
}
