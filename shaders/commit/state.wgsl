// Commits the step of hair, positions and velocities, and the scalars of the run, the counters and the step's number. A
// frozen step leaves them as they were.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, mean::{air_particles, taken_out},
    status::{status, frozen, COUNTERS, HAIR_OUTSIDE, NO_POINT},
};

const MANY: u32 = 20u;          // one in 20 of the hair's points
const LONG: f32 = 0.1;          // s

@group(0) @binding(2) var<storage, read>       predicted:      array<vec4f>;
@group(0) @binding(3) var<storage, read>       final_velocity: array<vec4f>;
@group(0) @binding(4) var<storage, read_write> position:       array<vec4f>;
@group(0) @binding(5) var<storage, read_write> velocity:       array<vec4f>;
// sum of the changes of velocity by confinement [m/s]
@group(0) @binding(6) var<storage, read>       confinement_total:   array<vec4f>;
@group(0) @binding(7) var<storage, read_write> confinement_impulse: array<vec4f>;   // one, of the run [kg m/s]

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = invocation(id, groups);
    if frozen() {
        if i == 0u { status.ended = 1u; }
        return;
    }
    if i < params.hair_points {
        position[i] = predicted[i];
        velocity[i] = final_velocity[i];
    }
    if i == 0u {
        let step = status.step + 1u;
        status.step = step;
        status.inspected = 0u;
        status.max_stretch = max(status.max_stretch, atomicExchange(&status.stretch, 0u));
        let sum = confinement_total[0].xyz;
        let kept = (sum - air_particles() * taken_out(sum)) / params.air_inverse_mass;
        confinement_impulse[0] += vec4f(select(vec3f(0.0), kept, params.air_inverse_mass > 0.0), 0.0);
        let first = atomicExchange(&status.first_bad, NO_POINT);
        if atomicExchange(&status.failed_strands, 0u) != 0u {
            status.reset_first = first;
            status.reset_step = step;
        }
    }
    if i == 0u {
        let side = params.box_size;
        let path = status.wind_path + params.step * 0.5 * (status.wind_before + status.wind);
        status.wind_path = path - select(vec3f(0.0), side * floor(path / side), side > vec3f(0.0));
    }
    // An invocation per cause: drivers write out loops over so few.
    if i < COUNTERS {
        var times = atomicExchange(&status.counting[i], 0u);
        if i == HAIR_OUTSIDE {
            let many = atomicExchange(&status.hair_outside, 0u) * MANY > params.hair_points;
            let steps = select(0u, status.outside_steps + 1u, many);
            status.outside_steps = steps;
            times = u32(f32(steps) * params.step > LONG);
        }
        // Ten thousand sleepers fill 32 bits in ten minutes: full is full.
        let before = status.counted[i];
        status.counted[i] = before + min(times, 0xffffffffu - before);
    }
}
