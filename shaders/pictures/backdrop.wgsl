// Colour of a plain wall that is lit from above and lighter behind the hair, in linear rgb. `at` is (0, 0) in the upper
// right corner of the picture and (1, 1) in the lower left.
fn backdrop(at: vec2f) -> vec3f {
    let low = vec3f(0.62, 0.65, 0.68);
    let high = vec3f(0.33, 0.40, 0.48);
    let glow = exp(-4.0 * dot(at - 0.5, at - 0.5));
    return mix(high, low, smoothstep(0.0, 1.0, at.y)) * (0.72 + 0.38 * glow);
}
