// Air beside bodies goes by the mean of its velocities before and after the step: the difference of the
// pressure's change from that of the step before counts for half of the way, which `forcing/advance` could not know.
//
//   x += dt/2 (a - a_before)
import package::common::{params::params, dispatch::{invocation, WORKGROUP}, pressure::Pressed, status::frozen};

@group(0) @binding(2) var<storage, read>       pressed:        array<Pressed>;
@group(0) @binding(3) var<storage, read>       pressed_before: array<Pressed>;
@group(0) @binding(4) var<storage, read_write> predicted:      array<vec4f>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = params.hair_points + invocation(id, groups);
    if (i >= params.particles) | frozen() { return; }
    let missed = 0.5 * params.step * (pressed[i].change - pressed_before[i].change);
    predicted[i] += vec4f(missed, 0.0);
}
