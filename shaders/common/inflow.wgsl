// Inflow: behind the faces that it enters through, the fringe draws the air towards it.
import package::common::{params::params, pi::PI, wind::{mean_wind, wind_path, depth_of}};

const SLOWEST: f32 = 0.3;       // m/s: the fringe draws air also while the wind rises
const RELAXATION: f32 = 10.0;   // of the fringe, per passage

struct Wave {
    number: vec4f,      // xyz: k [1/m], whole periods to the box; w: phase
    amplitude: vec4f,   // a, of the wind's speed
}

@group(0) @binding(4) var<storage, read> inflow: array<Wave>;   // one of no amplitude without inflow turbulence

// Whether turbulence enters with the wind: a switch (`shaders/src/lib.rs`).
override INFLOW: bool = true;

// Velocity that the wind brings in at a place [m/s].
fn incoming_velocity(place: vec3f) -> vec3f {
    if !INFLOW { return mean_wind(); }
    let carried = place - wind_path();
    var eddies = vec3f(0.0);
    for (var m = 0u; m < arrayLength(&inflow); m++) {
        let wave = inflow[m];
        eddies += wave.amplitude.xyz * sin(dot(wave.number.xyz, carried) + wave.number.w);
    }
    return mean_wind() + length(mean_wind()) * eddies;
}

// Rate at which the fringe draws air at a place towards that [1/s].
fn rate_at(place: vec3f) -> f32 {
    let wind = mean_wind();
    let speed = length(wind);
    let depth = depth_of(place, wind);
    let bump = sin(PI * depth / params.fringe);
    let within = select(vec3f(0.0), bump * bump, depth < vec3f(params.fringe));
    let rate = dot(abs(wind) / speed, within) * RELAXATION * max(speed, SLOWEST) / params.fringe;
    return select(0.0, rate, params.fringe * speed > 0.0);
}
