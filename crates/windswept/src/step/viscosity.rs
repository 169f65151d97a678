//! Neighbours share velocity (eqs. 7, 8).

use windswept_shaders::viscosity;

use crate::{plan::Plan, recorder::Recorder};

/// Records the passes of this stage.
pub fn record(r: &mut Recorder<'_>, plan: &Plan) {
    r.stage("viscosity");
    let n = &plan.sizes;
    r.when(&plan.limiter, |r| {
        r.dispatch_neighbours(&viscosity::LIMIT, "limit of the exchange", plan.limited_clusters.clone());
    });
    r.when(&plan.viscosity, |r| {
        r.dispatch_neighbours(&viscosity::XSPH, "XSPH viscosity", n.clusters_of_all());
    });
}
