// c of a hair point: the scene's damping, and the resistance to its velocity.
import package::common::{params::params, rod::RodPoint};

fn damping_of(point: RodPoint) -> f32 {
    return params.damping + point.inverse_mass * point.resistance;
}
