//! One step, in execution order. Read this file first.

pub mod commit;
mod conditions;
pub mod contact;
pub mod fluid;
pub mod forcing;
pub mod neighbours;
pub mod rods;
pub mod turbulence;
pub mod viscosity;

use crate::{
    recorder::{Recorder, Recording},
    setup::Setup,
    state::State,
};
pub use conditions::Conditions;

/// Invocations of a pass that is one workgroup: any number up to its size.
const ONE_WORKGROUP: u32 = 1;

/// Records one step.
pub fn record(r: &mut Recorder<'_>, plan: &Plan) {
    forcing::record(r, plan); //      1. Reset invalid strands; clamps, bodies, air move; wind enters; hair drifts.
    neighbours::record(r, plan); // 2. Sort particles into cells, list neighbours.
    fluid::record(r, plan); //      3. Air stays incompressible: by pressures, or a density constraint (eq. 1).
    rods::record(r, plan); //       4. Strands keep their length and shape, and stay out of bodies.
    contact::record(r, plan); //    5. Air flows around bodies.
    turbulence::record(r, plan); // 6. Strengthen the eddies of each band (eqs. 2 to 6), air only.
    viscosity::record(r, plan); //  7. Neighbours share velocity (eqs. 7, 8).
    commit::record(r, plan); //      8. Commit, or freeze and report.
}

/// Decisions about which passes run, made once from the scene; the stages `contact` and `commit` follow from the
/// conditions. `windswept plan` prints them.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Conditions that several stages decide by.
    pub conditions: Conditions,
    /// Decisions of stage `forcing`.
    pub forcing: forcing::ForcingPlan,
    /// Decisions of stage `neighbours`.
    pub neighbours: neighbours::NeighboursPlan,
    /// Decisions of stage `fluid`.
    pub fluid: fluid::FluidPlan,
    /// Decisions of stage `rods`.
    pub rods: rods::RodsPlan,
    /// Decisions of stage `turbulence`.
    pub turbulence: turbulence::TurbulencePlan,
    /// Decisions of stage `viscosity`.
    pub viscosity: viscosity::ViscosityPlan,
}

impl Plan {
    /// The plan of a scene.
    #[must_use]
    pub fn new(setup: &Setup<'_>) -> Self {
        let conditions = Conditions::new(setup);
        Self {
            forcing: forcing::plan(setup),
            neighbours: neighbours::plan(setup),
            fluid: fluid::plan(setup, &conditions),
            rods: rods::plan(setup, &conditions),
            turbulence: turbulence::plan(setup, &conditions),
            viscosity: viscosity::plan(setup, &conditions),
            conditions,
        }
    }

    /// Lets the wind's passes run from now on, as the caller sets it, whether it blows or is zero: these passes also
    /// take from the air the wind that blew before. Says whether other passes run now.
    pub fn set_wind(&mut self, blows: bool) -> bool {
        let before = (self.conditions.blows.clone(), self.fluid.deformation.clone());
        self.conditions.set_wind();
        self.fluid.set_wind(&self.conditions, blows || self.conditions.fields.runs);
        before != (self.conditions.blows.clone(), self.fluid.deformation.clone())
    }

    /// Lets the force that the caller sets push from now on, or lets it push no longer. It reaches air through the
    /// wind's passes.
    pub fn set_force(&mut self, is_set: bool) {
        self.conditions.set_force(is_set);
    }

    /// Lets the passes run from now on that recover strands: those that are not finite, or that a caller has written. A
    /// step freezes where there is such a strand and no pass recovers it.
    pub fn recover_strands(&mut self) {
        self.conditions.recover = self.conditions.hair.clone();
    }

    /// Whether the passes that recover strands run, or no strands need them.
    pub(crate) fn recovers_strands(&self) -> bool {
        self.conditions.recover == self.conditions.hair
    }
}

/// Records how air beside bodies gets its velocity before the first step. The passes run over the state copied to
/// `predicted` and `new_velocity`, and over pressures of zero.
pub fn record_start(r: &mut Recorder<'_>, plan: &Plan) {
    r.when(&plan.conditions.walls, |r| {
        forcing::record_wind(r, plan);
        forcing::record_bodies(r, plan);
        forcing::record_walls(r, plan);
        neighbours::record(r, plan);
        fluid::record_start(r, plan);
    });
}

/// A quantity of the committed state, for reports and pictures. Its passes run over the state copied to `predicted` and
/// `new_velocity`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// The density ρ/ρ0.
    Density,
    /// The vorticity ω of the velocity.
    Vorticity,
}

/// Recordings that a simulation of this plan runs: its step, also as it is once a wind is set, which may be zero, or a
/// force, each also with the passes that recover strands, and the passes of each quantity.
#[must_use]
pub fn recordings(state: &State, plan: &Plan) -> Vec<Recording> {
    let set = |wind: Option<bool>, force: bool| {
        let mut plan = plan.clone();
        if let Some(blows) = wind {
            plan.set_wind(blows);
        }
        plan.set_force(force);
        plan
    };
    let winds = [None, Some(false), Some(true)];
    let plans = winds.into_iter().flat_map(|wind| [set(wind, false), set(wind, true)]);
    let steps = plans.flat_map(|mut plan| {
        let step = Recorder::record(state, |r| record(r, &plan));
        plan.recover_strands();
        [step, Recorder::record(state, |r| record(r, &plan))]
    });
    let quantities = [Quantity::Density, Quantity::Vorticity];
    let measured = quantities.map(|quantity| Recorder::record(state, |r| record_quantity(r, plan, quantity)));
    let start = Recorder::record(state, |r| record_start(r, plan));
    steps.chain(measured).chain([start]).collect()
}

/// Records the passes that a quantity takes.
pub fn record_quantity(r: &mut Recorder<'_>, plan: &Plan, quantity: Quantity) {
    neighbours::record(r, plan);
    match quantity {
        Quantity::Density => {
            forcing::record_bodies(r, plan);
            fluid::record_density(r, plan);
        }
        Quantity::Vorticity => turbulence::record_vorticity(r, plan),
    }
}
