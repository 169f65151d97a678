// The coarse pressure pushes the air: q is what it would change the air's velocity v by. The mean of q is not zero among disordered
// particles, and is taken out: pressure drives no wind. Of what is left, the air gets little more than the part that takes the most
// energy from it:
//
//   p = 1.15 a/b, from 0 to 1,  a = -sum (q - mean q) . v,  b = sum |q - mean q|^2        the energy changes by m (-p a + p^2 b/2)
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, status::frozen, pressure::Pressed, mean::air_particles,
};

const BEYOND: f32 = 1.15;   // of the part that takes the most energy: less takes too much from eddies, more lets air clump

@group(0) @binding(2) var<storage, read>       coarse_change: array<vec4f>;
@group(0) @binding(3) var<storage, read>       coarse_total:  array<vec4f>;   // sums over air: q, w: q . v; then v, w: q . q (`sums/changes`)
@group(0) @binding(4) var<storage, read_write> new_velocity:  array<vec4f>;
@group(0) @binding(5) var<storage, read_write> pressed:       array<Pressed>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = params.hair_points + invocation(id, groups);
    if (i >= params.particles) | frozen() { return; }
    let sum = coarse_total[0];
    let mean = sum.xyz / air_particles();
    let taken = dot(mean, coarse_total[1].xyz) - sum.w;
    let square = max(coarse_total[1].w - dot(mean, sum.xyz), 1e-30);
    let change = clamp(BEYOND * taken / square, 0.0, 1.0) * (coarse_change[i].xyz - mean);
    new_velocity[i] += vec4f(change, 0.0);
    pressed[i].change += change;
}
