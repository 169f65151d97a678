//! Strands that are not finite are reset; clamps and bodies move; wind enters; air moves, and hair drifts among it.

use windswept_shaders::{common::reduce::TERMS, forcing, reduce};

use crate::{plan::Plan, recorder::Recorder, step::ONE_WORKGROUP};

/// Records the passes of this stage.
pub fn record(r: &mut Recorder<'_>, plan: &Plan) {
    r.stage("forcing");
    let (n, fringe_deficit) = (&plan.sizes, r.state().fringe_deficit);
    record_wind(r, plan);
    record_bodies(r, plan);
    r.when(&plan.hair, |r| {
        r.when(&plan.recover, |r| {
            r.run(&forcing::RESET, "a strand that is not finite starts from rest", n.strands);
        });
        r.run(&forcing::ROOTS, "where clamps go", n.strands);
        r.when(&plan.hair_meets_air, |r| {
            r.run(&forcing::HAIR_DRIFT, "hair drifts among air", n.hair_points);
        });
        r.when(&plan.pressed_hair, |r| {
            r.run(&forcing::EXTRAPOLATE, "the velocity that hair counts with", n.strands);
        });
    });
    r.when(&plan.wind, |r| {
        r.when(&plan.fringe, |r| {
            r.run(&forcing::FRINGE_DEFICIT, "deficit of the wind in the fringe", n.air().div_ceil(TERMS));
            r.run(&reduce::TOTAL, "total deficit", ONE_WORKGROUP).bind("totals", &fringe_deficit);
        });
        r.run(&forcing::FRINGE, "wind enters", n.air());
    });
    r.when(&plan.fields, |r| {
        r.when(&plan.wind, |r| {
            r.run(&forcing::DRIVE_AIR, "force fields draw air", n.air());
        });
    });
    r.when(&plan.pushes, |r| {
        r.when(&plan.wind, |r| {
            r.run(&forcing::PUSH_AIR, "the force that was set pushes air", n.air());
        });
    });
    r.when(&plan.pbf, |r| {
        r.run(&forcing::PREDICT, "air moves", n.air());
    });
    r.when(&plan.divergence, |r| {
        r.run(&forcing::ADVANCE, "air moves on as pressure last changed it", n.air());
    });
    record_walls(r, plan);
}

/// Records the mean wind of the next step, and the strengths of the force fields.
pub fn record_wind(r: &mut Recorder<'_>, plan: &Plan) {
    r.stage("forcing");
    r.when(&plan.blows, |r| {
        r.run(&forcing::MEAN_WIND, "mean wind of the step", ONE_WORKGROUP);
    });
    r.when(&plan.fields, |r| {
        r.when(&plan.blows, |r| {
            r.run(&forcing::FIELD_STRENGTHS, "strengths of the force fields", 1);
        });
    });
}

/// Records where bodies are in the next step.
pub fn record_bodies(r: &mut Recorder<'_>, plan: &Plan) {
    r.stage("forcing");
    r.when(&plan.bodies, |r| {
        r.run(&forcing::BODIES, "bodies move", plan.sizes.bodies);
    });
}

/// Records the walls that bodies are to the air.
pub fn record_walls(r: &mut Recorder<'_>, plan: &Plan) {
    r.stage("forcing");
    r.when(&plan.walls, |r| {
        r.run(&forcing::WALLS, "walls of bodies to air", plan.sizes.particles);
    });
}
