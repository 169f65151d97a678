// Commits the impulse of the air on each body, and counts the steps in which air beside bodies does not keep its
// density, or goes too far: if that lasts, the step is too long for the body.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, status::{status, frozen, count, AIR_BESIDE},
};

const LARGEST_ERROR: f32 = 0.06;   // rms of theta - 1 within a kernel radius of bodies
const LONG: f32 = 0.02;            // s
const FAR: f32 = 1.2;              // d, of the way in a step

// of each body (`contact/body_impulse`)
@group(0) @binding(2) var<storage, read>       air_total:           array<mat2x4f>;
// by the coarse pressure, over the mass of an air particle [m/s]
@group(0) @binding(3) var<storage, read>       coarse_impulse: array<vec4f>;
@group(0) @binding(4) var<storage, read_write> body_impulse:   array<vec4f>;          // of the run [kg m/s]

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let body = invocation(id, groups);
    let bodies = arrayLength(&body_impulse);
    if (body >= bodies) | frozen() { return; }
    body_impulse[body] += vec4f(air_total[body][0].xyz + coarse_impulse[body].xyz, 0.0) / params.air_inverse_mass;
    if body > 0u { return; }
    var errors = 0.0;
    var beside = 0.0;
    for (var k = 0u; k < bodies; k++) {
        errors += air_total[k][0].w;
        beside += air_total[k][1].x;
    }
    let off = errors > LARGEST_ERROR * LARGEST_ERROR * beside;
    let steps = select(0u, status.off_steps + 1u, off);
    status.off_steps = steps;
    let far = bitcast<f32>(atomicExchange(&status.path_beside, 0u)) > FAR;
    if far || f32(steps) * params.step > LONG { count(AIR_BESIDE); }
}
