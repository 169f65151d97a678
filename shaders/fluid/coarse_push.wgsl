// The coarse pressure pushes the air: q is the change of the air's velocity v that it would make. The mean of q is not
// zero among disordered particles, and is taken out: pressure drives no wind. Of the rest, the air gets little more
// than the part that takes the most energy from it:
//
//   p = 1.15 a/b, from 0 to 1,  a = -sum (q - mean q) . v,  b = sum |q - mean q|^2
//       the energy changes by m (-p a + p^2 b/2)
//
// Bodies count as if they were filled with air that moves with them (`fluid/coarse_solid`): in the mean and in a. They
// get p (q - mean q) as an impulse.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, status::frozen, pressure::{Pressed, LASTING},
    mean::air_particles, body::BODIES,
};

// of the part that takes the most energy: less takes too much from eddies, more lets air clump
const BEYOND: f32 = 1.15;

@group(0) @binding(2) var<storage, read>       coarse_change: array<vec4f>;
// sums over air: q, w: q . v; then v, w: q . q (`reduce/changes`)
@group(0) @binding(3) var<storage, read>       coarse_total:  array<vec4f>;
@group(0) @binding(4) var<storage, read_write> new_velocity:  array<vec4f>;
@group(0) @binding(5) var<storage, read_write> pressed:       array<Pressed>;
@group(0) @binding(6) var<storage, read>       solid_total:   array<mat2x4f>;  // of each body (`fluid/coarse_solid`)
// impulse on each body, over the mass of an air particle [m/s]
@group(0) @binding(7) var<storage, read_write> coarse_impulse: array<vec4f>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let number = invocation(id, groups);
    let i = params.hair_points + number;
    if frozen() { return; }
    var sum = coarse_total[0];
    var velocities = coarse_total[1].xyz;
    var particles = air_particles();
    for (var k = 0u; BODIES && k < arrayLength(&solid_total); k++) {
        sum += solid_total[k][0];
        velocities += solid_total[k][1].xyz;
        particles += solid_total[k][1].w;
    }
    let mean = sum.xyz / particles;
    let taken = dot(mean, velocities) - sum.w;
    var of_mean = dot(mean, sum.xyz);
    if BODIES { of_mean = dot(mean, 2.0 * coarse_total[0].xyz - air_particles() * mean); }
    let square = max(coarse_total[1].w - of_mean, 1e-30);
    let part = clamp(BEYOND * taken / square, 0.0, 1.0);
    if BODIES && number < arrayLength(&solid_total) {
        let solid = solid_total[number];
        coarse_impulse[number] = vec4f(LASTING * part * (solid[0].xyz - solid[1].w * mean), 0.0);
    }
    if i >= params.particles { return; }
    let change = part * (coarse_change[i].xyz - mean);
    new_velocity[i] += vec4f(change, 0.0);
    pressed[i].change += change;
}
