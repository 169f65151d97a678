//! Pictures of frames, drawn off-screen on the engine's GPU.
//!
//! ```text
//! strands of a frame --followers--> courses of hairs --grow--> points of every hair
//!     --opacity--> hair between each point and the lights --shade--> colours
//! backdrop, patch, bodies, ribbons, air --> 16 samples a pixel --average--> RGBA8
//! ```
//!
//! For a frame only the points of strands and followers go to the GPU, which makes the ribbons between them.

mod bodies;
mod groom;
mod maker;
mod passes;
mod patch;
mod readback;
mod solids;
mod target;
mod view;

use glam::{DVec3, Vec3};
use image::RgbaImage;
use windswept_engine::gpu::wgpu;
use windswept_engine::{Frame, Gpu, HairFrame};
use windswept_scene::{AirPicture, Camera, CheckedScene, Curves};
use windswept_shaders::pictures::common::FINE;

use crate::error::ExportError;
use groom::Groom;
use passes::Passes;
pub use readback::read_texture;
pub use solids::Solids;
use target::Target;
pub use view::View;

/// Turn from one drawn point of a hair to the next that still looks round \[rad\].
const ROUND: f32 = 0.20;
/// Points of a hair, at least.
const FEWEST_POINTS: u32 = 48;
/// Points between two of a strand's, at most.
const MAX_BETWEEN: u32 = 12;

/// Draws frames of one scene.
///
/// About `picture.hairs` hairs are interpolated between the simulated strands; the scene's first camera takes the
/// picture, unless [`Renderer::look_through`] takes another. The same frame on the same adapter gives the same picture,
/// whatever was drawn before.
#[derive(Debug)]
pub struct Renderer {
    gpu: Gpu,
    view: View,
    groom: Groom,
    /// First point of each strand that it draws, and the number of points.
    offsets: Vec<u32>,
    /// Points of a drawn hair.
    samples: u32,
    scene: CheckedScene,
    /// The scalar that air is brightest at.
    brightest: f32,
    passes: Passes,
    target: Target,
}

impl Renderer {
    /// A renderer of this scene's frames. `start` is the hair of its first frame: roots near each other there share the
    /// hairs between them.
    ///
    /// # Errors
    /// [`ExportError::Picture`] if there is no strand, the camera stands where it looks or asks for a picture larger
    /// than the adapter draws, or so many hairs do not fit it; [`ExportError::Gpu`] if the driver refuses.
    pub fn new(gpu: &Gpu, scene: &CheckedScene, start: &HairFrame) -> Result<Self, ExportError> {
        Self::with_groom(gpu, scene, start, None)
    }

    /// A renderer of a scene with a caller's own groom, whose followers ([`InitialState::followers`]) it draws.
    ///
    /// # Errors
    /// As [`Self::new`].
    ///
    /// [`InitialState::followers`]: windswept_scene::InitialState::followers
    pub fn with_groom(
        gpu: &Gpu,
        scene: &CheckedScene,
        start: &HairFrame,
        groom: Option<&Curves>,
    ) -> Result<Self, ExportError> {
        check(start)?;
        let groom = Groom::new(scene, start, groom, scene.picture.hairs)?;
        let view = View::new(scene, &scene.cameras[0], &groom.followers)?;
        check_size(gpu, &view)?;
        let hairs = groom.hairs.len() as u32;
        let samples = samples(groom.followers.start());
        let fits = gpu.largest_binding() / (u64::from(samples) * 16);
        if u64::from(hairs) > fits {
            return Err(refused(format!(
                "picture.hairs: {hairs} hairs of {samples} points do not fit the adapter, about {fits} would"
            )));
        }
        let speed = scene.air.as_ref().map_or(0.0, |air| DVec3::from_array(air.wind).length());
        let brightest = match scene.picture.air {
            AirPicture::None => 1.0,
            // The shear layer at the hair: the whole wind over two kernel radii.
            AirPicture::Vorticity => speed / scene.air.as_ref().map_or(1.0, |air| 2.0 * air.kernel_radius),
            // Eddies two thirds as fast as the law lets them grow by default.
            AirPicture::BandEnergy => 0.5 * (0.2 * speed).powi(2),
        };
        let passes = Passes::new(gpu, scene, start, &groom, samples)?;
        let target = Target::new(gpu, view.width, view.height)?;
        Ok(Self {
            gpu: gpu.clone(),
            view,
            groom,
            offsets: start.offsets.clone(),
            samples,
            scene: scene.clone(),
            brightest: (brightest as f32).max(f32::MIN_POSITIVE),
            passes,
            target,
        })
    }

    /// Takes the next pictures with another camera.
    ///
    /// # Errors
    /// As [`Self::new`]; then the camera is the one before.
    pub fn look_through(&mut self, camera: &Camera) -> Result<(), ExportError> {
        self.look_from(View::new(&self.scene, camera, &self.groom.followers)?)
    }

    /// Takes the next pictures from somewhere else, in another size.
    ///
    /// # Errors
    /// As [`Self::new`]; then the camera is the one before.
    pub fn look_from(&mut self, view: View) -> Result<(), ExportError> {
        if (view.width, view.height) != (self.view.width, self.view.height) {
            check_size(&self.gpu, &view)?;
            self.target = Target::new(&self.gpu, view.width, view.height)?;
        }
        self.view = view;
        Ok(())
    }

    /// The camera: where it stands, or where it frames the hair from.
    #[must_use]
    pub fn view(&self) -> &View {
        &self.view
    }

    /// Hairs drawn.
    #[must_use]
    pub fn hairs(&self) -> usize {
        self.groom.hairs.len()
    }

    /// Checks that this frame can be drawn.
    ///
    /// # Errors
    /// [`ExportError::Picture`] as [`Self::render`].
    pub fn check(&self, frame: &Frame) -> Result<(), ExportError> {
        self.accept(frame).map(|_| ())
    }

    /// A picture of the frame, sRGB, opaque.
    ///
    /// # Errors
    /// [`ExportError::Picture`] if the frame is not of this renderer's strands, has a point that is not finite, or
    /// lacks what `picture.air` colours by; [`ExportError::Gpu`] if the driver refuses or the device is lost.
    pub fn render(&self, frame: &Frame) -> Result<RgbaImage, ExportError> {
        self.show(frame)?;
        read_texture(&self.gpu, self.target.picture())
    }

    /// Draws the frame to [`Self::shown`], and does not wait for it.
    ///
    /// # Errors
    /// As [`Self::render`].
    pub fn show(&self, frame: &Frame) -> Result<(), ExportError> {
        let air = self.accept(frame)?;
        let points = frame.hair.positions.iter().map(|p| Vec3::from_array(*p));
        let (low, high) = points.fold((Vec3::MAX, Vec3::MIN), |(low, high), x| (low.min(x), high.max(x)));
        // Hairs stand off their strands a little.
        let margin = 0.03 * (high - low).max_element() + 1e-3;
        let (low, high) = ((low - margin).as_dvec3(), (high + margin).as_dvec3());
        let uniform = self.view.uniform(low, high, self.groom.hairs.len() as u32, self.samples);
        let followers = self.groom.followers.of(frame)?;
        self.passes.upload(&self.gpu, &uniform, &self.scene, frame, &followers)?;
        let air = self.passes.air(&self.gpu, &air)?;
        self.gpu.checked(
            || "drawing a picture".to_owned(),
            || {
                let mut encoder = self
                    .gpu
                    .device()
                    .create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("picture") });
                self.passes.prepare(&mut encoder);
                self.target.draw(&mut encoder, |pass| self.passes.draw(pass, air.as_ref()));
                self.gpu.queue().submit([encoder.finish()]);
            },
        )?;
        Ok(())
    }

    /// The texture that [`Self::show`] draws to, `Rgba8UnormSrgb` with views as `Rgba8Unorm`. A picture of another size
    /// has another one.
    #[must_use]
    pub fn shown(&self) -> &wgpu::Texture {
        self.target.picture()
    }

    /// Position and brightness of each air particle that is drawn, if the frame can be.
    fn accept(&self, frame: &Frame) -> Result<Vec<[f32; 4]>, ExportError> {
        check(&frame.hair)?;
        if frame.hair.offsets != self.offsets {
            return Err(refused("the frame has other strands than the renderer was made for".into()));
        }
        let (values, what) = match self.scene.picture.air {
            AirPicture::None => return Ok(Vec::new()),
            AirPicture::Vorticity => (&frame.air.vorticity, "vorticity"),
            AirPicture::BandEnergy => (&frame.air.band_energy, "band_energy"),
        };
        if values.len() != frame.air.positions.len() || values.is_empty() {
            return Err(refused(format!("picture.air = \"{what}\", but the frame's air has no {what}")));
        }
        let point = |(&[x, y, z], value): (&[f32; 3], &f32)| [x, y, z, value / self.brightest];
        // Invisible points are left out.
        Ok(frame.air.positions.iter().zip(values).map(point).filter(|p| p[3] > 0.02).collect())
    }
}

/// Checks that the adapter draws pictures as large as a camera's.
fn check_size(gpu: &Gpu, view: &View) -> Result<(), ExportError> {
    let most = gpu.device().limits().max_texture_dimension_2d / FINE;
    if view.width.max(view.height) <= most {
        return Ok(());
    }
    Err(refused(format!(
        "camera.width and camera.height ask for {} x {} pixels, the adapter draws at most {most} x {most}",
        view.width, view.height
    )))
}

/// Checks that there are strands, whole and finite.
fn check(hair: &HairFrame) -> Result<(), ExportError> {
    let strands = hair.offsets.len().saturating_sub(1);
    let whole = hair.offsets.first() == Some(&0)
        && hair.offsets.last().is_some_and(|&last| last as usize == hair.positions.len())
        && hair.offsets.windows(2).all(|w| w[1] >= w[0].saturating_add(2));
    if strands == 0 {
        return Err(refused("the frame has no strands to draw".into()));
    }
    if !whole || hair.orientations.len() != hair.positions.len() - strands {
        return Err(refused(format!(
            "{} points and {} orientations do not make {strands} strands",
            hair.positions.len(),
            hair.orientations.len()
        )));
    }
    let infinite = hair.positions.iter().position(|p| !p.iter().all(|x| x.is_finite()));
    match infinite {
        Some(point) => Err(refused(format!("hair point {point} is not finite"))),
        None => Ok(()),
    }
}

fn refused(problem: String) -> ExportError {
    ExportError::Picture { problem }
}

/// Points of a drawn hair: enough that neither the strand with the most points nor the curliest shows corners.
fn samples(hair: &HairFrame) -> u32 {
    let strands = || hair.offsets.windows(2).map(|w| &hair.positions[w[0] as usize..w[1] as usize]);
    let segments = strands().map(|points| points.len() as u32 - 1).max().unwrap_or(1);
    let tangent = |a: [f32; 3], b: [f32; 3]| (Vec3::from_array(b) - Vec3::from_array(a)).normalize_or_zero();
    let turn = |w: &[[f32; 3]]| tangent(w[0], w[1]).dot(tangent(w[1], w[2])).clamp(-1.0, 1.0).acos();
    let turns: Vec<f32> = strands().flat_map(|points| points.windows(3).map(turn)).collect();
    let mean = turns.iter().sum::<f32>() / turns.len().max(1) as f32;
    // The wind bends hair by more than it starts with.
    let between = (FEWEST_POINTS.div_ceil(segments)).max((mean / ROUND).ceil() as u32).clamp(1, MAX_BETWEEN);
    segments * between + 1
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each point of a strand is one of those that its hair is drawn with, and a strand of few points is drawn with
    /// more.
    #[test]
    fn points_of_strands_are_drawn() {
        for points in [2, 3, 10, 34, 100] {
            let positions = (0..points).map(|k| [0.0, -0.001 * k as f32, 0.0]).collect();
            let drawn = samples(&HairFrame { positions, offsets: vec![0, points], ..HairFrame::default() });
            assert_eq!((drawn - 1) % (points - 1), 0, "{drawn} of {points} points");
            assert!(
                drawn >= points && drawn > FEWEST_POINTS.min(MAX_BETWEEN * (points - 1)),
                "{drawn} of {points} points"
            );
        }
    }
}
