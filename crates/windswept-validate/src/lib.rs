//! Checks of what the engine computes on a GPU, against formulas and numbers that were computed independently of it.
//!
//! A [`Check`] measures on the GPU, through [`windswept_engine::ops`] and [`windswept_engine::Simulation`], and returns
//! a [`Row`] per claim. `windswept validate` prints the rows, `tests/formulas.rs` asserts them: each formula is written
//! once. The expected values come from closed forms, from `windswept_reference::tables` or from the f64 reference;
//! every row says which.

mod air;
mod confine;
mod contact;
mod coupled;
mod exchange;
mod fluid;
mod force;
mod friction;
mod hair_in_wind;
mod kernels;
mod momentum;
mod pressure;
mod reference;
mod rods;
mod row;
mod runner;
mod scenes;
pub mod stress;
mod taylor_green;
mod tuft;
mod turbulence;
mod viscosity;
mod vortex;
mod walls;
mod whole;
mod wind;

pub use row::{Role, Row, Sweep};

/// Air and strands that the repository's tests and benches measure on as well; they may change in any version.
#[doc(hidden)]
pub mod internals {
    pub use crate::{
        air::{Cloud, MASS, RADIUS, REST_DENSITY, SIMPLE, STEP, VOLUME, rms, scene as air_scene, vectors, waves},
        exchange::{STRIP_BLOCKAGE, in_strip, through},
        pressure::{energy_left, stirred},
        rods::{
            BEND_OVER_TWIST, GRAVITY, Hanging, LENGTH, LINE_DENSITY, Rod, SEGMENTS, STRETCH, build, mode,
            scene as rods_scene, tips,
        },
        scenes::{alone, in_wind},
        stress::chain_tip,
        vortex::circulation_kept,
        walls::Tunnel,
    };
}

use std::fmt;

use windswept_engine::{Gpu, GpuError, RunError, ops::OpsError};
use windswept_scene::SceneError;

/// Rows that are measured together.
#[derive(Debug, Clone, Copy)]
pub struct Check {
    /// Subject of the check, in a word.
    pub name: &'static str,
    run: fn(&Gpu) -> Result<Vec<Row>, Error>,
}

impl Check {
    /// Measures the check's rows. A check that could not be done is one row that fails and says why.
    #[must_use]
    pub fn rows(&self, gpu: &Gpu) -> Vec<Row> {
        (self.run)(gpu).unwrap_or_else(|error| vec![Row::failed(self.name, &error)])
    }
}

/// Every check, in the order of the step.
pub const CHECKS: &[Check] = &[
    Check { name: "kernels", run: kernels::normalisations },
    Check { name: "lattices", run: kernels::lattices },
    Check { name: "wind", run: wind::drive },
    Check { name: "drag", run: wind::drag },
    Check { name: "force-fields", run: force::fields },
    Check { name: "set-force", run: force::set },
    Check { name: "density", run: fluid::density_error },
    Check { name: "rods-rest", run: rods::at_rest },
    Check { name: "rods-static", run: rods::hanging },
    Check { name: "rods-beam", run: rods::beam },
    Check { name: "rods-fall", run: rods::falling },
    Check { name: "contact", run: contact::bodies },
    Check { name: "rotation", run: turbulence::rotation },
    Check { name: "translation", run: turbulence::translation },
    Check { name: "filter-leak", run: turbulence::leak },
    Check { name: "filter-gain", run: turbulence::gain },
    Check { name: "confinement", run: confine::laws },
    Check { name: "vortex", run: vortex::lamb_oseen },
    Check { name: "shear-wave", run: viscosity::shear_waves },
    Check { name: "taylor-green", run: viscosity::taylor_green },
    Check { name: "pressure", run: pressure::rows },
    Check { name: "bodies-in-air", run: walls::rows },
    Check { name: "momentum", run: momentum::closed_box },
    Check { name: "coupled", run: coupled::drag },
    Check { name: "hair-in-wind", run: hair_in_wind::prescribed },
    Check { name: "hair-two-way", run: hair_in_wind::two_way },
    Check { name: "hair-limits", run: hair_in_wind::limits },
    Check { name: "exchange", run: exchange::rows },
    Check { name: "friction", run: friction::rows },
    Check { name: "mat", run: friction::mat },
    Check { name: "reference", run: reference::passes },
    Check { name: "reference-rods", run: reference::rods },
    Check { name: "reference-step", run: whole::steps },
];

/// Checks that take long on a software adapter; `tests/exchange.rs` asserts them.
pub const LONG_CHECKS: &[Check] = &[
    Check { name: "pressure-limits", run: pressure::limits },
    Check { name: "taylor-green-3d", run: taylor_green::rows },
    Check { name: "tuft", run: tuft::rows },
    Check { name: "fixed-wide", run: exchange::fixed_wide },
    Check { name: "strip", run: exchange::strip },
    Check { name: "strip-halved", run: exchange::strip_halved },
    Check { name: "bundle", run: exchange::bundle },
    Check { name: "mat-for-long", run: friction::mat_for_long },
    Check { name: "contact-rests", run: contact::rests },
    Check { name: "bodies-in-wind", run: walls::large },
];

/// A check that could not be done.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A single pass failed.
    #[error(transparent)]
    Ops(#[from] OpsError),
    /// A run that could not go on.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The device failed.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// A check's own scene is at fault.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A simulation that could not be made.
    #[error(transparent)]
    Simulation(#[from] windswept_engine::Error),
    /// The state that a check needs did not come about.
    #[error("{0}")]
    Missing(String),
}

/// The text of [`fmt::Display`], which a `main` that returns the error prints.
impl fmt::Debug for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}
