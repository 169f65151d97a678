//! A clamped hair at rest in a steady wind: the planar elastica under drag and weight, by shooting from the tip.
//!
//! ```text
//! EI φ'' = −F · (cos φ, sin φ),  F' = −(drag(φ) + weight)      φ from the vertical, s along the hair, F on what is beyond s
//! φ = 0 at the clamp,  φ' = 0 and F = 0 at the tip
//! ```
//!
//! The drag on a metre of fibre is the law of `rods/drag`, with the speed across it that the angle leaves. No particles
//! and no steps of time: the solution is a curve, integrated with Runge and Kutta's fourth order.

use std::f64::consts::{FRAC_PI_2, PI};

/// Runge-Kutta steps along the hair.
const PARTS: usize = 1000;

/// A hair whose clamp points straight down, in a wind that blows horizontally.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hair {
    /// Radius of its round cross-section \[m\].
    pub radius: f64,
    /// Young's modulus \[Pa\].
    pub youngs_modulus: f64,
    /// Density of its material \[kg/m³\].
    pub density: f64,
    /// Length \[m\].
    pub length: f64,
    /// Gravity, downward \[m/s²\].
    pub gravity: f64,
    /// Speed of the wind \[m/s\].
    pub wind: f64,
    /// Kinematic viscosity of the air \[m²/s\].
    pub viscosity: f64,
}

/// The hair of part (b) of `hair_in_wind.csv`, 50 mm in 3 m/s.
pub const REAL: Hair = Hair {
    radius: 4e-5,
    youngs_modulus: 4e9,
    density: 1320.0,
    length: 0.05,
    gravity: 9.81,
    wind: 3.0,
    viscosity: 1.5e-5,
};
/// Density of the air \[kg/m³\].
const AIR: f64 = 1.29;

/// φ, φ', the force on what is beyond \[N\] and the way from the tip \[m\]: downwind and up.
type Along = [f64; 6];

impl Hair {
    /// A hair of [`REAL`]'s size without weight, in air so thin that its drag is quadratic (C_d = 1, no skin friction):
    /// it depends on one number, the Cauchy number ½ρ C_d 2r U² L³/EI.
    #[must_use]
    pub fn with_cauchy_number(cauchy: f64) -> Self {
        let hair = Self { gravity: 0.0, viscosity: 1e-13, ..REAL };
        let load = 0.5 * AIR * 2.0 * hair.radius * hair.wind.powi(2) * hair.length.powi(3);
        Self { youngs_modulus: hair.youngs_modulus * load / (cauchy * hair.bend_stiffness()), ..hair }
    }

    /// EI \[N m²\].
    #[must_use]
    pub fn bend_stiffness(&self) -> f64 {
        self.youngs_modulus * PI * self.radius.powi(4) / 4.0
    }

    /// Weight of a metre \[N/m\].
    #[must_use]
    pub fn weight(&self) -> f64 {
        self.density * PI * self.radius.powi(2) * self.gravity
    }

    /// Drag on a metre of it where it stands `angle` from the vertical \[N/m\]: downwind and up.
    #[must_use]
    pub fn drag(&self, angle: f64) -> [f64; 2] {
        let width = 2.0 * self.radius;
        let (across, along) = (self.wind * angle.cos(), self.wind * angle.sin());
        let reynolds = (across.abs() * width / self.viscosity).max(1e-30);
        let normal = 0.5 * AIR * width * (1.0 + 10.0 * reynolds.powf(-2.0 / 3.0)) * across.abs() * across;
        let friction = 0.5 * AIR * width * 5.4 * (self.viscosity * across.abs() / width).sqrt() * along;
        // t = (sin φ, −cos φ); normal to it (cos φ, sin φ).
        [normal * angle.cos() + friction * angle.sin(), normal * angle.sin() - friction * angle.cos()]
    }

    /// Derivatives d/ds of all that is followed along the hair.
    fn slope(&self, y: &Along) -> Along {
        let (sin, cos) = y[0].sin_cos();
        let drag = self.drag(y[0]);
        [y[1], -(y[2] * cos + y[3] * sin) / self.bend_stiffness(), -drag[0], -(drag[1] - self.weight()), sin, -cos]
    }

    /// States along the hair, from a tip at `angle` back to the root, tip first.
    fn shoot(&self, angle: f64) -> Vec<Along> {
        let h = -self.length / PARTS as f64;
        let mut all = vec![[angle, 0.0, 0.0, 0.0, 0.0, 0.0]];
        let ahead = |y: &Along, k: &Along, part: f64| std::array::from_fn(|i| y[i] + part * k[i]);
        let mut y = all[0];
        for _ in 0..PARTS {
            let a = self.slope(&y);
            let b = self.slope(&ahead(&y, &a, 0.5 * h));
            let c = self.slope(&ahead(&y, &b, 0.5 * h));
            let d = self.slope(&ahead(&y, &c, h));
            y = std::array::from_fn(|i| y[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
            all.push(y);
        }
        all
    }

    /// The solution, tip first: that angle of the tip whose hair is upright at the clamp. From a smaller one the hair
    /// is upright before the clamp, and what becomes of it from there on means nothing.
    fn solved(&self) -> Vec<Along> {
        let (mut low, mut high) = (0.0, FRAC_PI_2);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if self.shoot(middle).iter().any(|y| y[0] < 0.0) { low = middle } else { high = middle }
        }
        self.shoot(0.5 * (low + high))
    }

    /// Points of the hair from root to tip, measured from the root and over L: downwind and down.
    #[must_use]
    pub fn shape(&self) -> Vec<[f64; 2]> {
        let solved = self.solved();
        let root = solved[PARTS];
        solved.iter().rev().map(|y| [(y[4] - root[4]) / self.length, (root[5] - y[5]) / self.length]).collect()
    }

    /// Where the tip is, from the root and over L: downwind and down.
    #[must_use]
    pub fn tip(&self) -> [f64; 2] {
        self.shape()[PARTS]
    }

    /// Drag of the wind on the whole hair, downwind \[N\].
    #[must_use]
    pub fn force(&self) -> f64 {
        self.solved()[PARTS][2]
    }

    /// R: its drag over that of the same hair if it did not bend.
    #[must_use]
    pub fn reconfiguration(&self) -> f64 {
        self.force() / (self.length * self.drag(0.0)[0])
    }

    /// Angle from the vertical at which a hair of no stiffness hangs straight \[rad\]: drag across it = weight across
    /// it.
    #[must_use]
    pub fn limp_angle(&self) -> f64 {
        let (mut low, mut high) = (0.0_f64, FRAC_PI_2);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            let drag = self.drag(middle);
            let across = drag[0] * middle.cos() + (drag[1] - self.weight()) * middle.sin();
            if across > 0.0 { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    }
}
