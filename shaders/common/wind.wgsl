// The mean wind of the step, as `forcing/mean_wind` found it; it enters through a fringe behind the faces it blows
// through.
import package::common::{params::params, status::status};

// U at the end of the step [m/s].
fn mean_wind() -> vec3f {
    return status.wind;
}

// U at the start of the step [m/s].
fn wind_before() -> vec3f {
    return status.wind_before;
}

// Way by which the wind has carried the inflow's eddies since the start of the run [m].
fn wind_path() -> vec3f {
    return status.wind_path;
}

// Depth behind the face that the wind enters through, per axis [m].
fn depth_of(position: vec3f, wind: vec3f) -> vec3f {
    return select(params.box_size - position, position, wind >= vec3f(0.0));
}

// Part of a change of velocity that the fringe leaves: 0 behind a face that the wind meets head on, and nearly
// all behind a face that the wind passes along, so that a wind may turn without a jump.
fn left_by_fringe(position: vec3f) -> f32 {
    let wind = mean_wind();
    let speed = length(wind);
    let within = depth_of(position, wind) < vec3f(params.fringe);
    let left = max(0.0, 1.0 - dot(abs(wind) / speed, select(vec3f(0.0), vec3f(1.0), within)));
    return select(1.0, left, params.fringe * speed > 0.0);
}
