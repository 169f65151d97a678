// Finds the colour of every point of every drawn hair (Marschner et al. 2003, with the lobes' shapes of Karis 2016).
//
// Each light adds three lobes: R off the cuticle, white, shifted toward the root; TT through the fibre, tinted once;
// TRT back through it, tinted twice, shifted toward the tip; and a diffuse part for light scattered among hairs (Kajiya
// & Kay 1989). Hair between the point and the light takes away more of the colours that hair absorbs more. There is one
// invocation per point.
import package::common::dispatch::{invocation, WORKGROUP};
import package::pictures::{common::{view, chance}, shadow::optical_depth};

@group(0) @binding(2) var<storage, read>       points: array<vec4f>;
@group(0) @binding(3) var<storage, read>       seed:   array<u32>;   // seed of each hair
@group(0) @binding(4) var<storage, read_write> colour: array<u32>;   // pack4x8unorm of the square root of linear rgb

// Colour of white light after one way through a fibre, linear rgb: auburn.
const TINT: vec3f = vec3f(0.41, 0.19, 0.082);
// Radiance of the light that the surroundings throw back, linear rgb: a cool grey, chosen by eye.
const BOUNCE: vec3f = vec3f(0.075, 0.078, 0.082);
const SHIFT: f32 = 0.09;   // tilt of the cuticle's scales [rad]: 5 degrees, as Marschner et al. found in hair
const ROUGH: f32 = 0.20;   // width of the lobes [rad], chosen by eye

fn gaussian(x: f32, width: f32) -> f32 {
    return exp(-0.5 * x * x / (width * width)) / (2.5066 * width);
}

fn scattered(tangent: vec3f, to_light: vec3f, to_eye: vec3f, tint: vec3f, tilt: f32) -> vec3f {
    let sin_i = clamp(dot(tangent, to_light), -1.0, 1.0);
    let sin_o = clamp(dot(tangent, to_eye), -1.0, 1.0);
    let half_angle = 0.5 * (asin(sin_i) + asin(sin_o)) + tilt;
    let cos_i = sqrt(max(1.0 - sin_i * sin_i, 0.0));
    let across_i = to_light - sin_i * tangent;
    let across_o = to_eye - sin_o * tangent;
    let cos_phi = dot(across_i, across_o) * inverseSqrt(max(dot(across_i, across_i) * dot(across_o, across_o), 1e-8));
    let r = 0.032 * gaussian(half_angle + SHIFT, ROUGH * 0.6) * sqrt(max(0.5 + 0.5 * cos_phi, 0.0));
    let tt = 0.06 * gaussian(half_angle - 0.5 * SHIFT, ROUGH * 0.5) * exp(-3.65 * cos_phi - 3.98) * tint;
    let trt = 0.30 * gaussian(half_angle - 1.5 * SHIFT, ROUGH) * exp(17.0 * cos_phi - 16.78) * tint * tint;
    let trt_wide = 0.11 * gaussian(half_angle - 1.5 * SHIFT, ROUGH * 1.6) * (0.5 + 0.5 * cos_phi) * tint * sqrt(tint);
    let diffuse = 0.36 * (0.25 + 0.75 * (0.5 + 0.5 * cos_phi)) * tint * tint;
    return cos_i * (r + tt + trt + trt_wide + diffuse);
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = invocation(id, groups);
    if i >= view.hairs * view.samples {
        return;
    }
    let hair = i / view.samples;
    let k = i % view.samples;
    let here = points[i];
    let before = points[select(i, i - 1u, k > 0u)].xyz;
    let after = points[select(i, i + 1u, k + 1u < view.samples)].xyz;
    let tangent = (after - before) * inverseSqrt(max(dot(after - before, after - before), 1e-20));
    let to_eye = normalize(view.eye.xyz - here.xyz);

    // Hairs differ: some are darker, some redder; tips are bleached a little.
    let s = seed[hair];
    let melanin = 1.25 - 0.55 * chance(s, 10u) + 0.25 * (chance(s, 11u) - 0.5) - 0.22 * here.w;
    let tint = pow(TINT * vec3f(1.0, 1.0 + 0.25 * (chance(s, 12u) - 0.5), 1.0), vec3f(max(melanin, 0.3)));

    // No two hairs shine in the same place.
    let tilt = 0.22 * (chance(s, 13u) + chance(s, 14u) - 1.0);
    // The first part is light that has met so many hairs that it comes from everywhere.
    var sum = BOUNCE * tint * (0.4 + 1.2 * chance(s, 15u));
    for (var light = 0u; light < 2u; light++) {
        let toward = view.lights[light].toward.xyz;
        let depth = optical_depth(light, here.xyz);
        // A fibre scatters on, tinted, most of what it takes from the beam.
        let through = exp(-depth * (0.22 + 0.40 * (vec3f(1.0) - sqrt(tint))));
        sum += scattered(tangent, toward, to_eye, tint, tilt) * through * view.lights[light].colour.rgb;
    }
    let mapped = 1.0 - exp(-1.7 * sum);
    colour[i] = pack4x8unorm(vec4f(sqrt(mapped), 1.0));
}
