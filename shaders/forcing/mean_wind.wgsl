// The mean wind of the step, from its table: linear between two entries, held before the first and after the last. Each
// invocation finds one component.
import package::common::{params::params, status::{status, frozen}};

@group(0) @binding(2) var<storage, read> wind_table: array<vec4f>;   // xyz: U [m/s], w: time [s], rising

const AXES: u32 = 3u;

// The wind along an axis at a time: between two entries of the table if it is after the first of them, else the value
// found so far.
fn later(found: f32, before: vec4f, after: vec4f, axis: u32, time: f32) -> f32 {
    let part = min((time - before.w) / (after.w - before.w), 1.0);
    return select(found, mix(before[axis], after[axis], part), time > before.w);
}

@compute @workgroup_size(AXES)
fn main(@builtin(local_invocation_id) id: vec3u) {
    let axis = id.x;
    if frozen() { return; }
    let begin = f32(status.step) * params.step;
    let end = f32(status.step + 1u) * params.step;
    var entry = vec4f();   // the one before: the first is taken as it is, whatever `later` finds for it
    var before = 0.0;
    var now = 0.0;
    var fastest = 0.0;
    for (var k = 0u; k < arrayLength(&wind_table); k++) {
        let after = wind_table[k];
        before = select(later(before, entry, after, axis, begin), after[axis], k == 0u);
        now = select(later(now, entry, after, axis, end), after[axis], k == 0u);
        fastest = max(fastest, length(after.xyz));
        entry = after;
    }
    status.wind_before[axis] = before;
    status.wind[axis] = now;
    if axis == 0u { status.fastest_wind = fastest; }
}
