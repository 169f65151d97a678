//! The band filter by way of a grid, its smoothing done wave by wave.

use std::{
    f64::consts::{E, TAU},
    ops::{Add, Mul, Sub},
};

use glam::{DVec3, DVec4};
use windswept_scene::Band;

use crate::{Parameters, parallel};

/// Values at the nodes of the periodic grid: xyz of what particles carry, w of their volume; x runs first.
#[derive(Debug, Clone, PartialEq)]
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

    /// Nodes near a position, and their weights, the product of a B-spline per axis.
    fn stencil(&self, p: &Parameters, x: DVec3) -> Vec<(usize, f64)> {
        let degree = p.turbulence.order.degree();
        let at = x / self.spacing(p);
        let axis = |axis: usize| -> Vec<(usize, f64)> {
            let near = spline_nodes(degree, at[axis], self.nodes[axis]);
            near.into_iter().map(|(node, gap)| (node, b_spline(degree, gap))).collect()
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

/// Nodes of a periodic axis of `count` whose B-splines reach the place `at`, and the way from each to there \[node spacings\].
pub(crate) fn spline_nodes(degree: u32, at: f64, count: usize) -> Vec<(usize, f64)> {
    let first = at.floor() as i64 - 2;
    let near = (first..first + 6).map(|n| (n.rem_euclid(count as i64) as usize, at - n as f64));
    near.filter(|(_, gap)| b_spline(degree, *gap) > 0.0).collect()
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

/// What was deposited after smoothing along the first `axes` axes, and its second derivatives along them, summed.
///
/// The factor of a wave is e^(−k²s²/2) over what deposit and gather blur it by, sinc(k_a h_a/2)^(p+1) along each axis, twice.
#[must_use]
pub fn smooth_along(p: &Parameters, scale: f64, mesh: &Mesh, axes: usize) -> [Mesh; 2] {
    let spacing = mesh.spacing(p);
    let blur = 2 * (p.turbulence.order.degree() as i32 + 1);
    let mut waves: Vec<[DVec4; 2]> = mesh.values.iter().map(|value| [*value, DVec4::ZERO]).collect();
    for axis in 0..axes {
        waves = transformed(mesh.nodes, &waves, axis, -1.0);
    }
    let mut curved = waves.clone();
    for ((wave, curved), place) in waves.iter_mut().zip(&mut curved).zip(places(mesh.nodes)) {
        let mut gain = 1.0;
        let mut squared = 0.0;
        for axis in 0..axes {
            let (m, n) = (place[axis] as f64, mesh.nodes[axis] as f64);
            let k = TAU * if 2.0 * m > n { m - n } else { m } / p.box_size[axis];
            let half = 0.5 * k * spacing[axis];
            let sinc = if half == 0.0 { 1.0 } else { half.sin() / half };
            gain *= (-0.5 * (k * scale).powi(2)).exp() / sinc.powi(blur);
            squared += k * k;
        }
        *wave = wave.map(|part| part * gain);
        *curved = wave.map(|part| part * -squared);
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
/// cell; normalised, over the smoothed volume instead.
#[must_use]
pub fn gather(p: &Parameters, band: &Band, laplacian: &Mesh, x: &[DVec3]) -> Vec<DVec3> {
    let cell = laplacian.spacing(p).element_product();
    let at = |i: usize| {
        if !p.is_air(i) {
            return DVec3::ZERO;
        }
        let stencil = laplacian.stencil(p, x[i]);
        let sum: DVec4 = stencil.into_iter().map(|(node, weight)| weight * laplacian.values[node]).sum();
        let volume = if p.turbulence.normalise { sum.w } else { cell };
        -0.5 * E * band.scale.powi(2) * sum.truncate() / volume
    };
    (0..x.len()).map(at).collect()
}
