// The wind of all force fields at a place, and how fast it draws air. With S the strength, w the weight, q the distance
// from a vortex's axis or from a point:
//
//   jet      u = w S axis
//       w = f(max(z/reach, -z/radius)) f(r/radius), z along the axis, r off it
//   vortex   u = w S axis x e R(q), R = min(q/radius, radius/q)
//       w = f(q/reach), e from the axis: Rankine's vortex
//   point    u = w S e R(q), R = min(q/radius, (radius/q)^2)             w = f(q/reach), e from the origin: a source
//
//   f falls from 1 at 1/2 to 0 at 1, as 1 - smoothstep;   rate = w |S|/uptake
import package::common::{field::{fields, Field, JET, VORTEX}, frame::frame_place};

@group(0) @binding(10) var<storage, read> field_strength: array<f32>;   // S at the end of the step [m/s]

struct FieldVelocity {
    wind: vec3f,   // m/s, beside the mean wind
    rate: f32,     // 1/s, at which air is drawn to both
}

fn fading(part: f32) -> f32 {
    return 1.0 - smoothstep(0.5, 1.0, part);
}

fn field_velocity_of(field: Field, strength: f32, place: vec3f) -> FieldVelocity {
    let gap = place - field.origin;
    let along = dot(gap, field.axis);
    let across = gap - along * field.axis;
    let whirls = field.kind == VORTEX;
    let away = select(gap, across, whirls);
    let q = length(away);
    let far = max(q, field.radius);
    let outside = field.radius / far;
    let round = select(outside * outside, outside, whirls) / far * select(away, cross(field.axis, away), whirls);
    let blown = fading(max(along / field.reach, -along / field.radius)) * fading(length(across) / field.radius);
    let is_jet = field.kind == JET;
    let weight = select(fading(q / field.reach), blown, is_jet);
    return FieldVelocity(weight * strength * select(round, field.axis, is_jet), weight * abs(strength) / field.uptake);
}

// Fields stand still in the world.
fn field_velocity_at(local: vec3f) -> FieldVelocity {
    let place = local + frame_place();
    var sum = FieldVelocity(vec3f(0.0), 0.0);
    for (var k = 0u; k < arrayLength(&fields); k++) {
        let force_field_velocity = field_velocity_of(fields[k], field_strength[k], place);
        sum.wind += force_field_velocity.wind;
        sum.rate += force_field_velocity.rate;
    }
    return sum;
}
