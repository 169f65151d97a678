// Where the velocities of the step's start lead a strand.
import package::common::{params::params, rod::{RodStrand, RodPoint, RodSegment}};

// A held point goes where it is held: the root with its clamp, a tip not at all.
fn held_move(rod: RodStrand, k: u32) -> vec3f {
    return select(vec3f(0.0), rod.root_travel, k == 0u);
}

// The move of point k of a strand. (By the velocity before, too, it would lead nearer; rings under moment then begin to swing.)
fn led_move(point: RodPoint, rod: RodStrand, k: u32) -> vec3f {
    if point.inverse_mass == 0.0 { return held_move(rod, k); }
    return params.step * point.velocity;
}

fn led_turn(segment: RodSegment) -> vec3f {
    return params.step * segment.angular_velocity;
}
