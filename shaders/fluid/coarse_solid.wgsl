// Change of velocity of bodies by the coarse pressure, if they were air: sums over the sites of a lattice
// that lie in each body, three along each axis of a cell. The grid is solved for a box full of air, of which bodies
// take a part: its momentum and energy count.
import package::common::{
    params::params, dispatch::WORKGROUP, status::frozen, coarse::{mesh, pushed_at}, body::{surface, surface_move},
    nearest::placed,
    by_body::sum_by_body,
};

const ALONG: i32 = 3;   // sites of a cell along each axis

// A site brings w q [m/s] and w q . v [m^2/s^2]; w v [m/s], v the velocity of the body there, and w, the particles of
// air that would fill it.
fn term(i: u32, body: u32) -> mat2x4f {
    let counts = ALONG * mesh.nodes;
    let site = vec3i(i32(i) % counts.x, i32(i) / counts.x % counts.y, i32(i) / (counts.x * counts.y));
    let pitch = mesh.spacing / f32(ALONG);
    let x = (vec3f(site) + 0.5) * pitch;
    var inside = surface(placed[body], x).distance < 0.0;
    for (var k = 0u; inside && k < body; k++) { inside = surface(placed[k], x).distance >= 0.0; }
    if !inside { return mat2x4f(); }
    let w = pitch.x * pitch.y * pitch.z / params.air_volume;
    let q = pushed_at(x);
    let v = surface_move(placed[body], x) / params.step;
    return mat2x4f(w * vec4f(q, dot(q, v)), w * vec4f(v, 1.0));
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(num_workgroups) groups: vec3u, @builtin(local_invocation_index) local: u32,
    @builtin(workgroup_id) group: vec3u,
) {
    let counts = ALONG * mesh.nodes;
    sum_by_body(select(u32(counts.x * counts.y * counts.z), 0u, frozen()), groups, local, group);
}
