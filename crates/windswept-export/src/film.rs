//! A film that is whole, of which files are made.

use glam::Quat;
use windswept_engine::{Frame, HairFrame};

use crate::error::ExportError;
use crate::provenance::Provenance;

/// A film of strands that are the same in every frame.
pub struct Film<'a> {
    /// Number of frames.
    pub frames: usize,
    /// Makes frame k in these units, time and again: a file is written with one frame in memory at a time.
    pub frame: &'a dyn Fn(usize) -> Result<Frame, ExportError>,
    /// Frames, or time codes, per second.
    pub rate: f64,
    /// The run that it comes from.
    pub provenance: Provenance<'a>,
    /// Units and axes of its frames.
    pub units: Units,
}

/// Units and axes of a film of strands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Units {
    /// Metres per unit of length.
    pub metres: f64,
    /// The axis that points up.
    pub up: UpAxis,
}

/// An axis of a film that points up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UpAxis {
    /// As in windswept.
    Y,
    /// What is along z in windswept is along −y.
    Z,
}

impl Default for Units {
    /// Metres, y up.
    fn default() -> Self {
        Self { metres: 1.0, up: UpAxis::Y }
    }
}

impl Units {
    /// Strands of windswept in these units.
    #[must_use]
    pub fn of(&self, mut hair: HairFrame) -> HairFrame {
        if *self == Self::default() {
            return hair;
        }
        let each = 1.0 / self.metres;
        let vector = |x: &mut [f32; 3]| {
            let [a, b, c] = x.map(|x| (each * f64::from(x)) as f32);
            *x = if self.up == UpAxis::Z { [a, -c, b] } else { [a, b, c] };
        };
        hair.positions.iter_mut().chain(&mut hair.velocities).for_each(vector);
        hair.radius.iter_mut().for_each(|radius| *radius = (each * f64::from(*radius)) as f32);
        if self.up == UpAxis::Z {
            let turn = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
            for frame in hair.orientations.iter_mut().chain(&mut hair.root_frames) {
                *frame = (turn * Quat::from_array(*frame)).to_array();
            }
        }
        hair
    }
}
