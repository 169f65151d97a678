// Freezes the run when air is non-finite or too many strands were reset in this step.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, cells::is_air,
    status::{status, frozen, freeze, finite3, NON_FINITE_AIR, TOO_MANY_BAD_STRANDS},
};

@group(0) @binding(2) var<storage, read> predicted:      array<vec4f>;
@group(0) @binding(3) var<storage, read> final_velocity: array<vec4f>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = invocation(id, groups);
    if i >= params.particles { return; }
    if i == 0u && atomicLoad(&status.bad_strands) > params.bad_strand_limit {
        freeze(TOO_MANY_BAD_STRANDS);
    }
    if is_air(i) && !(finite3(predicted[i].xyz) && finite3(final_velocity[i].xyz)) {
        // After an overflow the scratch arrays mean nothing.
        if (atomicLoad(&status.causes) & ~(NON_FINITE_AIR | TOO_MANY_BAD_STRANDS)) == 0u {
            freeze(NON_FINITE_AIR);
            atomicMin(&status.first_bad_air, i - params.hair_points);
        }
    }
}
