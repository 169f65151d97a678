// The mean wind of the step, from its table: linear between two entries, held before the first and after the last. One
// invocation.
import package::common::{params::params, status::{status, frozen}};

@group(0) @binding(2) var<storage, read> wind_table: array<vec4f>;   // xyz: U [m/s], w: time [s], rising

// The wind at a time: between two entries of the table if it is after the first of them, else what was found before.
fn later(found: vec3f, before: vec4f, after: vec4f, time: f32) -> vec3f {
    let part = min((time - before.w) / (after.w - before.w), 1.0);
    return select(found, mix(before.xyz, after.xyz, part), time > before.w);
}

@compute @workgroup_size(1)
fn main() {
    if frozen() { return; }
    let begin = f32(status.step) * params.step;
    let end = f32(status.step + 1u) * params.step;
    var entry = wind_table[0];
    var before = entry.xyz;
    var now = entry.xyz;
    var fastest = length(entry.xyz);
    for (var k = 1u; k < arrayLength(&wind_table); k++) {
        let after = wind_table[k];
        before = later(before, entry, after, begin);
        now = later(now, entry, after, end);
        fastest = max(fastest, length(after.xyz));
        entry = after;
    }
    status.fastest_wind = fastest;
    for (var axis = 0u; axis < 3u; axis++) {
        status.wind_before[axis] = before[axis];
        status.wind[axis] = now[axis];
    }
}
