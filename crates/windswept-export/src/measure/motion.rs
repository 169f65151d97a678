//! The motion of tips over time: swing, its spectrum, coherence.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::moment::{Moment, Start};

/// Swing below this part of the strands' mean length is none: films round places to f32.
const AT_REST: f64 = 1e-6;

/// Measured motion of the tips in a window.
pub(super) struct Motion {
    /// Swing [m]: of all tips, of their mean, of tips relative to that.
    pub(super) swing: f64,
    pub(super) bundle: f64,
    pub(super) strands: f64,
    /// [Hz]
    pub(super) frequencies: Vec<f64>,
    /// [m²/Hz]
    pub(super) power: Vec<f64>,
    /// Dominant frequency [Hz].
    pub(super) peak: Option<f64>,
    pub(super) coherence: Option<f64>,
}

impl Motion {
    /// The motion across `axis` in frames that are `interval` [s] apart.
    pub(super) fn new(moments: &[Moment], axis: DVec3, interval: f64, start: &Start) -> Self {
        let (strands, frames) = (moments[0].tips.len(), moments.len());
        let (u, v) = axis.any_orthonormal_pair();
        let series = |strand: usize| about_mean(moments, |moment| sideways(moment.tips[strand].as_dvec3(), u, v));
        let mut bundle = vec![DVec2::ZERO; frames];
        let (mut all, mut spectrum) = (0.0, Spectrum::new(frames, interval));
        for strand in 0..strands {
            let tip = series(strand);
            all += squares(&tip);
            bundle.iter_mut().zip(&tip).for_each(|(sum, place)| *sum += *place / strands as f64);
            spectrum.add(&tip, strands as f64);
        }
        let relative = |strand: usize| -> Vec<DVec2> {
            series(strand).iter().zip(&bundle).map(|(tip, mean)| *tip - *mean).collect()
        };
        let within: f64 = (0..strands).map(|strand| squares(&relative(strand))).sum();
        let rms = |sum: f64, count: usize| (sum / (count * frames) as f64).sqrt();
        let swing = rms(all, strands);
        let moves = swing > AT_REST * start.length / strands as f64;
        Self {
            swing,
            bundle: rms(squares(&bundle), 1),
            strands: rms(within, strands),
            peak: moves.then(|| spectrum.peak()),
            frequencies: spectrum.frequencies(),
            power: spectrum.power,
            coherence: coherence(moments, &start.neighbours),
        }
    }
}

/// Components of a place across an axis, along the two directions of length 1.
fn sideways(place: DVec3, u: DVec3, v: DVec3) -> DVec2 {
    DVec2::new(place.dot(u), place.dot(v))
}

/// A vector in each frame, less its mean.
fn about_mean(moments: &[Moment], vector: impl Fn(&Moment) -> DVec2) -> Vec<DVec2> {
    let vectors: Vec<_> = moments.iter().map(vector).collect();
    let mean = vectors.iter().sum::<DVec2>() / vectors.len() as f64;
    vectors.into_iter().map(|vector| vector - mean).collect()
}

fn squares(vectors: &[DVec2]) -> f64 {
    vectors.iter().map(|vector| vector.length_squared()).sum()
}

/// A one-sided power spectrum under a Hann window, without the frequency 0, by the sums of its definition.
struct Spectrum {
    interval: f64,
    /// Hann window.
    window: Vec<f64>,
    /// Cosine and sine of each whole part of a period.
    waves: Vec<DVec2>,
    power: Vec<f64>,
}

impl Spectrum {
    fn new(frames: usize, interval: f64) -> Self {
        let wave = |k: usize| DVec2::from_angle(TAU * k as f64 / frames as f64);
        let waves: Vec<_> = (0..frames).map(wave).collect();
        let window = waves.iter().map(|wave| 0.5 * (1.0 - wave.x)).collect();
        Self { interval, window, waves, power: vec![0.0; frames / 2] }
    }

    /// Adds a series, one of `count` whose mean is taken.
    fn add(&mut self, series: &[DVec2], count: f64) {
        let frames = series.len();
        let seen: Vec<_> = series.iter().zip(&self.window).map(|(place, weight)| *place * *weight).collect();
        let weight = 2.0 * self.interval / (count * self.window.iter().map(|weight| weight * weight).sum::<f64>());
        for (k, power) in (1..).zip(&mut self.power) {
            let (mut real, mut imaginary) = (DVec2::ZERO, DVec2::ZERO);
            let mut at = 0;
            for place in &seen {
                real += *place * self.waves[at].x;
                imaginary += *place * self.waves[at].y;
                at = (at + k) % frames;
            }
            // Half of the sampling frequency is its own mirror.
            let sides = if 2 * k == frames { 0.5 } else { 1.0 };
            *power += sides * weight * (real.length_squared() + imaginary.length_squared());
        }
    }

    fn frequencies(&self) -> Vec<f64> {
        (1..=self.power.len()).map(|k| k as f64 * self.step()).collect()
    }

    /// From one frequency to the next [Hz].
    fn step(&self) -> f64 {
        1.0 / (self.waves.len() as f64 * self.interval)
    }

    /// Frequency of the peak [Hz], between frequencies by a parabola through logarithms.
    fn peak(&self) -> f64 {
        let power = &self.power;
        let k = (0..power.len()).max_by(|&a, &b| power[a].total_cmp(&power[b])).unwrap_or(0);
        let log = |k: usize| power.get(k).filter(|power| **power > 0.0).map(|power| power.ln());
        let around = k.checked_sub(1).and_then(log).zip(log(k)).zip(log(k + 1));
        let shift = around.map_or(0.0, |((below, peak), above)| {
            let curvature = below - 2.0 * peak + above;
            if curvature < 0.0 { 0.5 * (below - above) / curvature } else { 0.0 }
        });
        ((k + 1) as f64 + shift) * self.step()
    }
}

/// Correlation of the velocities of tips and of their neighbours', as many to each tip.
fn coherence(moments: &[Moment], neighbours: &[usize]) -> Option<f64> {
    let strands = moments[0].tips.len();
    let each = neighbours.len() / strands;
    let mut means = vec![DVec3::ZERO; strands];
    for frame in 0..moments.len() {
        for (strand, mean) in means.iter_mut().enumerate() {
            *mean += velocity(moments, frame, strand) / moments.len() as f64;
        }
    }
    let (mut both, mut own, mut other) = (0.0, 0.0, 0.0);
    for frame in 0..moments.len() {
        let about: Vec<_> = (0..strands).map(|strand| velocity(moments, frame, strand) - means[strand]).collect();
        for (pair, &neighbour) in neighbours.iter().enumerate() {
            let [a, b] = [about[pair / each], about[neighbour]];
            both += a.dot(b);
            own += a.length_squared();
            other += b.length_squared();
        }
    }
    (own > 0.0 && other > 0.0).then(|| both / (own * other).sqrt())
}

/// Velocity of a tip in a frame [m/s]: the film's, or else that from the frame before to the frame behind.
fn velocity(moments: &[Moment], frame: usize, strand: usize) -> DVec3 {
    if let Some(velocity) = moments[frame].velocities.get(strand) {
        return velocity.as_dvec3();
    }
    let (before, behind) = (&moments[frame.saturating_sub(1)], &moments[(frame + 1).min(moments.len() - 1)]);
    (behind.tips[strand].as_dvec3() - before.tips[strand].as_dvec3()) / (behind.time - before.time)
}
