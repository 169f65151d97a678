// The mean wind of the step, from its table: linear between two entries, held before the first and after the last. One
// invocation.
import package::common::{params::params, status::{status, frozen}};

@group(0) @binding(2) var<storage, read> wind_table: array<vec4f>;   // xyz: U [m/s], w: time [s], rising

fn at(time: f32) -> vec3f {
    var wind = wind_table[0].xyz;
    for (var k = 1u; k < arrayLength(&wind_table); k++) {
        let before = wind_table[k - 1u];
        let after = wind_table[k];
        if time <= before.w { break; }
        wind = mix(before.xyz, after.xyz, min((time - before.w) / (after.w - before.w), 1.0));
    }
    return wind;
}

fn fastest() -> f32 {
    var speed = 0.0;
    for (var k = 0u; k < arrayLength(&wind_table); k++) { speed = max(speed, length(wind_table[k].xyz)); }
    return speed;
}

@compute @workgroup_size(1)
fn main() {
    if frozen() { return; }
    status.fastest_wind = fastest();
    let before = at(f32(status.step) * params.step);
    let now = at(f32(status.step + 1u) * params.step);
    for (var axis = 0u; axis < 3u; axis++) {
        status.wind_before[axis] = before[axis];
        status.wind[axis] = now[axis];
    }
}
