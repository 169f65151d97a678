//! How pictures are taken: `[camera]` and `[picture]`, read and checked.

use glam::DVec3;

use crate::{
    error::SceneError,
    reader::Reader,
    scene::{Law, Scene},
};

/// Ten heads of hair.
const MOST_HAIRS: u32 = 1_000_000;

/// `[camera]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// `None` frames the hair automatically.
    pub look_at: Option<LookAt>,
    /// Vertical field of view \[°\], below 180.
    pub fov: f64,
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
}

/// `camera.eye` and `camera.target`, two points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LookAt {
    /// Where the camera stands \[m\].
    pub eye: [f64; 3],
    /// What it looks at \[m\].
    pub target: [f64; 3],
}

/// `[picture]`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Picture {
    /// Hairs drawn in all, interpolated from the strands; at least every strand is drawn.
    pub hairs: u32,
    /// How air particles are drawn.
    pub air: AirPicture,
}

/// `picture.air`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AirPicture {
    /// Not at all.
    None,
    /// Coloured by |curl v|.
    Vorticity,
    /// Coloured by ½ |û|² of the first band.
    BandEnergy,
}

impl Reader<'_> {
    pub(crate) fn camera(&self) -> Result<Camera, SceneError> {
        let fov = self.number("camera.fov")?;
        if fov >= 180.0 {
            return Err(self.fault("camera.fov", format!("expected an angle below 180 degrees, found {fov}")));
        }
        Ok(Camera {
            look_at: self.look_at()?,
            fov,
            width: self.count("camera.width")?,
            height: self.count("camera.height")?,
        })
    }

    /// Both or neither.
    fn look_at(&self) -> Result<Option<LookAt>, SceneError> {
        let keys = ["camera.eye", "camera.target"];
        match keys.iter().find(|key| !self.has(key)) {
            Some(_) if !keys.iter().any(|key| self.has(key)) => return Ok(None),
            Some(missing) => {
                return Err(self.fault(missing, "is missing: expected camera.eye and camera.target, or neither"));
            }
            None => {}
        }
        let [eye, target] = [self.vector(keys[0])?, self.vector(keys[1])?];
        if DVec3::from_array(eye).distance(DVec3::from_array(target)) < 1e-9 {
            return Err(self.fault("camera.target", "is the same point as camera.eye; expected another"));
        }
        Ok(Some(LookAt { eye, target }))
    }

    pub(crate) fn picture(&self) -> Result<Picture, SceneError> {
        let hairs = self.count("picture.hairs")?;
        if hairs > MOST_HAIRS {
            return Err(self.fault("picture.hairs", format!("expected at most {MOST_HAIRS}, found {hairs}")));
        }
        Ok(Picture { hairs, air: self.choice("picture.air")? })
    }

    /// Whether there will be what the picture's air is coloured by.
    pub(crate) fn check_picture(&self, scene: &Scene) -> Result<(), SceneError> {
        let needed = match scene.picture.air {
            AirPicture::None => return Ok(()),
            AirPicture::Vorticity => "particles that have neighbours: a density constraint, viscosity or turbulence",
            AirPicture::BandEnergy => "one of turbulence.bands strengthened, and a turbulence.speed to measure it by",
        };
        let (fluid, viscosity) = (&scene.fluid, &scene.viscosity);
        let fault =
            |needs: &str| Err(self.fault("picture.air", format!("\"{}\" needs {needs}", scene.picture.air.word())));
        let there = match scene.picture.air {
            _ if !scene.model.has_air() => return fault("air particles: interaction.model = \"particles\""),
            AirPicture::BandEnergy => strengthened(scene),
            _ => fluid.iterations > 0 || viscosity.hair > 0.0 || viscosity.air > 0.0 || strengthened(scene),
        };
        if there { Ok(()) } else { fault(needed) }
    }
}

/// Whether confinement strengthens a band.
fn strengthened(scene: &Scene) -> bool {
    let eddies = &scene.turbulence;
    eddies.bands.iter().any(|band| band.strength > 0.0) && (eddies.law == Law::Published || eddies.speed > 0.0)
}
