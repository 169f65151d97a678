//! How a simulation is shown: in a line, and drawn.

use std::sync::Arc;

use pyo3::prelude::*;
use windswept_export::{Followers, Renderer};

use super::{Picture, Simulation, held::lock};
use crate::errors::{export_error, of_value};

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

    /// Made once per size: roots near each other at the start share the hairs between them.
    pub(super) fn renderer(&self, engine: &windswept::Simulation, size: Picture) -> PyResult<Arc<Renderer>> {
        let mut renderer = lock(&self.renderer);
        if let Some((of, renderer)) = &*renderer
            && *of == size
        {
            return Ok(renderer.clone());
        }
        let scene = engine.scene().assuming(|_, values| {
            let camera = &mut values.camera;
            camera.width = size.0.unwrap_or(camera.width);
            camera.height = size.1.unwrap_or(camera.height);
        });
        let start = engine.hair_at_start();
        let made = Renderer::with_groom(engine.engine().gpu(), &scene, &start, engine.initial().followers.as_ref());
        let made = made.map_err(|error| export_error(&error))?;
        let made = Arc::new(made);
        *renderer = Some((size, made.clone()));
        Ok(made)
    }
}

/// A side of a picture \[px\]; none is the scene's.
pub(super) fn side(name: &str, side: Option<i64>) -> PyResult<Option<u32>> {
    let fits = |side: i64| u32::try_from(side).ok().filter(|side| *side >= 16);
    let expected = |side: i64| of_value(name, format!("expected at least 16 pixels, found {side}"));
    side.map(|side| fits(side).ok_or_else(|| expected(side))).transpose()
}
