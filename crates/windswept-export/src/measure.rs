//! Numbers that describe a film of hair: how its tips swing, how its strands wave and turn, how they gather and lean.

mod moment;
mod motion;
mod nearest;
mod shape;
mod table;
#[cfg(test)]
mod tests;
mod window;

use glam::DVec3;
use serde::Serialize;
use windswept_engine::HairFrame;

use crate::error::ExportError;
use crate::strands::check_strands;
use moment::{Moment, Start};
use motion::Motion;

/// Numbers of the frames of a window of time. `strands` in a definition are all strands alike, whatever number of hairs
/// they stand for.
///
/// `sideways` is within the plane across `axis`, the same for all strands and frames. A number that has no meaning is
/// `None`, `null` in JSON: each definition says when.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Measurement {
    /// Number of strands.
    pub strands: usize,
    /// Number of frames in the window.
    pub frames: usize,
    /// Time of the window's first frame \[s\].
    pub from_s: f64,
    /// Time of the window's last frame \[s\].
    pub to_s: f64,
    /// Direction that `sideways` is across, of length 1: that of the mean wind in the window; where that is zero, the
    /// mean direction from root to tip.
    pub axis: [f64; 3],
    /// Swing: root mean square, over frames and strands, of the sideways displacement of each tip from its own mean
    /// place in the window. Roots that move swing their tips too.
    pub swing_m: f64,
    /// Swing of the bundle: root mean square of the sideways displacement of the mean of all tips from its own mean
    /// place.
    pub swing_bundle_m: f64,
    /// Swing of strands within the bundle: as `swing_m`, of the tips' places relative to the mean of all tips.
    /// `swing_m`² = `swing_bundle_m`² + `swing_strands_m`².
    pub swing_strands_m: f64,
    /// Dominant frequency: the peak of the spectrum, between its frequencies by the parabola through the logarithms of
    /// the peak's power and its two neighbours'. `None` where `swing_m` is below a millionth of the strands' mean
    /// length.
    pub frequency_hz: Option<f64>,
    /// Wavelength λ of the undulation along strands, a length along them: λ² = 4π² ∫|p|² ds / ∫|dp/ds|² ds, with the
    /// part p of a strand's direction that is across its chord, which leads from root to tip, and the length s along
    /// the strand; both integrals are sums over strands and frames. λ for displacements a sin(2π s/λ), at rest or
    /// travelling; the length of a turn for curls; twice the strand's length for a single bow. 12 segments per wave
    /// make it 1 % too long. `None` where strands are straight: the root mean square of p is below 0.001.
    pub wavelength_m: Option<f64>,
    /// Turning angle, its mean over strands and frames. The turning angle of a strand is the largest length of the sum
    /// of the rotation vectors by which one segment's direction becomes the next's, from any segment to any later one.
    /// An arc turns by its angle, also beyond 180°; a wave by twice its largest slope, however long it is.
    pub turning_mean_degrees: f64,
    /// Largest turning angle of all strands and frames.
    pub turning_largest_degrees: f64,
    /// Index of the strand with the largest turning angle.
    pub turning_strand: usize,
    /// Time of the frame with the largest turning angle \[s\].
    pub turning_time_s: f64,
    /// Turns of a curl, mean over strands and frames: the number of segments times the mean angle by which the bend,
    /// seen along the chord, goes on from one segment to the next, over 360°. The mean is weighted by the square of the
    /// bend. Curls that reverse their sense cancel. 0 for bends in a plane, and for curls with less than three segments
    /// per turn.
    pub turns: f64,
    /// Gathering: the mean distance to the four nearest strands at 0.8 of the length over the same at the roots, each a
    /// mean over strands and frames. `None` for a single strand or roots in one place; fewer than five strands have all
    /// others as their nearest.
    pub gathering: Option<f64>,
    /// Coherence: correlation Σ vᵢ·vⱼ / √(Σ vᵢ² Σ vⱼ²) of the velocities of tips i and those j of the four strands that
    /// are nearest at the roots in the film's first frame; sums over pairs and frames, each v about its own mean in the
    /// window. 1: neighbours move alike; 0: as if unrelated. Without velocities in the film they are differences of
    /// places. `None` for a single strand, or where nothing moves.
    pub coherence: Option<f64>,
    /// Lean: angle between gravity and the direction from root to tip, mean over strands and frames. 0° hangs, 90°
    /// stands out level.
    pub lean_degrees: f64,
    /// Stretch: largest |l/l0 − 1| of all segments and frames, with the length l0 in the film's first frame, be it in
    /// the window or not. A film rounds places to f32: 1e-4 for segments of 1 mm that are 1 m from the origin.
    pub stretch: f64,
    /// Frequencies of the spectrum: 1/T, 2/T, ..., with T the number of frames times the time between two.
    pub spectrum_frequency_hz: Vec<f64>,
    /// Power spectrum of the tips' sideways displacement from their mean places, under a Hann window, one-sided: sum
    /// over both sideways directions, mean over strands. Its sum times 1/T is `swing_m`² as far as the window lets it.
    pub spectrum_power_m2_per_hz: Vec<f64>,
}

/// The window of time that is measured, and the direction of gravity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasureOptions {
    /// Start of the window \[s\]; `None`: [`MeasureOptions::START`], or the film's first frame where the film ends
    /// before twice that.
    pub from: Option<f64>,
    /// End of the window \[s\]; `None`: the film's last frame.
    pub to: Option<f64>,
    /// Direction of gravity, of any length; zero stands for (0, −1, 0).
    pub gravity: [f64; 3],
}

impl MeasureOptions {
    /// Time that a film is given to get going \[s\].
    pub const START: f64 = 0.2;
}

impl Default for MeasureOptions {
    fn default() -> Self {
        Self { from: None, to: None, gravity: [0.0, -1.0, 0.0] }
    }
}

/// Measures a film frame by frame. Of each frame it keeps the tips, 24 bytes per strand.
#[derive(Debug)]
pub struct Measure {
    options: MeasureOptions,
    start: Option<Start>,
    moments: Vec<Moment>,
}

impl Measure {
    /// A film without frames as yet.
    #[must_use]
    pub fn new(options: MeasureOptions) -> Self {
        Self { options, start: None, moments: Vec::new() }
    }

    /// The next frame: its time \[s\], its strands, and the mean wind then \[m/s\], which is zero where none is known.
    /// Strands are compared with the first frame's; frames before the window may be left out after that.
    ///
    /// # Errors
    /// [`ExportError::Film`] if the time is not behind that of the last frame, if points do not make strands or are not
    /// finite, or if the strands are others than those of the first frame.
    pub fn add(&mut self, time: f64, hair: &HairFrame, wind: [f64; 3]) -> Result<(), ExportError> {
        let fault = |problem: String| film_error(format!("frame {}: {problem}", self.moments.len()));
        check(hair).map_err(fault)?;
        let last = self.moments.last().map_or(f64::NEG_INFINITY, |moment| moment.time);
        if !crate::sink::is_later(time, last) {
            return Err(fault(format!("is at {time} s, the one before at {last} s; expected a later one")));
        }
        if self.start.as_ref().is_some_and(|start| start.offsets != hair.offsets) {
            return Err(fault("has other strands than the first".to_owned()));
        }
        let start = self.start.get_or_insert_with(|| Start::new(hair));
        let gravity = DVec3::from_array(self.options.gravity).try_normalize().unwrap_or(DVec3::NEG_Y);
        self.moments.push(Moment::new(time, hair, start, DVec3::from_array(wind), gravity));
        Ok(())
    }

    /// The numbers of the window.
    ///
    /// # Errors
    /// [`ExportError::Film`] if the window has fewer than 8 frames, or frames at uneven times: a frame may be half of
    /// the time between two frames away from its even place, as those of a run are by up to half a step.
    pub fn finish(&self) -> Result<Measurement, ExportError> {
        let times: Vec<f64> = self.moments.iter().map(|moment| moment.time).collect();
        let window = window::window(&times, &self.options).map_err(film_error)?;
        let interval = window::interval(&times[window.clone()]).map_err(film_error)?;
        let start = self.start.as_ref().ok_or_else(|| film_error("has no frame".to_owned()))?;
        let moments = &self.moments[window];
        let mean = |number: fn(&Moment) -> f64| moments.iter().map(number).sum::<f64>() / moments.len() as f64;
        let largest = moments.iter().max_by(|a, b| a.largest.0.total_cmp(&b.largest.0)).unwrap_or(&moments[0]);
        let motion = Motion::new(moments, axis(moments), interval, start);
        let [slopes, bends] = [0, 1].map(|k| moments.iter().map(|moment| moment.undulation[k]).sum::<f64>());
        let straight = bends == 0.0 || slopes < 1e-6 * start.length * moments.len() as f64;
        let [upper, roots] = [mean(|moment| moment.apart[0]), mean(|moment| moment.apart[1])];
        Ok(Measurement {
            strands: start.offsets.len() - 1,
            frames: moments.len(),
            from_s: moments[0].time,
            to_s: moments[moments.len() - 1].time,
            axis: axis(moments).to_array(),
            swing_m: motion.swing,
            swing_bundle_m: motion.bundle,
            swing_strands_m: motion.strands,
            frequency_hz: motion.peak,
            wavelength_m: (!straight).then(|| std::f64::consts::TAU * (slopes / bends).sqrt()),
            turning_mean_degrees: mean(|moment| moment.turning).to_degrees(),
            turning_largest_degrees: largest.largest.0.to_degrees(),
            turning_strand: largest.largest.1,
            turning_time_s: largest.time,
            turns: mean(|moment| moment.turns),
            gathering: (roots > 0.0).then(|| upper / roots),
            coherence: motion.coherence,
            lean_degrees: mean(|moment| moment.lean).to_degrees(),
            stretch: moments.iter().map(|moment| moment.stretch).fold(0.0, f64::max),
            spectrum_frequency_hz: motion.frequencies,
            spectrum_power_m2_per_hz: motion.power,
        })
    }
}

/// Measures a film, `hair.vtkhdf`, of which it reads the first frame and those of the window. `wind` is the mean wind
/// \[m/s\] at a time \[s\], zero where none is known.
///
/// # Errors
/// [`ExportError::File`] if the film cannot be read; [`ExportError::Film`], with its path, as [`Measure::add`] and
/// [`Measure::finish`], and if it is not of hair.
#[cfg(feature = "vtkhdf")]
pub fn measure_film(
    path: &std::path::Path,
    options: &MeasureOptions,
    wind: impl Fn(f64) -> [f64; 3],
) -> Result<Measurement, ExportError> {
    use crate::{Kind, VtkHdfReader};

    let named = |problem: String| film_error(format!("{}: {problem}", path.display()));
    let named_again = |error| match error {
        ExportError::Film { problem } => named(problem),
        error => error,
    };
    let reader = VtkHdfReader::open(path)?;
    if reader.kind() != Kind::Hair {
        return Err(named(format!("expected {:?}, found {:?}", Kind::Hair, reader.kind())));
    }
    let window = window::window(reader.times(), options).map_err(named)?;
    let mut measure = Measure::new(*options);
    for k in (0..window.end).filter(|k| *k == 0 || window.contains(k)) {
        let frame = reader.frame(k)?;
        measure.add(frame.time, &frame.hair, wind(frame.time)).map_err(named_again)?;
    }
    measure.finish().map_err(named_again)
}

/// The direction that `sideways` is across.
fn axis(moments: &[Moment]) -> DVec3 {
    let wind = moments.iter().map(|moment| moment.wind).sum::<DVec3>();
    let chords = moments.iter().map(|moment| moment.chords).sum::<DVec3>();
    wind.try_normalize().or_else(|| chords.try_normalize()).unwrap_or(DVec3::NEG_Y)
}

/// Says what is wrong with strands that cannot be measured.
fn check(hair: &HairFrame) -> Result<(), String> {
    check_strands(hair)?;
    let (points, velocities) = (hair.positions.len(), hair.velocities.len());
    if ![0, points].contains(&velocities) {
        return Err(format!("has {velocities} velocities, expected {points} or none"));
    }
    let rows = [&hair.positions, &hair.velocities];
    match rows.iter().find_map(|rows| rows.iter().position(|row| !row.iter().all(|x| x.is_finite()))) {
        Some(point) => Err(format!("point {point} is not finite")),
        None => Ok(()),
    }
}

fn film_error(problem: String) -> ExportError {
    ExportError::Film { problem }
}
