//! Pictures: `[[camera]]` and `[picture]`.

use glam::DVec3;

use crate::{
    declare::{faults_of, table, words},
    error::SceneError,
    faults::At,
    keys::{
        Fallback::{Derived, Required, Value},
        Kind::{Choice, Count, Positive, Table, Text, Vector},
    },
    limits::{MAX_HAIRS, MAX_PIXELS, MIN_PIXELS},
    scene::{Law, SceneValues},
};

table! {
    /// One `[[camera]]`: what pictures are taken with.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Camera, with defaults, checked by Camera::check {
        /// Name of the camera, for dotted keys and to choose it by.
        name: String = Text, "", Value("camera".to_owned());
        /// Place and aim of the camera; `None` frames the hair.
        look_at as "": Option<LookAt> = Table, "", Derived("frames the hair");
        /// Vertical field of view, below 180.
        fov: f64 = Positive, "°", Value(26.0);
        /// Width of a picture.
        width: u32 = Count(MIN_PIXELS, MAX_PIXELS), "px", Value(960);
        /// Height of a picture.
        height: u32 = Count(MIN_PIXELS, MAX_PIXELS), "px", Value(540);
    }
}

table! {
    /// Place and aim of a camera: `camera.eye` and `camera.target`.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct LookAt, checked by LookAt::check {
        /// Place of the camera; eye and target go together.
        eye: [f64; 3] = Vector, "m", Required;
        /// Point that the camera looks at.
        target: [f64; 3] = Vector, "m", Required;
    }
}

table! {
    /// `[picture]`: what pictures show.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub struct Picture, with defaults {
        /// Hairs drawn in all, the strands and others that follow them; where a groom file has others, those first.
        hairs: u32 = Count(1, MAX_HAIRS), "", Value(20_000);
        /// Colour of the air particles, or none of them.
        air: AirPicture = Choice(AirPicture::WORDS), "", Value(AirPicture::None);
    }
}

words! {
    /// `picture.air`.
    pub enum AirPicture {
        /// Air particles are not drawn.
        None = "none",
        /// Coloured by |curl v|.
        Vorticity = "vorticity",
        /// Coloured by ½ |û|² of the first band.
        BandEnergy = "band_energy",
    }
}

impl LookAt {
    fn check(&self, at: &At<'_>) {
        if DVec3::from_array(self.eye).distance(DVec3::from_array(self.target)) < 1e-9 {
            at.fault("target", "is the same point as camera.eye; expected another");
        }
    }
}

impl Camera {
    /// Checks a camera that was made in code, as [`Scene::check`](crate::Scene::check) does those of a scene.
    ///
    /// # Errors
    /// [`SceneError`] with the key of each value that does not fit.
    pub fn valid(&self) -> Result<(), SceneError> {
        SceneError::of_all(faults_of(self)).map_or(Ok(()), Err)
    }

    fn check(&self, at: &At<'_>) {
        if self.fov >= 180.0 {
            at.fault("fov", format!("expected an angle below 180 degrees, found {}", self.fov));
        }
    }
}

impl SceneValues {
    /// Air particles must have what a picture colours them by.
    pub(crate) fn check_picture(&self, at: &At<'_>) {
        let air = self.picture.air;
        let needed = match air {
            AirPicture::None => return,
            AirPicture::Vorticity => "particles that have neighbours: a density constraint, viscosity or turbulence",
            AirPicture::BandEnergy => "one of turbulence.bands strengthened, and a turbulence.speed to measure it by",
        };
        let fault = |needs: &str| at.fault("picture.air", format!("\"{}\" needs {needs}", air.word()));
        if !self.interaction.model.has_air() {
            return fault("air particles: interaction.model = \"two-way\" or \"particles\"");
        }
        let near = self.fluid.iterations > 0 || self.viscosity.acts();
        if !(strengthened(self) || air == AirPicture::Vorticity && near) {
            fault(needed);
        }
    }
}

/// Whether confinement strengthens a band.
fn strengthened(scene: &SceneValues) -> bool {
    let eddies = &scene.turbulence;
    eddies.bands.iter().any(|band| band.strength > 0.0) && (eddies.law == Law::Published || eddies.speed > 0.0)
}
