// The effect of the pressure in this step is the next one's start; hair that was put somewhere starts anew. Air is
// committed in the order of cells.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, cells::is_air, status::frozen, pressure::{Pressed, flows},
    integration::KINEMATIC, rod::RodPoint,
};

@group(0) @binding(2) var<storage, read>       rod_points:     array<RodPoint>;
@group(0) @binding(3) var<storage, read>       pressed:        array<Pressed>;
@group(0) @binding(4) var<storage, read>       sorted:         array<u32>;
@group(0) @binding(5) var<storage, read_write> pressed_before: array<Pressed>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let slot = invocation(id, groups);
    if (slot >= params.particles) | frozen() { return; }
    if !flows(slot) { return; }
    if is_air(slot) {
        pressed_before[slot] = pressed[sorted[slot - params.hair_points]];
        return;
    }
    pressed_before[slot] = pressed[slot];
    if rod_points[slot].scheme == KINEMATIC { pressed_before[slot] = Pressed(vec3f(0.0), 0.0); }
}
