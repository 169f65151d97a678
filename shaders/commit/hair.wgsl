// History of hair points for the next step: their move, this step's first velocity with the changes by external forces
// since, and the remainder that rounding leaves off the position. A placed point gets an empty history; a sleeping one
// keeps the velocity of the step before, since BDF2 would take a third of its change as a kick.
import package::common::{
    params::{params, PARTICLES}, dispatch::{invocation, WORKGROUP}, integration::{KINEMATIC, HOLD},
    rod::{RodPoint, PointHistory}, place::placed,
    status::frozen,
};

@group(0) @binding(2) var<storage, read>       predicted:      array<vec4f>;
@group(0) @binding(3) var<storage, read>       new_velocity:   array<vec4f>;
@group(0) @binding(4) var<storage, read>       final_velocity: array<vec4f>;
@group(0) @binding(5) var<storage, read>       rod_points:     array<RodPoint>;
@group(0) @binding(6) var<storage, read>       tangential_spring: array<vec4f>;
@group(0) @binding(7) var<storage, read_write> point_history:  array<PointHistory>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let p = invocation(id, groups);
    if (p >= params.hair_points) | frozen() { return; }
    let point = rod_points[p];
    let before = point_history[p].remainder;
    let x = point.start.xyz;
    let untouched = all(predicted[p].xyz == placed(x, point.remainder, point.displacement));
    let left = (x - predicted[p].xyz) + (point.displacement + point.remainder);
    let anew = point.scheme >= KINEMATIC;
    let remainder = select(vec3f(0.0), left, untouched && !anew);
    let stays = point.scheme == HOLD;
    let last = final_velocity[p].xyz;
    let forgets = params.model == PARTICLES;
    let external_dv = select(point.external_dv, vec3f(0.0), forgets);
    let own = select(new_velocity[p].xyz - point.before, vec3f(0.0), forgets || anew);
    point_history[p] = PointHistory(
        select(point.displacement, params.step * last, anew),
        select(point.before + last - new_velocity[p].xyz, last, anew && !stays),
        remainder,
        select(external_dv, point_history[p].external_dv, stays),
        select(own, point_history[p].own, stays),
        tangential_spring[p].xyz,
        point.rest_drift + ((predicted[p].xyz - x) + (remainder - before)),
        point.pin_force,
    );
}
