//! Strands that are not finite are reset; clamps and bodies move; wind enters; air moves, and hair drifts among it.

use windswept_shaders::{common::reduce::TERMS, forcing, reduce};

use crate::{
    recorder::{Decision, Recorder},
    setup::Setup,
    step::{ONE_WORKGROUP, Plan},
};

/// Decisions of this stage.
#[derive(Debug, Clone)]
pub struct ForcingPlan {
    /// Whether the wind draws the air behind the faces that it enters through, and is held at what it is there.
    pub fringe: Decision,
    /// Whether the frame goes with a body.
    pub follows: Decision,
    /// Whether pins go with bodies.
    pub pins: Decision,
    /// Whether roots go with triangles of bodies that deform.
    pub bonds: Decision,
}

pub(super) fn plan(setup: &Setup<'_>) -> ForcingPlan {
    let has_fringe = setup.scene.air.as_ref().is_some_and(|air| air.fringe > 0.0);
    let on_body = setup.initial.pins.iter().any(|pin| pin.body.is_some());
    ForcingPlan {
        fringe: Decision::when(has_fringe, "air.fringe is 0"),
        follows: Decision::when(setup.scene.followed().is_some(), "air.follows names no body"),
        pins: Decision::when(on_body, "no pin goes with a body"),
        bonds: Decision::when(setup.sizes().bonds > 0, "no hair is on a body that deforms"),
    }
}

/// Records the passes of this stage.
pub fn record(r: &mut Recorder<'_>, plan: &Plan) {
    r.stage("forcing");
    let (n, c, fringe_deficit) = (r.sizes(), &plan.conditions, r.state().fringe_deficit);
    r.when(&plan.forcing.follows, |r| {
        r.run(&forcing::FRAME, "the frame goes with a body", 1);
    });
    record_wind(r, plan);
    record_bodies(r, plan);
    r.when(&c.hair, |r| {
        r.when(&c.recover, |r| {
            r.run(&forcing::RESET, "a strand that is not finite starts from rest", n.strands);
        });
        r.when(&plan.forcing.follows, |r| {
            r.run(&forcing::CARRY, "hair keeps its velocity in the world", n.strands);
        });
        r.when(&plan.forcing.bonds, |r| {
            r.run(&forcing::BONDS, "roots go with triangles", n.strands);
        });
        r.run(&forcing::ROOTS, "where clamps go", n.strands);
        r.when(&plan.forcing.pins, |r| {
            r.run(&forcing::PINS, "pins go with bodies", n.hair_points);
        });
        r.when(&c.neighbours, |r| {
            r.run(&forcing::HAIR_DRIFT, "hair drifts among air", n.hair_points);
        });
        r.when(&c.pressed_hair, |r| {
            r.run(&forcing::EXTRAPOLATE, "the velocity that hair counts with", n.strands);
        });
    });
    r.when(&c.wind(), |r| {
        r.when(&plan.forcing.fringe, |r| {
            r.run(&forcing::FRINGE_DEFICIT, "deficit of the wind in the fringe", n.air().div_ceil(TERMS));
            r.run(&reduce::TOTAL, "total deficit", ONE_WORKGROUP).bind("totals", &fringe_deficit);
        });
        r.run(&forcing::FRINGE, "wind enters", n.air());
    });
    r.when(&c.fields, |r| {
        r.when(&c.wind(), |r| {
            r.run(&forcing::DRIVE_AIR, "force fields draw air", n.air());
        });
    });
    r.when(&c.pushes, |r| {
        r.when(&c.wind(), |r| {
            r.run(&forcing::PUSH_AIR, "the force that was set pushes air", n.air());
        });
    });
    r.when(&c.pbf, |r| {
        r.run(&forcing::PREDICT, "air moves", n.air());
    });
    r.when(&c.divergence, |r| {
        r.run(&forcing::ADVANCE, "air moves on as pressure last changed it", n.air());
    });
    record_walls(r, plan);
}

/// Records the mean wind of the next step, and the strengths of the force fields.
pub fn record_wind(r: &mut Recorder<'_>, plan: &Plan) {
    r.stage("forcing");
    let c = &plan.conditions;
    r.when(&c.blows, |r| {
        r.run(&forcing::MEAN_WIND, "mean wind of the step", ONE_WORKGROUP);
    });
    r.when(&c.fields, |r| {
        r.when(&c.blows, |r| {
            r.run(&forcing::FIELD_STRENGTHS, "strengths of the force fields", 1);
        });
    });
}

/// Records where bodies are in the next step.
pub fn record_bodies(r: &mut Recorder<'_>, plan: &Plan) {
    r.stage("forcing");
    r.when(&plan.conditions.bodies, |r| {
        r.run(&forcing::BODIES, "bodies move", r.sizes().bodies);
    });
}

/// Records the walls that bodies are to the air.
pub fn record_walls(r: &mut Recorder<'_>, plan: &Plan) {
    r.stage("forcing");
    r.when(&plan.conditions.walls, |r| {
        r.run(&forcing::WALLS, "walls of bodies to air", r.sizes().particles);
    });
}
