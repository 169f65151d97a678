// Averages all samples of the FINE x FINE drawn pixels that make a pixel of the picture, in linear light.
import package::pictures::common::FINE;

@group(0) @binding(0) var drawn: texture_multisampled_2d<f32>;

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(vec2f(f32(index & 1u), f32(index >> 1u)) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn fragment(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let samples = textureNumSamples(drawn);
    var sum = vec4f(0.0);
    for (var k = 0u; k < FINE * FINE; k++) {
        let pixel = FINE * vec2u(position.xy) + vec2u(k % FINE, k / FINE);
        for (var sample = 0u; sample < samples; sample++) {
            sum += textureLoad(drawn, pixel, sample);
        }
    }
    return sum / f32(FINE * FINE * samples);
}
