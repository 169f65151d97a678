// Air particles as soft points, coloured by a scalar; calm air is clear.
import package::pictures::common::view;

@group(0) @binding(1) var<storage, read> points: array<vec4f>;  // xyz [m]; w: the scalar, 1 where it is strong

struct Vertex {
    @builtin(position)              position: vec4f,
    @location(0)                    at:       vec2f,
    @location(1) @interpolate(flat) value:    f32,
}

// Diameter of a point at the distance of the picture's middle, in a picture 540 px high [px]; chosen by eye.
const SIZE: f32 = 6.5;

@vertex
fn vertex(@builtin(vertex_index) index: u32, @builtin(instance_index) particle: u32) -> Vertex {
    let corner = vec2f(f32(index & 1u), f32(index >> 1u)) * 2.0 - 1.0;
    let point = points[particle];
    let scale = 0.5 * SIZE * view.size.y / 540.0 * view.eye.w * distance(view.eye.xyz, point.xyz);
    let x = point.xyz + scale * (corner.x * view.right.xyz + corner.y * view.up.xyz);
    return Vertex(view.clip_from_world * vec4f(x, 1.0), corner, point.w);
}

// Colour of matplotlib's map inferno, by a polynomial fit of degree 6 (Zucker 2021, CC0); sRGB.
fn inferno(t: f32) -> vec3f {
    let c0 = vec3f(0.0002189403691192265, 0.001651004631001012, -0.01948089843709184);
    let c1 = vec3f(0.1065134194856116, 0.5639564367884091, 3.932712388889277);
    let c2 = vec3f(11.60249308247187, -3.972853965665698, -15.9423941062914);
    let c3 = vec3f(-41.70399613139459, 17.43639888205313, 44.35414519872813);
    let c4 = vec3f(77.162935699427, -33.40235894210092, -81.80730925738993);
    let c5 = vec3f(-71.31942824499214, 32.62606426397723, 73.20951985803202);
    let c6 = vec3f(25.13112622477341, -12.24266895238567, -23.07032500287172);
    return c0 + t * (c1 + t * (c2 + t * (c3 + t * (c4 + t * (c5 + t * c6)))));
}

@fragment
fn fragment(in: Vertex) -> @location(0) vec4f {
    let value = clamp(in.value, 0.0, 1.0);
    let soft = max(1.0 - dot(in.at, in.at), 0.0);
    // Only the middle of the map is used, purple to orange: it stands out from a light wall.
    let colour = clamp(inferno(0.25 + 0.5 * value), vec3f(0.0), vec3f(1.0));
    return vec4f(pow(colour, vec3f(2.2)), 0.8 * soft * soft * value);
}
