//! One step, in execution order. Read this file first.

pub mod commit;
pub mod contact;
pub mod fluid;
pub mod forcing;
pub mod neighbours;
pub mod rods;
pub mod turbulence;
pub mod viscosity;

use crate::{
    plan::Plan,
    recorder::{Recorder, Recording},
    state::State,
};

/// Invocations of a pass that is one workgroup: any number up to its size.
const ONE_WORKGROUP: u32 = 1;

/// Records one step.
pub fn record(r: &mut Recorder<'_>, plan: &Plan) {
    forcing::record(r, plan); //      1. Bad strands are reset; clamps and bodies move; wind enters; air moves, hair drifts.
    neighbours::record(r, plan); // 2. Sort particles into cells, list who is near whom.
    fluid::record(r, plan); //      3. Nothing is compressed: by pressures, or a density constraint (eq. 1).
    rods::record(r, plan); //       4. Strands keep their length and shape, and stay out of bodies.
    contact::record(r, plan); //    5. Air flows around bodies.
    turbulence::record(r, plan); // 6. Strengthen the eddies of each band (eqs. 2, 4-6), air only.
    viscosity::record(r, plan); //  7. Neighbours share velocity (eqs. 7, 8).
    commit::record(r, plan); //      8. Commit, or freeze and report.
}

/// Records how air beside bodies gets its velocity before the first step. The passes run over the state copied to
/// `predicted` and `new_velocity`, and over pressures of zero.
pub fn record_start(r: &mut Recorder<'_>, plan: &Plan) {
    r.when(&plan.walls, |r| {
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

/// All that a simulation of this plan runs: its step, also as it is once a wind is set, which may be zero, or a force,
/// each also with the passes that recover strands, and the passes of each quantity.
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
