// Width of a drawn hair as a share of its width at the root; `t` is the place along it, 0 at the root and 1 at the tip.
fn taper(t: f32) -> f32 {
    return 1.0 - 0.25 * t - 0.75 * t * t * t * t;
}
