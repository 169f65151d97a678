//! The picture in the window, and which renderer draws it.

use std::sync::Arc;

use eframe::egui::{Rect, epaint::PaintCallback};
use eframe::egui_wgpu::RenderState;
use glam::DVec3;
use windswept::gpu::wgpu::{self, util::DeviceExt as _};
use windswept::{CheckedScene, Frame, Gpu, HairFrame};
use windswept_export::image::RgbaImage;
use windswept_export::{ExportError, Renderer, View};
use windswept_scene::Curves;

use crate::blit::Blit;
use crate::camera::Orbit;
use crate::fields::{AirColour, AirLook, HairColour, Range};
use crate::lines::{Air, Lines, Shot};

/// Particle spacings that an arrow of the fastest air is long.
const LONGEST_ARROW: f64 = 2.5;

/// How strands are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Look {
    /// As lines, at once.
    Lines,
    /// As pictures of a run show them, with the hairs that follow.
    Film,
}

/// What is drawn, and how.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Looks {
    pub(crate) look: Look,
    /// Hairs of the film look.
    pub(crate) hairs: u32,
    /// Pixels drawn for each one shown, along a side.
    pub(crate) sharpness: f32,
    pub(crate) hair: HairColour,
    pub(crate) air: AirLook,
    pub(crate) air_colour: AirColour,
}

/// A state to be drawn.
#[derive(Clone)]
pub(crate) struct State {
    /// Rises with each state.
    pub(crate) serial: u64,
    pub(crate) scene: Arc<CheckedScene>,
    pub(crate) frame: Arc<Frame>,
    /// A value per hair point, where hair is coloured.
    pub(crate) values: Arc<Vec<f32>>,
    /// Positions on the GPU, less the origin \[m\]; none: those of the frame.
    pub(crate) positions: Option<(wgpu::Buffer, DVec3)>,
}

/// Draws states of one scene.
pub(crate) struct Picture {
    gpu: Gpu,
    scene: CheckedScene,
    /// The strands at the start, and a caller's own curves that follow them.
    start: HairFrame,
    groom: Option<Curves>,
    lines: Lines,
    /// Made where it is needed first, as its hairs may take a while.
    renderer: Option<(u32, Renderer)>,
    blit: Blit,
    /// What it shows.
    drawn: Option<(u64, Orbit, Looks, [u32; 2])>,
    /// Values of the last colours, of hair and of air, and what they are of.
    ranges: [Range; 2],
    ranged: (HairColour, AirColour),
}

impl Picture {
    /// Draws the scene whose strands are `start` at first, with the curves of a groom that follow them.
    pub(crate) fn new(
        gpu: &Gpu,
        render: &RenderState,
        scene: &CheckedScene,
        start: HairFrame,
        groom: Option<Curves>,
    ) -> Result<Self, ExportError> {
        Ok(Self {
            lines: Lines::new(gpu, scene, &start)?,
            gpu: gpu.clone(),
            scene: scene.clone(),
            start,
            groom,
            renderer: None,
            blit: Blit::new(render),
            drawn: None,
            ranges: [Range::default(); 2],
            ranged: (HairColour::default(), AirColour::default()),
        })
    }

    /// The cameras of the scene, by their names; those that frame the hair do so in a picture of this size \[px\].
    pub(crate) fn cameras(&self, size: [u32; 2]) -> Result<Vec<(String, Orbit)>, ExportError> {
        let few = self.scene.assuming(|_, values| {
            // Some hairs say as well as many where hair is.
            values.picture.hairs = values.picture.hairs.min(500);
            values.cameras.iter_mut().for_each(|camera| [camera.width, camera.height] = size);
        });
        let views = View::all(&few, &self.start, self.groom.as_ref())?;
        let names = self.scene.cameras.iter().map(|camera| camera.name.clone());
        Ok(names.zip(views.iter().map(Orbit::of)).collect())
    }

    /// Draws a state in a size \[px\], unless it is drawn already.
    pub(crate) fn draw(
        &mut self,
        state: &State,
        orbit: Orbit,
        looks: Looks,
        size: [u32; 2],
    ) -> Result<(), ExportError> {
        let wanted = (state.serial, orbit, looks, size);
        if self.drawn == Some(wanted) {
            return Ok(());
        }
        let view = orbit.view(size);
        let has_hair = !state.frame.hair.positions.is_empty();
        let changed = self.drawn.is_none_or(|drawn| drawn.2.look != looks.look || drawn.2.hairs != looks.hairs);
        let texture = match looks.look {
            // The state that has its strands is on its way.
            Look::Film if !has_hair => return Ok(()),
            Look::Film => {
                let renderer = self.renderer(looks.hairs)?;
                let before = [renderer.view().width, renderer.view().height];
                renderer.look_from(view)?;
                renderer.show(&state.frame)?;
                (before != size || changed).then(|| renderer.shown().clone())
            }
            Look::Lines => {
                let other = self.draw_lines(state, view, looks)?;
                if other || changed { self.lines.shown().cloned() } else { None }
            }
        };
        self.drawn = Some(wanted);
        if let Some(texture) = texture {
            self.blit.set(&texture);
        }
        Ok(())
    }

    fn renderer(&mut self, hairs: u32) -> Result<&mut Renderer, ExportError> {
        let made = match self.renderer.take() {
            Some((number, renderer)) if number == hairs => renderer,
            _ => {
                let scene = self.scene.assuming(|_, values| values.picture.hairs = hairs);
                Renderer::with_groom(&self.gpu, &scene, &self.start, self.groom.as_ref())?
            }
        };
        Ok(&mut self.renderer.insert((hairs, made)).1)
    }

    fn draw_lines(&mut self, state: &State, view: View, looks: Looks) -> Result<bool, ExportError> {
        let (hair, air) = (looks.hair, looks.air_colour);
        if self.ranged != (hair, air) {
            (self.ranges, self.ranged) = ([Range::default(); 2], (hair, air));
        }
        let values = &state.values;
        let coloured = hair != HairColour::Hair && !values.is_empty();
        if coloured {
            self.ranges[0].follow(values);
        }
        let particles = if looks.air == AirLook::Hidden { Vec::new() } else { air.values(&state.frame) };
        self.ranges[1].follow(&particles);
        let arrow = match (looks.air, &state.scene.air) {
            (AirLook::Arrows, Some(air)) => {
                let speeds = state.frame.air.velocities.iter().map(|v| crate::fields::length(*v));
                let fastest = speeds.fold(f32::MIN_POSITIVE, f32::max);
                (LONGEST_ARROW * air.spacing) as f32 / fastest
            }
            _ => 0.0,
        };
        let own;
        let (positions, origin) = match &state.positions {
            Some((positions, origin)) => (positions, *origin),
            None => {
                own = self.uploaded(&state.frame.hair);
                (&own, DVec3::ZERO)
            }
        };
        let shot = Shot {
            view,
            positions,
            origin,
            frame: &state.frame,
            hair: coloured.then_some((values.as_slice(), self.ranges[0].0)),
            air: (!particles.is_empty()).then_some(Air { values: &particles, range: self.ranges[1].0, arrow }),
        };
        Ok(self.lines.draw(&shot)?)
    }

    fn uploaded(&self, hair: &HairFrame) -> wgpu::Buffer {
        let positions: Vec<[f32; 4]> = hair.positions.iter().map(|&[x, y, z]| [x, y, z, 0.0]).collect();
        self.gpu.device().create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("positions of a film"),
            contents: bytemuck::cast_slice(&positions),
            usage: wgpu::BufferUsages::STORAGE,
        })
    }

    /// The picture over this part of the window; nothing before there is one.
    pub(crate) fn over(&self, rect: Rect) -> Option<PaintCallback> {
        self.blit.over(rect)
    }

    /// What is shown, in the film look drawn again and waited for; none before the first picture.
    pub(crate) fn read(&mut self, state: &State) -> Result<Option<RgbaImage>, ExportError> {
        match (self.drawn, &self.renderer) {
            (Some((.., looks, _)), Some((_, renderer))) if looks.look == Look::Film => {
                renderer.render(&state.frame).map(Some)
            }
            (Some(_), _) => self.lines.read(),
            (None, _) => Ok(None),
        }
    }

    /// Values of the last colours, of hair and of air.
    pub(crate) fn ranges(&self) -> [f32; 2] {
        self.ranges.map(|range| range.0)
    }
}
