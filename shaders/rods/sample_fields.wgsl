// The wind of force fields at every hair point, where no air carries it: with the model two-way it takes part as the
// mean wind does where air thins out, with the others it is added to the mean wind, at the place to which the point's
// velocity leads it.
//
//   two-way   u += (1 - min(theta, 1/2)/(1/2)) sum_f u_f(y)
//   others    u = U + sum_f u_f(x + dt v)
import package::common::{
    params::{params, TWO_WAY}, dispatch::{invocation, WORKGROUP}, status::frozen, wind::mean_wind, air::{Sampled, THIN},
    force_field_velocity::field_velocity_at,
};

@group(0) @binding(2) var<storage, read>       position: array<vec4f>;
@group(0) @binding(3) var<storage, read>       velocity: array<vec4f>;
@group(0) @binding(4) var<storage, read_write> sampled:  array<Sampled>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let p = invocation(id, groups);
    if (p >= params.hair_points) | frozen() { return; }
    var air = sampled[p];
    if params.model != TWO_WAY {
        air = Sampled(position[p].xyz + params.step * velocity[p].xyz, 0.0, mean_wind(), 0.0);
    }
    air.wind += (1.0 - min(air.filled, THIN) / THIN) * field_velocity_at(air.position).wind;
    sampled[p] = air;
}
