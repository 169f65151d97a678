// Draws hairs as ribbons that face the camera and taper to the tip. None is narrower than a drawn pixel, measured along
// a row or a column, whichever the hair crosses: it then meets each of a pixel's samples once on its way over every
// column or row. A thinner hair covers fewer of the samples instead, each hair its own, so that it fades evenly and
// does not break up.
import package::pictures::{common::{view, hash, chance}, taper::taper, backdrop::backdrop};

@group(0) @binding(1) var<storage, read> points: array<vec4f>;
@group(0) @binding(2) var<storage, read> colour: array<u32>;
@group(0) @binding(3) var<storage, read> radius: array<f32>;

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
    let normal = cross(after - before, to_eye);
    let across = normal * inverseSqrt(max(dot(normal, normal), 1e-30));
    // Drawn pixels to a metre across the hair, to the right and up.
    let middle = view.clip_from_world * vec4f(here.xyz, 1.0);
    let aside = view.clip_from_world * vec4f(across, 0.0);
    let scale = 0.5 * view.size * (aside.xy - middle.xy / middle.w * aside.w) / middle.w;
    let half_width = radius[hair] * taper(here.w);
    let drawn = max(half_width, 0.5 * max(abs(scale.x), abs(scale.y)) / max(dot(scale, scale), 1e-30));
    var out: Vertex;
    let x = here.xyz + side * drawn * across;
    out.position = view.clip_from_world * vec4f(x, 1.0);
    out.coverage = half_width / max(drawn, 1e-30);
    out.colour = faded(unpack4x8unorm(colour[i]).rgb, length(to_eye), out.position);
    out.hair = hair;
    return out;
}

// Linear rgb of a colour at a distance, nearer to the backdrop's the farther. `colour` is the square root of linear
// rgb.
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
