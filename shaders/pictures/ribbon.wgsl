// Draws hairs as ribbons that face the camera and taper to the tip. None is narrower than MIN_WIDTH: a thinner hair
// covers fewer of a pixel's samples instead, each hair its own samples, so that it fades and does not break up.
import package::pictures::{common::{view, hash, chance}, taper::taper, backdrop::backdrop};

@group(0) @binding(1) var<storage, read> points: array<vec4f>;
@group(0) @binding(2) var<storage, read> colour: array<u32>;
@group(0) @binding(3) var<storage, read> radius: array<f32>;

const MIN_WIDTH: f32 = 1.0;   // least width of a drawn hair [px]: thinner ribbons would miss pixels

struct Vertex {
    @builtin(position)              position: vec4f,
    @location(0)                    colour:   vec3f,
    @location(1)                    coverage: f32,
    @location(2) @interpolate(flat) hair:     u32,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32, @builtin(instance_index) hair: u32) -> Vertex {
    let k = index / 2u;
    let side = f32(index % 2u) * 2.0 - 1.0;
    let i = hair * view.samples + k;
    let here = points[i];
    let before = points[select(i, i - 1u, k > 0u)].xyz;
    let after = points[select(i, i + 1u, k + 1u < view.samples)].xyz;
    let to_eye = view.eye.xyz - here.xyz;
    let across = cross(after - before, to_eye);
    let pixel = view.eye.w * length(to_eye);
    let half_width = radius[hair] * taper(here.w);
    let drawn = max(half_width, 0.5 * MIN_WIDTH * pixel);
    var out: Vertex;
    let x = here.xyz + side * drawn * across * inverseSqrt(max(dot(across, across), 1e-30));
    out.position = view.clip_from_world * vec4f(x, 1.0);
    out.coverage = half_width / drawn;
    out.colour = faded(unpack4x8unorm(colour[i]).rgb, length(to_eye), out.position);
    out.hair = hair;
    return out;
}

// Linear rgb of a colour at a distance, nearer to the backdrop's the farther. `colour` is the square root of linear rgb.
fn faded(colour: vec3f, far: f32, clip: vec4f) -> vec3f {
    let depth = clamp((far - view.right.w) * view.up.w, 0.0, 1.0);
    return mix(colour * colour, backdrop(0.5 - 0.5 * clip.xy / clip.w), 0.10 * depth);
}

struct Fragment {
    @location(0)           colour: vec4f,
    @builtin(sample_mask)  mask:   u32,
}

@fragment
fn fragment(in: Vertex) -> Fragment {
    let kept = u32(4.0 * in.coverage + chance(in.hair, 20u));
    let turn = hash(in.hair) & 3u;
    let bits = (1u << min(kept, 4u)) - 1u;
    return Fragment(vec4f(in.colour, 1.0), ((bits << turn) | (bits >> (4u - turn))) & 15u);
}
