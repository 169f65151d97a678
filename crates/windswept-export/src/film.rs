//! A film that is whole, of which files are made.

use glam::{DQuat, DVec3};
use windswept_engine::{Frame, HairFrame};
use windswept_scene::{CheckedBody, CheckedScene, Curves, Time};

use crate::error::ExportError;
use crate::provenance::Provenance;
use crate::render::View;

/// A film of strands that are the same in every frame.
pub struct Film<'a> {
    /// Number of frames.
    pub frames: usize,
    /// Makes frame k with its hair in these units, time and again: a file is written with one frame in memory at a
    /// time.
    pub frame: &'a dyn Fn(usize) -> Result<Frame, ExportError>,
    /// What it shows beside the hair, in formats that have it.
    pub scenery: &'a Scenery,
    /// Steps and frames of the run.
    pub time: &'a Time,
    /// The run that it comes from.
    pub provenance: Provenance<'a>,
    /// Units and axes of its frames.
    pub units: Units,
}

/// What a film shows beside its hair, in metres.
#[derive(Debug, Clone, Default)]
pub struct Scenery {
    /// Bodies; a frame has their poses, or else they are where the scene has them at its time.
    pub bodies: Vec<CheckedBody>,
    /// Cameras, by their names.
    pub cameras: Vec<(String, View)>,
}

impl Scenery {
    /// The bodies and the cameras of a scene, as pictures show them; `start` and `groom` are those of
    /// [`Renderer::with_groom`](crate::Renderer::with_groom).
    ///
    /// # Errors
    /// [`ExportError::Picture`] as [`Renderer::with_groom`](crate::Renderer::with_groom).
    pub fn of(scene: &CheckedScene, start: &HairFrame, groom: Option<&Curves>) -> Result<Self, ExportError> {
        let names = scene.cameras.iter().map(|camera| camera.name.clone());
        let cameras = names.zip(View::all(scene, start, groom)?).collect();
        Ok(Self { bodies: scene.bodies.clone(), cameras })
    }
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
    /// Rotation of windswept's axes to these.
    pub(crate) fn turn(&self) -> DQuat {
        match self.up {
            UpAxis::Y => DQuat::IDENTITY,
            UpAxis::Z => DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2),
        }
    }

    /// A vector of windswept \[m\] in these units.
    pub(crate) fn vector(&self, x: DVec3) -> DVec3 {
        let x = if self.up == UpAxis::Z { DVec3::new(x.x, -x.z, x.y) } else { x };
        (1.0 / self.metres) * x
    }

    /// Strands of windswept in these units.
    #[must_use]
    pub fn of(&self, mut hair: HairFrame) -> HairFrame {
        if *self == Self::default() {
            return hair;
        }
        let vector = |x: &mut [f32; 3]| {
            *x = self.vector(DVec3::from_array(x.map(f64::from))).as_vec3().to_array();
        };
        hair.positions.iter_mut().chain(&mut hair.velocities).for_each(vector);
        hair.radius.iter_mut().for_each(|radius| *radius = (f64::from(*radius) / self.metres) as f32);
        if self.up == UpAxis::Z {
            let turn = self.turn().as_quat();
            for frame in hair.orientations.iter_mut().chain(&mut hair.root_frames) {
                *frame = (turn * glam::Quat::from_array(*frame)).to_array();
            }
        }
        hair
    }
}
