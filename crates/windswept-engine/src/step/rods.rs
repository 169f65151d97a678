//! Air drags strands, which keep their length and shape, and they slow the air.

use windswept_scene::{Model, Solver};
use windswept_shaders::rods;

use crate::{
    recorder::{Decision, Recorder},
    setup::Setup,
    step::{Plan, conditions::Conditions},
};

/// Decisions of this stage.
#[derive(Debug, Clone)]
pub struct RodsPlan {
    /// Whether hair and air particles exchange drag.
    pub exchange: Decision,
    /// Whether rods are solved by the direct solver.
    pub direct: Decision,
    /// Dispatches that the direct solver's Newton steps are cut into.
    pub newton_dispatches: u32,
    /// Whether Gauss-Seidel sweeps over strands.
    pub sweeps: Decision,
    /// Dispatches that Gauss-Seidel's sweeps are cut into.
    pub sweep_dispatches: u32,
}

pub(super) fn plan(setup: &Setup<'_>, c: &Conditions) -> RodsPlan {
    let (scene, params) = (setup.scene, &setup.params);
    let two_way = scene.interaction.model == Model::TwoWay;
    RodsPlan {
        exchange: c.neighbours.and(Decision::when(two_way, "only interaction.model two-way exchanges drag")),
        direct: Decision::when(scene.rods.solver == Solver::Direct, "rods.solver is gauss-seidel"),
        newton_dispatches: params.newton_steps / params.newton_part,
        sweeps: Decision::when(scene.rods.solver == Solver::GaussSeidel, "rods.solver is direct"),
        sweep_dispatches: scene.rods.iterations / params.rod_sweeps,
    }
}

/// Records the passes of this stage.
pub fn record(r: &mut Recorder<'_>, plan: &Plan) {
    r.stage("rods");
    let (n, c, rods) = (r.sizes(), &plan.conditions, &plan.rods);
    r.when(&c.hair, |r| {
        r.run(&rods::BEGIN, "start of hair points", n.hair_points);
        r.when(&rods.exchange, |r| {
            r.dispatch_neighbours(&rods::SAMPLE_AIR, "the air at hair points", n.clusters_of_hair());
        });
        r.when(&c.drag, |r| {
            r.when(&c.fields, |r| {
                r.run(&rods::SAMPLE_FIELDS, "the wind of force fields at hair points", n.hair_points);
            });
            r.run(&rods::DRAG, "air drags hair", n.strands);
        });
        r.when(&c.pushes, |r| {
            r.run(&rods::PUSH_HAIR, "the force that was set pushes hair", n.hair_points);
        });
        r.when(&c.bodies, |r| {
            r.run(&rods::CONTACTS, "how strands stand to bodies", n.strands);
        });
        r.run(&rods::PREDICT, "free moves, and where the solve starts", n.strands);
        r.when(&rods.direct, |r| {
            // Short dispatches: see `rods::newton_steps_per_dispatch`.
            r.repeat(rods.newton_dispatches, |r| {
                r.run(&rods::SOLVE, "Cosserat rods, solved directly", n.strands);
            });
        });
        r.when(&rods.sweeps, |r| {
            r.repeat(rods.sweep_dispatches, |r| {
                r.run(&rods::GAUSS_SEIDEL, "Cosserat rods by Gauss-Seidel", n.strands);
            });
        });
        r.run(&rods::UPDATE, "hair goes where its rods took it", n.strands);
        r.run(&rods::DRAG_IMPULSE, "impulse of drag on hair", n.hair_points);
        r.when(&c.pushes, |r| {
            r.run(&rods::EXCLUDE_PUSH, "the force that was set is no drag", n.hair_points);
        });
        r.when(&rods.exchange, |r| {
            r.dispatch_neighbours(&rods::REACT, "hair slows the air", n.clusters_of_air());
        });
    });
}
