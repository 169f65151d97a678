// Share of the root's width, `t` of the length from the root.
fn taper(t: f32) -> f32 {
    return 1.0 - 0.25 * t - 0.75 * t * t * t * t;
}
