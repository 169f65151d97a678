// The frame of `air.follows` moves on: its way and its velocity at the step's end, and the change of velocity that hair
// has not felt yet. A step that froze is taken again without the change, which hair has.
import package::common::{params::params, frame::Entry, status::{status, frozen}};

@group(0) @binding(2) var<storage, read> frame_table: array<Entry>;   // times rise

@compute @workgroup_size(1)
fn main() {
    if frozen() { return; }
    let time = f32(status.step + 1u) * params.step;
    var now = frame_table[0];
    for (var k = 1u; k < arrayLength(&frame_table); k++) {
        let before = frame_table[k - 1u];
        let after = frame_table[k];
        let part = min((time - before.time) / (after.time - before.time), 1.0);
        if time > before.time {
            // To the bit where nothing changes.
            now.place = before.place + part * (after.place - before.place);
            now.velocity = before.velocity + part * (after.velocity - before.velocity);
        }
    }
    let is_new = status.frame_step != status.step + 1u;
    status.frame_change = select(vec3f(0.0), now.velocity - status.frame_velocity, is_new);
    status.frame_velocity = now.velocity;
    status.frame_place = now.place;
    status.frame_step = status.step + 1u;
}
