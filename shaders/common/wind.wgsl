// The mean wind: it rises linearly over the ramp, and enters through a fringe behind the faces it blows through.
import package::common::params::params;

// Part of the wind that has risen after `steps` steps.
fn risen(steps: u32) -> f32 {
    if params.ramp <= 0.0 { return 1.0; }
    return min(f32(steps) * params.step / params.ramp, 1.0);
}

fn mean_wind(steps: u32) -> vec3f {
    return params.wind * risen(steps);
}

// Depth behind the face that the wind enters through, per axis [m].
fn depth_of(position: vec3f) -> vec3f {
    return select(params.box_size - position, position, params.wind >= vec3f(0.0));
}

fn in_fringe(position: vec3f) -> bool {
    return any((depth_of(position) < vec3f(params.fringe)) & (params.wind != vec3f(0.0)));
}
