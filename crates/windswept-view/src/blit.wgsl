// A texture over the whole viewport.

@group(0) @binding(0) var picture: texture_2d<f32>;

struct Vertex {
    @builtin(position) at: vec4f,
    @location(0)       uv: vec2f,   // 0 to 1 over the viewport, from above
}

// One triangle, twice as large as the viewport along both sides.
@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Vertex {
    let uv = vec2f(f32(index & 1u), f32(index >> 1u)) * 2.0;
    return Vertex(vec4f(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y, 0.0, 1.0), uv);
}

@fragment
fn fragment(in: Vertex) -> @location(0) vec4f {
    return textureLoad(picture, vec2u(in.uv * vec2f(textureDimensions(picture))), 0);
}
