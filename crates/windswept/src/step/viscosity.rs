//! 8. Neighbours share velocity (eqs. 7, 8).

use windswept_shaders::fluid;

use crate::{plan::Plan, recorder::Recorder};

/// Records the passes of this heading.
pub fn record(r: &mut Recorder<'_>, plan: &Plan) {
    r.heading("8. viscosity");
    let n = &plan.sizes;
    r.when(&plan.limiter, |r| {
        r.run(&fluid::LIMIT, "what XSPH may exchange", plan.limited_in_clusters);
    });
    r.when(&plan.viscosity, |r| {
        r.run(&fluid::VISCOSITY, "XSPH viscosity", n.in_clusters());
    });
}
