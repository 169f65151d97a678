// The strength of each force field at the end of the step: linear between its keyframes, held before the first and
// after the last. The strongest field adds to the fastest wind. One invocation.
import package::common::{params::params, field::{fields, Field}, status::{status, frozen}};

@group(0) @binding(2) var<storage, read>       field_keyframes:   array<vec2f>;   // time [s], strength [m/s]
@group(0) @binding(3) var<storage, read_write> field_strength: array<f32>;        // m/s

fn at(field: Field, time: f32) -> f32 {
    var strength = field_keyframes[field.first_key].y;
    for (var k = field.first_key + 1u; k < field.first_key + field.keys; k++) {
        let before = field_keyframes[k - 1u];
        let after = field_keyframes[k];
        if time <= before.x { break; }
        strength = mix(before.y, after.y, min((time - before.x) / (after.x - before.x), 1.0));
    }
    return strength;
}

fn fastest(field: Field) -> f32 {
    var speed = 0.0;
    for (var k = field.first_key; k < field.first_key + field.keys; k++) {
        speed = max(speed, abs(field_keyframes[k].y));
    }
    return speed;
}

@compute @workgroup_size(1)
fn main() {
    if frozen() { return; }
    let time = f32(status.step + 1u) * params.step;
    var strongest = 0.0;
    for (var f = 0u; f < arrayLength(&fields); f++) {
        field_strength[f] = at(fields[f], time);
        strongest = max(strongest, fastest(fields[f]));
    }
    status.fastest_wind += strongest;
}
