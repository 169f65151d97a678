//! How a simulation is shown: in a line, and drawn.

use std::sync::Arc;

use pyo3::{exceptions::PyValueError, prelude::*};
use windswept_export::{Followers, Renderer, image::RgbaImage};
use windswept_scene::{Camera, CheckedScene, LookAt};

use super::{Simulation, held::lock};
use crate::errors::{export_error, of_run, of_value};

impl Simulation {
    /// Names and values that describe it in a line.
    pub(super) fn facts(&self, py: Python<'_>) -> PyResult<Vec<(&'static str, String)>> {
        self.engine(py, |sim| {
            let counts = sim.counts();
            let mut facts = vec![
                ("scene", format!("{:?}", sim.scene().title)),
                ("strands", counts.strands.to_string()),
                ("hair points", counts.hair_points.to_string()),
                ("air particles", counts.air.to_string()),
                ("time", format!("{:.6} s", sim.time())),
                ("steps", sim.steps().to_string()),
                ("adapter", sim.engine().gpu().info().name.clone()),
            ];
            facts.extend(sim.ms_per_step().map(|ms| ("ms per step", format!("{ms:.2}"))));
            facts
        })
    }

    /// The hairs that the strands stand for; which ones they are is worked out once.
    pub(super) fn following(&self, engine: &windswept::Simulation) -> PyResult<Arc<Followers>> {
        let mut followers = lock(&self.followers);
        if let Some(followers) = &*followers {
            return Ok(followers.clone());
        }
        let made = Followers::with_groom(engine.scene(), &engine.hair_at_start(), engine.initial().followers.as_ref());
        let made = made.map_err(|error| export_error(&error))?;
        Ok(followers.insert(Arc::new(made)).clone())
    }

    /// A picture of the state now. The renderer is made once: roots near each other at the start share the hairs
    /// between them.
    pub(super) fn picture(&self, engine: &mut windswept::Simulation, camera: &Camera) -> PyResult<RgbaImage> {
        let frame = windswept_export::frame(engine).map_err(|error| of_run(&error))?;
        let mut renderer = lock(&self.renderer);
        let made = match renderer.take() {
            Some(made) => Ok(made),
            None => {
                let (gpu, start) = (engine.engine().gpu(), engine.hair_at_start());
                Renderer::with_groom(gpu, engine.scene(), &start, engine.initial().followers.as_ref())
            }
        };
        let renderer = renderer.insert(made.map_err(|error| export_error(&error))?);
        let drawn = renderer.look_through(camera).and_then(|()| renderer.render(&frame));
        drawn.map_err(|error| export_error(&error))
    }
}

/// Where a picture is taken from, of the arguments of `Simulation.render`.
pub(super) struct Shot {
    pub(super) camera: Option<String>,
    pub(super) eye: Option<[f64; 3]>,
    pub(super) target: Option<[f64; 3]>,
    pub(super) fov: Option<f64>,
    pub(super) size: [Option<u32>; 2],
}

impl Shot {
    /// The scene's camera of that name, or its first, with what is given in its place.
    pub(super) fn camera(self, scene: &CheckedScene) -> PyResult<Camera> {
        let named = |camera: &&Camera| self.camera.as_ref().is_none_or(|name| camera.name == *name);
        let Some(camera) = scene.cameras.iter().find(named) else {
            let names: Vec<&str> = scene.cameras.iter().map(|camera| &*camera.name).collect();
            let found = self.camera.unwrap_or_default();
            return Err(of_value("camera", format!("expected one of {}, found {found:?}", names.join(", "))));
        };
        let known = camera.look_at;
        let look_at = match (self.eye.or(known.map(|at| at.eye)), self.target.or(known.map(|at| at.target))) {
            (Some(eye), Some(target)) => Some(LookAt { eye, target }),
            (None, None) => None,
            (Some(_), None) => return Err(of_value("target", "expected one beside eye: the scene's camera has none")),
            (None, Some(_)) => return Err(of_value("eye", "expected one beside target: the scene's camera has none")),
        };
        let camera = Camera {
            look_at,
            fov: self.fov.unwrap_or(camera.fov),
            width: self.size[0].unwrap_or(camera.width),
            height: self.size[1].unwrap_or(camera.height),
            ..camera.clone()
        };
        camera.valid().map_err(|fault| PyValueError::new_err(fault.to_string()))?;
        Ok(camera)
    }
}

/// A side of a picture \[px\]; none is the scene's.
pub(super) fn side(name: &str, side: Option<i64>) -> PyResult<Option<u32>> {
    let fits = |side: i64| u32::try_from(side).ok().filter(|side| *side >= 16);
    let expected = |side: i64| of_value(name, format!("expected at least 16 pixels, found {side}"));
    side.map(|side| fits(side).ok_or_else(|| expected(side))).transpose()
}
