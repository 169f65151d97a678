// Freezes the step when a particle of air or a point of hair is not finite or faster than FAST, or when too many
// strands were reset, and counts the hair points outside the box of air. An invalid hair point gets here only if
// `commit/hold`, which holds such strands, did not run: the step is replayed with it. Also copies the stable id of each
// slot of air, since `commit/air` writes these ids in a new order.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, cells::{is_air, cell_of, in_box},
    validity::can_be,
    status::{
        status, freeze, NEIGHBOUR_OVERFLOW, NON_FINITE_AIR, TOO_MANY_FAILED_STRANDS, UNRECOVERED_STRAND,
    },
};

@group(0) @binding(2) var<storage, read>       predicted:      array<vec4f>;
@group(0) @binding(3) var<storage, read>       final_velocity: array<vec4f>;
@group(0) @binding(4) var<storage, read>       air_id:         array<u32>;
@group(0) @binding(5) var<storage, read_write> air_id_before:  array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = invocation(id, groups);
    if i >= params.particles { return; }
    let air = is_air(i);
    let slot = i - select(i, params.hair_points, air);
    if air { air_id_before[slot] = air_id[slot]; }
    let bad = !can_be(predicted[i].xyz, final_velocity[i].xyz);
    let outside = !air && params.box_cells > 0u && !in_box(cell_of(predicted[i].xyz));
    // Invocation 0 makes the checks that concern the whole step; any other goes on only if its own particle is invalid
    // or outside the box.
    if !(i == 0u || bad || outside) { return; }
    if status.ended != 0u { return; }
    // If an earlier pass froze the step, the scratch arrays hold no result. If this pass found an invalid hair point,
    // the step is replayed, and the other checks are made then.
    if (atomicLoad(&status.causes) & (NEIGHBOUR_OVERFLOW | UNRECOVERED_STRAND)) != 0u { return; }
    if i == 0u && atomicLoad(&status.failed_strands) > params.failed_strand_limit {
        freeze(TOO_MANY_FAILED_STRANDS);
    }
    if outside {
        atomicAdd(&status.hair_outside, 1u);
    }
    if bad {
        freeze(select(UNRECOVERED_STRAND, NON_FINITE_AIR, air));
        if air { atomicMin(&status.first_bad_air, air_id[slot]); }
    }
}
