//! Quantities of the method that engine and reference both take from here, so that no comparison of the two checks
//! them: bounds of rest, by a strand's stiffness and weight. `tests/strands.rs` does, by formulas.

use crate::{
    scene::SceneValues,
    strands::{End, Strands},
};

/// Error that a strand may have while it is left alone, from each cause \[lengths of the strand\].
const OFF: f64 = 5e-5;
/// Least time for which a strand must rest before it is put to sleep \[s\].
const STILL: f64 = 0.07;
/// Time for which a strand must rest where nothing brings it back to where it was \[s\].
const NEVER: f64 = 1e6;
/// Least way that a point may go while its strand is at rest \[lengths of the strand\]: f32 lets strands tremble by up
/// to 1e-6, where nothing brakes them.
const TREMBLE: f64 = 2e-6;
/// 2 (1 + √2)², of the longest time that a swing keeps near a turning point: see [`Strands::rest`].
const SWUNG: f64 = 11.657;
/// Rate at which air may brake hair, beside `rods.damping` \[1/s\]: at the speeds of a strand at rest it is small,
/// since `rods/drag` goes with u^(1/3).
const BRAKE: f64 = 2.0;

/// Bounds below which a strand may be left alone: how little it moves in how long a time, and how little it is pushed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rest {
    /// Farthest that a point of it goes \[m\].
    pub way: f64,
    /// Time in which no point goes farther \[s\].
    pub time: f64,
    /// Largest acceleration that pushes it \[m/s²\].
    pub acceleration: f64,
}

impl Strands {
    /// Bounds of rest for strand `s`: a push that bends it, or the rest of a way that it creeps, stay below 1e-4 of its
    /// length.
    ///
    /// The strand's slowest mode has ω² = 12.36 EI/(ρA L⁴) by its stiffness where the root is clamped (Euler-Bernoulli
    /// beam) and
    /// 1.446 g/L where it hangs (hanging chain).
    #[must_use]
    pub fn rest(&self, s: usize, scene: &SceneValues) -> Rest {
        let segments = self.segments(s);
        let length: f64 = self.rest_length[segments.clone()].iter().sum();
        let mass: f64 = self.inverse_mass[self.points(s)].iter().filter(|w| **w > 0.0).map(|w| 1.0 / w).sum();
        // EI of the joint between two segments, whose compliance is l/(4 EI).
        let bend = |k: usize| {
            let joint = 0.5 * (self.rest_length[k - 1] + self.rest_length[k]);
            let loosest = self.bend_compliance[k].x.max(self.bend_compliance[k].y);
            if loosest > 0.0 { joint / (4.0 * loosest) } else { f64::INFINITY }
        };
        let stiffness = segments.skip(1).map(bend).fold(f64::INFINITY, f64::min);
        let clamped = self.ends(s).root == End::Clamped && stiffness.is_finite() && mass > 0.0;
        let lightest = self.points(s).map(|i| self.weight(i)).fold(1.0, f64::min);
        let gravity = lightest * scene.gravity.iter().map(|g| g * g).sum::<f64>().sqrt();
        let of_weight = 1.446 * gravity / length;
        let square = if clamped { of_weight.max(12.36 * stiffness / (mass * length.powi(3))) } else { of_weight };
        let rate = square / (square.sqrt() + scene.rods.damping + BRAKE);
        // Least part of its distance from rest that a strand goes in so long a time: a creeping strand, and a swinging
        // one, about a turning point, in (1 + √2) √(2 way/(off ω²)).
        let gone = |time: f64| (rate * time).min(square * time * time / SWUNG).min(1.0);
        let least = TREMBLE / OFF;
        let time = STILL.max(least / rate).max((SWUNG * least / square).sqrt()).min(NEVER);
        Rest {
            way: length * OFF * gone(time),
            time,
            // The first mode takes 1.57 of a uniform push.
            acceleration: length * OFF * square / 1.57,
        }
    }
}
