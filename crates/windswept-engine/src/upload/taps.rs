//! The taps that smooth the band filter's grid (`shaders/turbulence/smooth_x.wgsl`).

use std::f64::consts::TAU;

use windswept_scene::CheckedTurbulence;
use windswept_shaders::common::smoothing::ROW;

/// Two taps in a row: of the Gaussian, and of its second derivative \[1/m²\].
pub(crate) type Taps = [f32; 4];

/// Parameters of Mitchell & Netravali's cubic (`MITCHELL` in `shaders/common/mesh.wgsl`).
const B: f64 = 1.2;
const C: f64 = -0.11;

/// Transform of the window: the part that it leaves of a wave of wave number k, in radians per node spacing.
fn kept(k: f64) -> f64 {
    let sinc = |x: f64| if x == 0.0 { 1.0 } else { x.sin() / x };
    let half = 0.5 * k;
    if k == 0.0 {
        return 1.0;
    }
    let spline = sinc(half).powi(4);
    // The transform of their piecewise cubic, which is linear in B and C.
    let [once, twice, four] = [1.0, 2.0, 4.0].map(|times| sinc(times * half));
    let cardinal = 3.0 * (once * once - twice) / (half * half);
    let keys = 2.0 * (four + 2.0 * twice - 3.0 * twice * twice) / (half * half);
    B * spline + (1.0 - B) * cardinal + C * keys
}

/// Taps of the Gaussian of width s and of its second derivative along a periodic axis of `nodes` nodes. The blur of
/// deposit and gather is taken out: ĝ = e^(−k²s²/2)/Ŵ², ĝ'' = −k² ĝ, Ŵ being what the window leaves of a wave.
///
/// Of all taps that reach as far they are those that come nearest to ĝ and ĝ'' in the sum of squares over the waves of
/// the axis, each weighted by Ŵ. A uniform flow keeps its size, and has no curvature.
///
/// Returns the offset of the first tap with them. The zeros at the end are for the row of nodes that a pass makes at
/// once.
pub(crate) fn taps(nodes: usize, spacing: f64, scale: f64) -> (i32, Vec<Taps>) {
    let high = CheckedTurbulence::reach(spacing / scale).min(nodes / 2);
    let (low, high) = (high.min((nodes - 1) / 2) as i32, high as i32);
    let wave = |m: usize| TAU * m as f64 / nodes as f64;
    let mut fit = Fit::new(high as usize);
    for m in 1..=nodes / 2 {
        let k = wave(m);
        let weight = kept(k);
        let gauss = (-0.5 * (k * scale / spacing).powi(2)).exp() / (weight * weight);
        // Contribution of both taps at this distance to the wave, the middle tap being 1 or 0 less all others.
        let given = |n: usize| if 2 * n == nodes { 1.0 } else { 2.0 } * (wave(m * n % nodes).cos() - 1.0);
        fit.add((1..=high as usize).map(given), [gauss - 1.0, -(k / spacing).powi(2) * gauss], weight * weight);
    }
    let mut half = vec![[1.0, 0.0]];
    half.extend(fit.solved());
    for n in (-low..=high).filter(|n| *n != 0) {
        let [gauss, curve] = half[n.unsigned_abs() as usize];
        half[0] = [half[0][0] - gauss, half[0][1] - curve];
    }
    let tap = |n: i32| if n <= high { half[n.unsigned_abs() as usize].map(|x| x as f32) } else { [0.0; 2] };
    let two = |n: i32| [tap(n), tap(n + 1)].as_flattened().try_into().unwrap_or_default();
    (-low, (-low..high + ROW).step_by(2).map(two).collect())
}

/// A least-squares fit of two quantities by as many unknowns each: its normal equations.
struct Fit {
    /// Rows of the matrix, which is symmetric.
    matrix: Vec<Vec<f64>>,
    right: Vec<[f64; 2]>,
}

impl Fit {
    fn new(unknowns: usize) -> Self {
        Self { matrix: vec![vec![0.0; unknowns]; unknowns], right: vec![[0.0; 2]; unknowns] }
    }

    /// Adds that the unknowns times `factors` are `wanted`.
    fn add(&mut self, factors: impl Iterator<Item = f64>, wanted: [f64; 2], weight: f64) {
        let factors: Vec<f64> = factors.collect();
        for (i, factor) in factors.iter().enumerate() {
            let times = weight * factor;
            self.matrix[i].iter_mut().zip(&factors).for_each(|(entry, other)| *entry += times * other);
            self.right[i] = [self.right[i][0] + times * wanted[0], self.right[i][1] + times * wanted[1]];
        }
    }

    /// The unknowns, by elimination: a matrix of normal equations needs no other order of its rows.
    fn solved(mut self) -> Vec<[f64; 2]> {
        let count = self.right.len();
        for i in 0..count {
            for j in i + 1..count {
                let factor = self.matrix[j][i] / self.matrix[i][i];
                for k in i..count {
                    self.matrix[j][k] -= factor * self.matrix[i][k];
                }
                self.right[j] = [0, 1].map(|q| self.right[j][q] - factor * self.right[i][q]);
            }
        }
        for i in (0..count).rev() {
            let known = |q: usize| (i + 1..count).map(|k| self.matrix[i][k] * self.right[k][q]).sum::<f64>();
            self.right[i] = [0, 1].map(|q| (self.right[i][q] - known(q)) / self.matrix[i][i]);
        }
        self.right
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Transform of the polynomial of the window that shaders evaluate: the integral of the window times the
    /// wave.
    #[test]
    fn the_window_leaves_of_a_wave_what_it_should() {
        // Factors of 1 - x, (1 - x)², (1 - x)³ beyond the last node but one and before it, as in `window_of`.
        let cubic = |[a, b, c]: [f64; 3], x: f64| x * (a + x * (b + x * c));
        let window = |t: f64| {
            let x = (2.0 - t.abs()).max(0.0);
            cubic([0.0, 0.11, 0.09], x) + cubic([0.0, -0.16, -0.4], (x - 1.0).max(0.0))
        };
        for k in [0.05, 0.7, 1.9, 3.1] {
            let count = 60_000;
            let step = 4.0 / f64::from(count);
            let sum: f64 =
                (0..count).map(|i| step * (f64::from(i) + 0.5) - 2.0).map(|t| window(t) * (k * t).cos()).sum();
            let off = sum * step - kept(k);
            assert!(off.abs() < 1e-8, "at {k}: {off:e}");
        }
    }

    /// Taps never meet their own image, sum to 1 and to 0, and leave a wave the gain that deposit and gather do not.
    #[test]
    fn taps_are_those_of_a_periodic_gaussian() {
        let spacing = 0.0033;
        let cases = [
            (4, 0.02, 1e-6),
            (5, 0.02, 1e-6),
            (24, 0.006, 1e-4),
            (24, 0.0051, 1e-4),
            (25, 0.018, 1e-4),
            (200, 0.006, 1e-4),
            (200, 0.0051, 1e-4),
        ];
        for (nodes, scale, bound) in cases {
            let (nearest, pairs) = taps(nodes, spacing, scale);
            let all: Vec<[f32; 2]> = pairs.iter().flat_map(|&[a, b, c, d]| [[a, b], [c, d]]).collect();
            let own = &all[..all.iter().rposition(|tap| *tap != [0.0; 2]).unwrap() + 1];
            assert!(all.len() >= own.len() + 3, "no zeros for the other nodes of a row");
            assert!(own.len() <= nodes && nearest <= 0 && -nearest < nodes as i32, "{nodes}: {} taps", own.len());
            let gain = |m: usize, i: usize| -> f64 {
                let wave = |n: usize| (TAU * m as f64 * (f64::from(nearest) + n as f64) / nodes as f64).cos();
                own.iter().enumerate().map(|(n, tap)| f64::from(tap[i]) * wave(n)).sum()
            };
            let largest = own.iter().map(|tap| f64::from(tap[1].abs())).fold(0.0, f64::max);
            assert!((gain(0, 0) - 1.0).abs() < 1e-6 && gain(0, 1).abs() < 1e-6 * largest);
            let mut worst = 0.0_f64;
            for m in 1..=nodes / 2 {
                let k = TAU * m as f64 / (nodes as f64 * spacing);
                // Deposit and gather have left that of the wave.
                let kept = kept(k * spacing).powi(2);
                let wanted = (-0.5 * (k * scale).powi(2)).exp();
                let off = [kept * gain(m, 0) - wanted, (kept * gain(m, 1) + k * k * wanted) * scale * scale];
                worst = off.iter().fold(worst, |worst, off| worst.max(off.abs()));
            }
            println!("{nodes} nodes, {} taps: {worst:.1e}", own.len());
            assert!(worst < bound, "{nodes} nodes: {worst:.1e}");
        }
    }
}
