//! Force fields: winds of their own within their reach.

use glam::DVec3;
use windswept_scene::{CheckedScene, ForceField, InitialState};

use crate::Parameters;

/// Force field in local coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    /// Shape of the field's wind.
    pub shape: ForceField,
    /// Origin \[m\].
    pub origin: DVec3,
    /// Axis, a unit vector; a point has none, and any stands here.
    pub axis: DVec3,
    /// Distance at which the field ends \[m\].
    pub reach: f64,
    /// Radius of a jet, or at which a vortex or a point blows with its strength \[m\].
    pub radius: f64,
    /// Way over which air takes the field's wind up \[m\].
    pub uptake: f64,
    /// Times \[s\] and strengths \[m/s\], linear in between.
    pub keyframes: Vec<(f64, f64)>,
}

/// Force fields of a scene; none where they do nothing.
pub(crate) fn fields(scene: &CheckedScene, initial: &InitialState) -> Vec<Field> {
    let acting = scene.forces.iter().filter(|_| scene.why_no_fields().is_none());
    let field = acting.map(|force| Field {
        shape: force.field,
        origin: DVec3::from_array(force.origin) - initial.origin,
        axis: force.axis(),
        reach: force.reach,
        radius: force.radius,
        uptake: force.uptake,
        keyframes: force.strengths(),
    });
    field.collect()
}

/// Strength of a field after `steps` steps \[m/s\]: linear between keyframes, held before the first and after the last.
#[must_use]
pub fn field_strengths(p: &Parameters, field: &Field, steps: u64) -> f64 {
    let time = steps as f64 * p.step;
    let next = field.keyframes.partition_point(|(at, _)| *at <= time);
    match (next.checked_sub(1).map(|last| field.keyframes[last]), field.keyframes.get(next)) {
        (Some((a, from)), Some((b, to))) => from + (time - a) / (b - a) * (to - from),
        (Some((_, held)), None) | (None, Some(&(_, held))) => held,
        (None, None) => 0.0,
    }
}

/// Weight that falls from 1 at half of the way to 0 at its end, as a cubic with level ends.
fn fading(part: f64) -> f64 {
    let t = (2.0 * part - 1.0).clamp(0.0, 1.0);
    1.0 - t * t * (3.0 - 2.0 * t)
}

/// Wind u of a field of this strength \[m/s\] at a place \[m\], and the rate at which it draws air \[1/s\].
fn blown(field: &Field, strength: f64, place: DVec3) -> (DVec3, f64) {
    let Field { axis, reach, radius, .. } = *field;
    let gap = place - field.origin;
    let along = gap.dot(axis);
    let across = gap - along * axis;
    let (weight, wind) = match field.shape {
        ForceField::Jet => {
            let lengthwise = if along < 0.0 { fading(-along / radius) } else { fading(along / reach) };
            (lengthwise * fading(across.length() / radius), axis)
        }
        ForceField::Vortex => {
            let q = across.length();
            let speed = if q < radius { q / radius } else { radius / q };
            (fading(q / reach), speed * axis.cross(across).normalize_or_zero())
        }
        ForceField::Point => {
            let q = gap.length();
            let speed = if q < radius { q / radius } else { (radius / q).powi(2) };
            (fading(q / reach), speed * gap.normalize_or_zero())
        }
    };
    (weight * strength * wind, weight * strength.abs() / field.uptake)
}

/// Wind Σ u_f of all fields at a place in step number `steps` \[m/s\], beside the mean wind, and the rate Σ w_f
/// |S_f|/uptake_f at which they draw air to both \[1/s\].
#[must_use]
pub fn force_field_velocity(p: &Parameters, steps: u64, place: DVec3) -> (DVec3, f64) {
    // Fields stand still in the world.
    let place = place + super::frame(p, steps + 1).0;
    let all = p.fields.iter().map(|field| blown(field, field_strengths(p, field, steps + 1), place));
    all.fold((DVec3::ZERO, 0.0), |sum, (wind, rate)| (sum.0 + wind, sum.1 + rate))
}

/// Change of the velocity of air by the fields in step number `steps` \[m/s\], (1 − e^{−kΔt})(U + Σ u_f − v), k the
/// rate; `velocity` has what the wind has added already.
#[must_use]
pub fn drive_air(p: &Parameters, steps: u64, position: DVec3, velocity: DVec3) -> DVec3 {
    let (wind, rate) = force_field_velocity(p, steps, position);
    (1.0 - (-rate * p.step).exp()) * (super::mean_wind(p, steps + 1) + wind - velocity)
}
