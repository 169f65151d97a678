//! A clamped hair at rest in a steady wind: the planar elastica with drag and weight along it, by shooting from the tip.
#![allow(dead_code, unreachable_pub)]

use std::f64::consts::{FRAC_PI_2, PI};

/// A hair whose clamp points straight down in a wind across: SI units.
#[derive(Debug, Clone, Copy)]
pub struct Hair {
    pub radius: f64,
    pub youngs_modulus: f64,
    pub density: f64,
    pub length: f64,
    pub gravity: f64,
    pub wind: f64,
}

/// The hair of `hair_in_wind.csv`, part (b).
pub const REAL: Hair =
    Hair { radius: 4e-5, youngs_modulus: 4e9, density: 1320.0, length: 0.05, gravity: 9.81, wind: 3.0 };
const AIR: f64 = 1.29;
const NU: f64 = 1.5e-5;
/// Runge-Kutta steps along the hair.
const PARTS: usize = 1000;

/// φ from the vertical, φ', the force on what is beyond [N] and the way to the tip [m]: downwind and up.
type Along = [f64; 6];

impl Hair {
    /// EI [N m²].
    pub fn stiffness(&self) -> f64 {
        self.youngs_modulus * PI * self.radius.powi(4) / 4.0
    }

    /// Weight of a metre [N/m].
    fn weight(&self) -> f64 {
        self.density * PI * self.radius.powi(2) * self.gravity
    }

    /// Drag on a metre of a fibre that is φ from the vertical [N/m]: downwind and up.
    fn drag(&self, angle: f64) -> [f64; 2] {
        let width = 2.0 * self.radius;
        let (across, along) = (self.wind * angle.cos(), self.wind * angle.sin());
        let reynolds = (across.abs() * width / NU).max(1e-30);
        let normal = 0.5 * AIR * width * (1.0 + 10.0 * reynolds.powf(-2.0 / 3.0)) * across.abs() * across;
        let friction = 0.5 * AIR * width * 5.4 * (NU * across.abs() / width).sqrt() * along;
        // t = (sin φ, −cos φ); normal to it (cos φ, sin φ).
        [normal * angle.cos() + friction * angle.sin(), normal * angle.sin() - friction * angle.cos()]
    }

    /// d/ds of all: EI φ'' = −F·(cos φ, sin φ), F' = −(drag + weight).
    fn slope(&self, y: &Along) -> Along {
        let (sin, cos) = y[0].sin_cos();
        let drag = self.drag(y[0]);
        [y[1], -(y[2] * cos + y[3] * sin) / self.stiffness(), -drag[0], -(drag[1] - self.weight()), sin, -cos]
    }

    /// From a tip at `angle` back to the root.
    fn shoot(&self, angle: f64) -> Along {
        let h = -self.length / PARTS as f64;
        let mut y = [angle, 0.0, 0.0, 0.0, 0.0, 0.0];
        let ahead = |y: &Along, k: &Along, part: f64| std::array::from_fn(|i| y[i] + part * k[i]);
        for _ in 0..PARTS {
            let a = self.slope(&y);
            let b = self.slope(&ahead(&y, &a, 0.5 * h));
            let c = self.slope(&ahead(&y, &b, 0.5 * h));
            let d = self.slope(&ahead(&y, &c, h));
            y = std::array::from_fn(|i| y[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
        }
        y
    }

    /// Where the tip is, from the root and over L: downwind and down.
    pub fn tip(&self) -> [f64; 2] {
        let (mut low, mut high) = (0.0, FRAC_PI_2);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if self.shoot(middle)[0] < 0.0 { low = middle } else { high = middle }
        }
        let y = self.shoot(0.5 * (low + high));
        [-y[4] / self.length, y[5] / self.length]
    }
}
