// The mean wind of the step, from its table: linear between two entries, held before the first and after the last.
import package::common::{params::params, status::{status, frozen}};

@group(0) @binding(2) var<storage, read> wind_table: array<vec4f>;   // xyz: U [m/s], w: time [s], rising

// The wind at a time: between two entries of the table if it is after the first of them, else the value found so far.
fn later(found: vec3f, before: vec4f, after: vec4f, time: f32) -> vec3f {
    let part = min((time - before.w) / (after.w - before.w), 1.0);
    return select(found, mix(before.xyz, after.xyz, part), time > before.w);
}

@compute @workgroup_size(1)
fn main() {
    if frozen() { return; }
    let begin = f32(status.step) * params.step;
    let end = f32(status.step + 1u) * params.step;
    var entry = vec4f();   // the one before: the first is taken as it is, whatever `later` finds for it
    var before = vec3f(0.0);
    var now = vec3f(0.0);
    var fastest = 0.0;
    for (var k = 0u; k < arrayLength(&wind_table); k++) {
        let after = wind_table[k];
        before = select(later(before, entry, after, begin), after.xyz, k == 0u);
        now = select(later(now, entry, after, end), after.xyz, k == 0u);
        fastest = max(fastest, length(after.xyz));
        entry = after;
    }
    status.wind_before = before;
    status.wind = now;
    status.fastest_wind = fastest;
}
