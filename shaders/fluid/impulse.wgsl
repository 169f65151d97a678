// Impulse of the pressure on hair that is in one fluid with air. A push of pressure goes on for some steps under BDF2,
// a third of it in the next, and comes to 3/2 of itself: so much is the impulse that the hair has from it, a move of
// the drifting point as the density constraint's is.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, pressure::{Pressed, LASTING}, status::frozen,
};

@group(0) @binding(2) var<storage, read>       pressed:    array<Pressed>;
@group(0) @binding(3) var<storage, read_write> correction: array<vec4f>;   // m

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let p = invocation(id, groups);
    if (p >= params.hair_points) | frozen() { return; }
    correction[p] = vec4f(LASTING * params.step * pressed[p].change, 0.0);
}
