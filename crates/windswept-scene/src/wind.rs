//! The mean wind, its gusts, and the eddies that it brings in.

use std::f64::consts::{E, SQRT_2, TAU};

use glam::DVec3;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;

use crate::{
    faults::At,
    limits::FASTEST_WIND,
    motion::{Motion, phase},
    scene::{CheckedAir, Gust, Inflow},
};

/// Number of waves that inflow turbulence is made of.
const WAVES: usize = 64;
/// Wave numbers of the inflow's waves, in parts of the peak's, √2/s.
const SPREAD: std::ops::Range<f64> = 0.6..1.5;

/// Gain of the band for the waves at the ends of that spread.
const MIN_GAIN: f64 = 0.64;

/// A wave of inflow turbulence: u' = |U| a sin(k · (x − ∫U dt) + φ).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InflowWave {
    /// Wave vector k \[1/m\], whole periods along each side of the box.
    pub number: DVec3,
    /// Amplitude a, across k, in parts of the wind's speed.
    pub amplitude: DVec3,
    /// Phase φ \[rad\].
    pub phase: f64,
}

impl Inflow {
    /// Waves of one amplitude for a box of `size` \[m\], drawn by `seed`, the same on every machine: the band of
    /// `scale` has the rms speed `intensity` in them, in parts of the wind's.
    fn waves(&self, seed: u64, size: DVec3) -> Vec<InflowWave> {
        let mut rng = Pcg64::seed_from_u64(seed);
        let mut wave = || {
            let direction = direction(&mut rng);
            let wanted = rng.random_range(SPREAD) * SQRT_2 / self.scale * direction;
            let periods = (wanted * size / TAU).round();
            // A box too small for the eddy has one of its own length.
            let largest = DVec3::AXES[direction
                .abs()
                .to_array()
                .iter()
                .enumerate()
                .fold(0, |best, (axis, part)| if *part > direction[best].abs() { axis } else { best })];
            let number = TAU * if periods == DVec3::ZERO { largest } else { periods } / size;
            let across = number
                .cross(self::direction(&mut rng))
                .try_normalize()
                .unwrap_or_else(|| number.any_orthonormal_vector());
            InflowWave { number, amplitude: across, phase: rng.random_range(0.0..TAU) }
        };
        let mut waves: Vec<InflowWave> = (0..WAVES).map(|_| wave()).collect();
        // Of a wave of amplitude a the band has the mean square (a gain)²/2. A box too small for the eddies has waves
        // outside the band.
        let gain = |wave: &InflowWave| hat_gain(self.scale * wave.number.length()).max(MIN_GAIN);
        let mean_square: f64 = waves.iter().map(|wave| 0.5 * gain(wave).powi(2)).sum();
        let amplitude = self.intensity / mean_square.sqrt();
        waves.iter_mut().for_each(|wave| wave.amplitude *= amplitude);
        waves
    }
}

/// Part of a wave of number k that the band of scale s keeps, of `x` = k s: the transform of the Mexican hat, 1 at its
/// peak √2.
fn hat_gain(x: f64) -> f64 {
    0.5 * E * x * x * (-0.5 * x * x).exp()
}

/// A direction, each with the same chance.
fn direction(rng: &mut Pcg64) -> DVec3 {
    let (z, turn) = (rng.random_range(-1.0_f64..1.0), rng.random_range(0.0..TAU));
    let ring = (1.0 - z * z).sqrt();
    DVec3::new(ring * turn.cos(), ring * turn.sin(), z)
}

/// Refuses the key of a wind that no air has, of this speed \[m/s\].
pub(crate) fn check_speed(at: &At<'_>, key: &str, speed: f64) {
    if speed.abs() > FASTEST_WIND {
        at.fault(key, format!("expected at most {FASTEST_WIND:e} m/s, found {:?} m/s", speed.abs()));
    }
}

/// The largest mean wind \[m/s\] of this wind with these gusts, ramp or not.
pub(crate) fn largest(wind: [f64; 3], gust: &[Gust]) -> f64 {
    let risen = DVec3::from_array(wind);
    let gusts = gust.iter().map(|gust| (risen + DVec3::from_array(gust.velocity)).length());
    let before = if gust.first().is_none_or(|gust| gust.time > 0.0) { risen.length() } else { 0.0 };
    gusts.fold(before, f64::max)
}

impl CheckedAir {
    /// Waves of the turbulence that enters with the wind, for a box of `size` \[m\]; none without it.
    #[must_use]
    pub fn inflow_waves(&self, size: DVec3) -> Vec<InflowWave> {
        self.inflow.map_or_else(Vec::new, |inflow| inflow.waves(self.seed, size))
    }

    /// Part of the wind that has risen at `time` \[s\]: 0 to 1.
    #[must_use]
    pub fn risen(&self, time: f64) -> f64 {
        if self.ramp > 0.0 { (time / self.ramp).clamp(0.0, 1.0) } else { 1.0 }
    }

    /// Mean wind at `time` \[s\], gusts included, in m/s.
    #[must_use]
    pub fn wind_at(&self, time: f64) -> [f64; 3] {
        let gust = self.gust_at(time);
        [0, 1, 2].map(|axis| self.wind[axis] * self.risen(time) + gust[axis])
    }

    /// Velocity that gusts add at `time`: linear between keyframes, held before the first and after the last
    /// \[m/s\].
    #[must_use]
    pub fn gust_at(&self, time: f64) -> [f64; 3] {
        let (before, part) = phase(&self.gust, |gust| gust.time, time);
        match self.gust.get(before..) {
            Some([a, b, ..]) => [0, 1, 2].map(|axis| a.velocity[axis] + part * (b.velocity[axis] - a.velocity[axis])),
            Some([only]) => only.velocity,
            _ => [0.0; 3],
        }
    }

    /// Times at which the mean wind changes its course \[s\], rising, and the wind there \[m/s\]: between them it is
    /// linear.
    #[must_use]
    pub fn wind_table(&self) -> Vec<(f64, [f64; 3])> {
        let mut times: Vec<f64> = self.gust.iter().map(|gust| gust.time).chain([0.0, self.ramp]).collect();
        times.sort_by(f64::total_cmp);
        times.dedup();
        times.into_iter().map(|time| (time, self.wind_at(time))).collect()
    }

    /// The largest mean wind \[m/s\], gusts included, ramp or not.
    #[must_use]
    pub fn largest_wind(&self) -> f64 {
        largest(self.wind, &self.gust)
    }

    /// Largest speed of the mean wind past a thing that moves so \[m/s\]: of any wind of the scene, and any part of the
    /// motion.
    pub(crate) fn fastest_past(&self, motion: &Motion) -> f64 {
        let winds = || self.wind_table().into_iter().map(|(_, wind)| DVec3::from_array(wind));
        let moves = motion.keyframes.windows(2).map(|pair| {
            let way = DVec3::from_array(pair[1].translation) - DVec3::from_array(pair[0].translation);
            way / (pair[1].time - pair[0].time)
        });
        // After its last keyframe it rests.
        let speeds = moves.chain([DVec3::ZERO]).flat_map(|v| winds().map(move |wind| (wind - v).length()));
        speeds.fold(0.0, f64::max)
    }

    /// Whether the wind blows at any time along an axis, in the direction of `sign`.
    pub(crate) fn blows(&self, axis: usize, sign: f64) -> bool {
        let gusts = self.gust.iter().map(|gust| self.wind[axis] + gust.velocity[axis]);
        std::iter::once(self.wind[axis]).chain(gusts).any(|wind| sign * wind > 0.0)
    }

    /// Whether no wind blows at any time. In the frame of a body one may: a caller may move the body.
    #[must_use]
    pub fn is_still(&self) -> bool {
        self.follows.is_none() && self.wind_table().iter().all(|(_, wind)| *wind == [0.0; 3])
    }

    /// Mean wind U once it has risen \[m/s\], without gusts.
    pub(crate) fn mean_wind(&self) -> DVec3 {
        DVec3::from_array(self.wind)
    }
}
