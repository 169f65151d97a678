// Draws the scene behind the hair: the backdrop, and the patch that the hair grows from.
import package::pictures::{common::{view, FINE}, backdrop::backdrop, shadow::optical_depth};

struct Backdrop {
    @builtin(position) position: vec4f,
    @location(0)       at:       vec2f,
}

@vertex
fn backdrop_vertex(@builtin(vertex_index) index: u32) -> Backdrop {
    let corner = vec2f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0);
    return Backdrop(vec4f(corner, 1.0, 1.0), 0.5 - 0.5 * corner);
}

@fragment
fn backdrop_fragment(in: Backdrop) -> @location(0) vec4f {
    // Half a step of 8 bits more or less, in a pattern that compresses well (Bayer), or the gradient shows bands.
    let pixel = vec2u(in.position.xy) / FINE;
    let a = pixel & vec2u(1u);
    let b = (pixel >> vec2u(1u)) & vec2u(1u);
    let rank = 4u * ((2u * a.x) ^ (3u * a.y)) + ((2u * b.x) ^ (3u * b.y));
    return vec4f(backdrop(in.at) + (f32(rank) / 15.0 - 0.5) / 255.0, 1.0);
}

struct Patch {
    @builtin(position) position: vec4f,
    @location(0)       x:        vec3f,
    @location(1)       normal:   vec3f,
}

@vertex
fn patch_vertex(@location(0) x: vec3f, @location(1) normal: vec3f) -> Patch {
    return Patch(view.clip_from_world * vec4f(x, 1.0), x, normal);
}

@fragment
fn patch_fragment(in: Patch) -> @location(0) vec4f {
    let normal = normalize(in.normal);
    let to_eye = normalize(view.eye.xyz - in.x);
    // The first part is the light that the backdrop throws back.
    var sum = vec3f(0.45);
    for (var light = 0u; light < 2u; light++) {
        let toward = view.lights[light].toward.xyz;
        let shine = 0.25 * pow(max(dot(normal, normalize(toward + to_eye)), 0.0), 24.0);
        let lit = max(0.35 + 0.65 * dot(normal, toward), 0.0) + shine;
        sum += lit * exp(-0.35 * optical_depth(light, in.x)) * view.lights[light].colour.rgb;
    }
    return vec4f(1.0 - exp(-vec3f(0.15, 0.095, 0.075) * sum), 1.0);
}
