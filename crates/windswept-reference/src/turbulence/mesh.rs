//! The band filter by way of a grid, its smoothing done wave by wave.

use std::{
    f64::consts::{E, TAU},
    ops::{Add, Mul, Sub},
};

use glam::{DVec3, DVec4};
use windswept_scene::{Band, CheckedTurbulence};

use crate::{Parameters, parallel};

/// Values at the nodes of the periodic grid: xyz of what particles carry, w of their volume; x runs first.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mesh {
    /// Number of nodes along each axis.
    pub nodes: [usize; 3],
    /// Value of each node.
    pub values: Vec<DVec4>,
}

impl Mesh {
    /// Empty grid for a band of `scale` \[m\].
    fn of_scale(p: &Parameters, scale: f64) -> Self {
        let nodes = p.turbulence.nodes(scale, p.kernel_radius, p.box_size).map(|n| n as usize);
        Self { nodes, values: vec![DVec4::ZERO; nodes.iter().product()] }
    }

    /// Distance between nodes \[m\].
    fn spacing(&self, p: &Parameters) -> DVec3 {
        p.box_size / DVec3::from_array(self.nodes.map(|n| n as f64))
    }

    /// Nodes near a position, and their weights, the product of a window per axis.
    fn stencil(&self, p: &Parameters, x: DVec3) -> Vec<(usize, f64)> {
        let at = x / self.spacing(p);
        let axis = |axis: usize| -> Vec<(usize, f64)> {
            let near = nodes_near(at[axis], self.nodes[axis]);
            near.map(|(node, gap)| (node, window(gap))).filter(|(_, weight)| *weight > 0.0).collect()
        };
        let [along_x, along_y, along_z] = [axis(0), axis(1), axis(2)];
        let mut all = Vec::new();
        for &(k, z) in &along_z {
            for &(j, y) in &along_y {
                all.extend(along_x.iter().map(|&(i, x)| (i + self.nodes[0] * (j + self.nodes[1] * k), x * y * z)));
            }
        }
        all
    }
}

/// Nodes of a periodic axis of `count` whose B-splines reach the place `at`, and the way from each to there \[node
/// spacings\].
pub(crate) fn spline_nodes(degree: u32, at: f64, count: usize) -> Vec<(usize, f64)> {
    nodes_near(at, count).filter(|(_, gap)| b_spline(degree, *gap) > 0.0).collect()
}

/// Nodes of a periodic axis of `count` within two spacings of the place `at`, and the way from each to there \[node
/// spacings\].
fn nodes_near(at: f64, count: usize) -> impl Iterator<Item = (usize, f64)> {
    let first = at.floor() as i64 - 2;
    (first..first + 6).map(move |n| (n.rem_euclid(count as i64) as usize, at - n as f64))
}

/// Parameters B and C of the window.
const MITCHELL: [f64; 2] = [1.2, -0.11];

/// Window of the grid filter at t spacings: the cubic that Mitchell & Netravali (1988) print as eq. 8.
#[must_use]
pub fn window(t: f64) -> f64 {
    let ([b, c], x) = (MITCHELL, t.abs());
    let sixfold = if x < 1.0 {
        (12.0 - 9.0 * b - 6.0 * c) * x.powi(3) + (-18.0 + 12.0 * b + 6.0 * c) * x.powi(2) + 6.0 - 2.0 * b
    } else if x < 2.0 {
        (-b - 6.0 * c) * x.powi(3) + (6.0 * b + 30.0 * c) * x.powi(2) + (-12.0 * b - 48.0 * c) * x + 8.0 * b + 24.0 * c
    } else {
        0.0
    };
    sixfold / 6.0
}

/// Intervals by which the transform of a window is summed, on each side of its middle.
const INTERVALS: i32 = 256;

/// Part of a wave of wave number k, in radians per node spacing, that the window leaves: the window's Fourier
/// transform, by Simpson's rule.
fn kept(k: f64) -> f64 {
    // Pieces of the polynomial end at ends of intervals.
    let step = 2.0 / f64::from(INTERVALS);
    let part = |i: i32| window(step * f64::from(i)) * (k * step * f64::from(i)).cos();
    let inner: f64 = (1..INTERVALS).map(|i| if i % 2 == 1 { 4.0 * part(i) } else { 2.0 * part(i) }).sum();
    2.0 * step / 3.0 * (part(0) + inner + part(INTERVALS))
}

/// Central B-spline of a degree at t spacings, by its recurrence (de Boor): the box of width 1, smoothed that often.
#[must_use]
pub fn b_spline(degree: u32, t: f64) -> f64 {
    if degree == 0 {
        return if (-0.5..0.5).contains(&t) { 1.0 } else { 0.0 };
    }
    let (p, half) = (f64::from(degree), 0.5 * f64::from(degree + 1));
    ((t + half) * b_spline(degree - 1, t + 0.5) + (half - t) * b_spline(degree - 1, t - 0.5)) / p
}

/// Deposit Σ_j V_j (v_j − U) B(x_j − node) of air \[m⁴/s\], with w = Σ_j V_j B \[m³\], on the grid of a band of `scale`
/// \[m\].
#[must_use]
pub fn deposit(p: &Parameters, scale: f64, wind: DVec3, x: &[DVec3], v: &[DVec3], volume: &[f64]) -> Mesh {
    let mut mesh = Mesh::of_scale(p, scale);
    for j in p.hair_points..x.len() {
        let carried = volume[j] * (v[j] - wind).extend(1.0);
        for (node, weight) in mesh.stencil(p, x[j]) {
            mesh.values[node] += weight * carried;
        }
    }
    mesh
}

/// Laplacian of what was deposited, smoothed by a Gaussian of width `scale` \[m\]; w is the smoothed volume itself.
#[must_use]
pub fn smooth(p: &Parameters, scale: f64, mesh: &Mesh) -> Mesh {
    let [smoothed, curved] = smooth_along(p, scale, mesh, 3);
    let values = smoothed.values.iter().zip(&curved.values);
    Mesh { nodes: mesh.nodes, values: values.map(|(smoothed, curved)| curved.truncate().extend(smoothed.w)).collect() }
}

/// The deposited values after smoothing along the first `axes` axes, and their second derivatives along them, summed.
///
/// The factors of a wave along an axis are those of the least-squares fit in `response`.
#[must_use]
pub fn smooth_along(p: &Parameters, scale: f64, mesh: &Mesh, axes: usize) -> [Mesh; 2] {
    let spacing = mesh.spacing(p);
    let factors: Vec<Vec<[f64; 2]>> = (0..axes).map(|axis| response(mesh.nodes[axis], spacing[axis], scale)).collect();
    let mut waves: Vec<[DVec4; 2]> = mesh.values.iter().map(|value| [*value, DVec4::ZERO]).collect();
    for axis in 0..axes {
        waves = transformed(mesh.nodes, &waves, axis, -1.0);
    }
    let mut curved = waves.clone();
    for ((wave, curved), place) in waves.iter_mut().zip(&mut curved).zip(places(mesh.nodes)) {
        let mut gain = 1.0;
        let mut bent = 0.0;
        for axis in 0..axes {
            let (m, n) = (place[axis], mesh.nodes[axis]);
            let [gauss, curve] = factors[axis][m.min(n - m)];
            (gain, bent) = (gain * gauss, bent * gauss + gain * curve);
        }
        *curved = wave.map(|part| part * bent);
        *wave = wave.map(|part| part * gain);
    }
    [waves, curved].map(|mut waves| {
        let mut count = 1.0;
        for axis in 0..axes {
            waves = transformed(mesh.nodes, &waves, axis, 1.0);
            count *= mesh.nodes[axis] as f64;
        }
        Mesh { nodes: mesh.nodes, values: waves.into_iter().map(|[real, _]| real / count).collect() }
    })
}

/// Factors of the waves m = 0 to n/2 along an axis of n nodes, by smoothing and by its second derivative \[1/m²\].
///
/// Wanted are ĝ = e^(−k²s²/2)/Ŵ², which takes out what deposit and gather blur, and −k² ĝ. Taps that reach R nodes give
/// 1 or 0 for m = 0 plus a sum over n = 1 to R of cosines less 1. Here is the part of what is wanted that such sums can
/// be: its projection, with Ŵ² for a weight, onto those functions of m, made orthogonal one after another (Gram and
/// Schmidt).
fn response(nodes: usize, spacing: f64, scale: f64) -> Vec<[f64; 2]> {
    let reach = CheckedTurbulence::reach(spacing / scale).min(nodes / 2);
    let turns = |m: usize| TAU * m as f64 / nodes as f64;
    let waves = 1..=nodes / 2;
    let kept: Vec<f64> = waves.clone().map(|m| kept(turns(m))).collect();
    let product = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).zip(&kept).map(|((a, b), w)| w * w * a * b).sum() };
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for n in 1..=reach {
        let mut function: Vec<f64> = waves.clone().map(|m| (turns(m * n % nodes)).cos() - 1.0).collect();
        // Twice: the first time leaves what rounding does.
        for other in basis.iter().chain(&basis) {
            let along = product(&function, other);
            function.iter_mut().zip(other).for_each(|(value, other)| *value -= along * other);
        }
        let length = product(&function, &function).sqrt();
        function.iter_mut().for_each(|value| *value /= length);
        basis.push(function);
    }
    let projected = |wanted: &dyn Fn(f64, f64) -> f64| -> Vec<f64> {
        let wanted: Vec<f64> = waves.clone().zip(&kept).map(|(m, kept)| wanted(turns(m) / spacing, *kept)).collect();
        let mut sum = vec![0.0; wanted.len()];
        for function in &basis {
            let along = product(&wanted, function);
            sum.iter_mut().zip(function).for_each(|(sum, value)| *sum += along * value);
        }
        sum
    };
    let gauss = |k: f64, kept: f64| (-0.5 * (k * scale).powi(2)).exp() / (kept * kept);
    let smoothed = projected(&|k, kept| gauss(k, kept) - 1.0);
    let curved = projected(&|k, kept| -k * k * gauss(k, kept));
    let others = smoothed.into_iter().zip(curved).map(|(smoothed, curved)| [1.0 + smoothed, curved]);
    std::iter::once([1.0, 0.0]).chain(others).collect()
}

/// Place of each node along the axes, in the order of the values.
pub(crate) fn places(nodes: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    let [nx, ny, nz] = nodes;
    (0..nx * ny * nz).map(move |index| [index % nx, index / nx % ny, index / nx / ny])
}

/// Discrete Fourier transform along an axis, `sign` −1 forth and 1 back (not divided by n): real and imaginary parts.
pub(crate) fn transformed<T>(nodes: [usize; 3], values: &[[T; 2]], axis: usize, sign: f64) -> Vec<[T; 2]>
where
    T: Copy + Default + Send + Sync + Add<Output = T> + Sub<Output = T> + Mul<f64, Output = T>,
{
    let n = nodes[axis];
    let stride: usize = nodes[..axis].iter().product();
    let turns: Vec<(f64, f64)> = (0..n).map(|i| (TAU * i as f64 / n as f64).sin_cos()).collect();
    parallel::map(values.len(), |index| {
        let m = index / stride % n;
        let line = index - m * stride;
        (0..n).fold([T::default(); 2], |[real, imaginary], i| {
            let ([a, b], (sin, cos)) = (values[line + i * stride], turns[m * i % n]);
            [real + a * cos - b * (sign * sin), imaginary + b * cos + a * (sign * sin)]
        })
    })
}

/// Velocity û of each air particle \[m/s\] from what [`smooth`] returns: −(e/2) s² of the Laplacian, per volume of a
/// cell.
#[must_use]
pub fn gather(p: &Parameters, band: &Band, laplacian: &Mesh, x: &[DVec3]) -> Vec<DVec3> {
    let cell = laplacian.spacing(p).element_product();
    let at = |i: usize| {
        if !p.is_air(i) {
            return DVec3::ZERO;
        }
        let stencil = laplacian.stencil(p, x[i]);
        let sum: DVec4 = stencil.into_iter().map(|(node, weight)| weight * laplacian.values[node]).sum();
        -0.5 * E * band.scale.powi(2) * sum.truncate() / cell
    };
    (0..x.len()).map(at).collect()
}
