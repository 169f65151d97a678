//! 8. Neighbours share velocity (eqs. 7, 8).

use windswept_shaders::fluid;

use crate::{plan::Plan, recorder::Recorder};

/// Records the passes of this heading.
pub fn record(r: &mut Recorder<'_>, plan: &Plan) {
    r.heading("8. viscosity");
    let n = &plan.sizes;
    r.when(&plan.limiter, |r| {
        r.meet(&fluid::LIMIT, "what XSPH may exchange", plan.limited_clusters.clone());
    });
    r.when(&plan.viscosity, |r| {
        r.meet(&fluid::VISCOSITY, "XSPH viscosity", n.clusters_of_all());
    });
}
