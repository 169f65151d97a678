// Air moves by BDF2, which continues the change by pressure in the step before:
//
//   v = v_n + dv,  x* = wrap(x_n + dt (v + a/2)),  v* = v + a/3
//       dv the change by wind, a the change of v by pressure
//
// Forces other than pressure change v_n and v_(n-1) alike, so that a is their difference whatever acted since. The
// pressure's velocity change of this step starts from a/3.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, cells::wrap, pressure::Pressed, status::frozen,
};

@group(0) @binding(2) var<storage, read>       position:       array<vec4f>;   // xyz [m], w: volume [m^3]
@group(0) @binding(3) var<storage, read>       velocity:       array<vec4f>;   // m/s
@group(0) @binding(4) var<storage, read>       wind_change:    array<vec4f>;   // m/s
@group(0) @binding(5) var<storage, read>       pressed_before: array<Pressed>;
@group(0) @binding(6) var<storage, read_write> predicted:      array<vec4f>;
@group(0) @binding(7) var<storage, read_write> new_velocity:   array<vec4f>;
@group(0) @binding(8) var<storage, read_write> pressed:        array<Pressed>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = params.hair_points + invocation(id, groups);
    if (i >= params.particles) | frozen() { return; }
    let v = velocity[i].xyz + wind_change[i].xyz;
    let before = pressed_before[i];
    new_velocity[i] = vec4f(v + before.change / 3.0, 0.0);
    predicted[i] = vec4f(wrap(position[i].xyz + params.step * (v + 0.5 * before.change)), position[i].w);
    pressed[i] = Pressed(before.change / 3.0, before.pressure);
}
