//! Conditions that several stages decide by.

use windswept_scene::{CheckedAir, CheckedScene, FluidSolver, Law, Model};

use crate::{recorder::Decision, setup::Setup};

/// Conditions of a scene, each with the reason why it does not hold.
#[derive(Debug, Clone)]
pub struct Conditions {
    /// There are strands.
    pub hair: Decision,
    /// There are air particles.
    pub air: Decision,
    /// There are bodies.
    pub bodies: Decision,
    /// There are force fields that do something.
    pub fields: Decision,
    /// Air or the mean wind drags hair.
    pub drag: Decision,
    /// There is something for a wind to act on: air particles, or hair that the mean wind drags.
    exposed: Decision,
    /// A wind or force fields act on air or hair.
    pub blows: Decision,
    /// A force was set that pushes hair and air.
    pub pushes: Decision,
    /// Strands that are not finite are held, and put into their rest shape.
    pub recover: Decision,
    /// Air is integrated with its moves: with solver pbf.
    pub pbf: Decision,
    /// Velocities are freed of divergence by a pressure.
    pub divergence: Decision,
    /// Bodies are walls to the air's pressure.
    pub walls: Decision,
    /// Eddies of some band are strengthened.
    pub turbulence: Decision,
    /// Neighbours exchange velocity by XSPH.
    pub viscosity: Decision,
    /// Particles meet, so that the neighbour list is made.
    pub neighbours: Decision,
    /// Pressure acts on hair as on air.
    pub pressed_hair: Decision,
}

impl Conditions {
    pub(crate) fn new(setup: &Setup<'_>) -> Self {
        let (scene, sizes) = (setup.scene, setup.sizes());
        let hair = Decision::when(sizes.strands > 0, "the scene has no hair");
        let bodies = Decision::when(sizes.bodies > 0, "the scene has no bodies");
        let air = match scene.interaction.model {
            Model::Particles | Model::TwoWay => Decision::when(sizes.air() > 0, "the scene has no air particles"),
            Model::Drag => Decision::when(false, "interaction.model is drag: no air particles"),
            Model::None => Decision::when(false, "interaction.model is none: hair alone"),
        };
        let drag = hair.and(match scene.interaction.model {
            Model::Drag => Decision::YES,
            Model::Particles | Model::TwoWay => Decision::when(air.runs, "no air moves"),
            Model::None => air.clone(),
        });
        let exposed = if drag.runs { Decision::YES } else { air.clone() };
        let fields = Decision::unless(scene.why_no_fields());
        let is_still = scene.air.as_ref().is_none_or(CheckedAir::is_still) && !fields.runs;
        let two_way = scene.interaction.model == Model::TwoWay;
        let is_pbf = scene.fluid.solver == FluidSolver::Pbf;
        let divergence = air.and(Decision::when(!is_pbf, "fluid.solver is pbf"));
        let turbulence = air.and(Decision::unless(why_no_turbulence(scene)));
        let viscous = scene.viscosity.acts();
        let neighbours = air.and(Decision::when(
            scene.fluid.iterations > 0 || !is_pbf || viscous || turbulence.runs || (two_way && hair.runs),
            "neither density nor viscosity nor turbulence nor hair asks for neighbours",
        ));
        Self {
            blows: exposed.and(Decision::when(!is_still, "air.wind is zero")),
            pushes: pushes(false),
            recover: hair.and(Decision::when(false, "until a strand is not finite or hair is set")),
            pbf: air.and(Decision::when(is_pbf, "fluid.solver is divergence")),
            walls: divergence.and(bodies.clone()),
            viscosity: air
                .and(Decision::when(viscous, "viscosity.hair, viscosity.air and viscosity.smagorinsky are 0")),
            pressed_hair: divergence
                .and(hair.clone())
                .and(neighbours.clone())
                .and(Decision::when(!two_way, "interaction.model is two-way: hair and air exchange drag")),
            hair,
            air,
            bodies,
            fields,
            drag,
            exposed,
            divergence,
            turbulence,
            neighbours,
        }
    }

    /// Whether a wind or force fields act on air particles.
    pub(crate) fn wind(&self) -> Decision {
        self.air.and(self.blows.clone())
    }

    /// Lets the wind's passes run from now on, also while it is zero.
    pub(crate) fn set_wind(&mut self) {
        self.blows = self.exposed.clone();
    }

    /// Lets a force push, which reaches air through the wind's passes, or lets it push no longer.
    pub(crate) fn set_force(&mut self, is_set: bool) {
        self.pushes = pushes(is_set);
        if is_set {
            self.set_wind();
        }
    }
}

fn pushes(is_set: bool) -> Decision {
    Decision::when(is_set, "no force was set")
}

/// The reason why no band of eddies is strengthened.
fn why_no_turbulence(scene: &CheckedScene) -> Option<&'static str> {
    let turbulence = &scene.turbulence;
    if turbulence.bands.is_empty() {
        Some("the scene names no turbulence.bands")
    } else if turbulence.bands.iter().all(|band| band.strength <= 0.0) {
        Some("all turbulence.bands have strength 0")
    } else if turbulence.law == Law::Band && turbulence.speed == 0.0 {
        Some("turbulence.speed is 0: nothing to measure the bands against")
    } else {
        None
    }
}
