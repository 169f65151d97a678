//! Strengthen the eddies of each band (eqs. 2, 4-6), air only.

use windswept_shaders::{common::reduce::TERMS, reduce, turbulence};

use crate::{
    array::AnyArray,
    plan::{BandPlan, Plan},
    recorder::Recorder,
    step::{ONE_WORKGROUP, neighbours},
};

/// Records the passes of this stage.
pub fn record(r: &mut Recorder<'_>, plan: &Plan) {
    r.stage("turbulence");
    let n = &plan.sizes;
    let s = r.state();
    r.when(&plan.turbulence, |r| {
        r.when(&plan.direct_filter, |r| prepare_direct(r, plan));
        if plan.published_law {
            vorticity(r, plan, &s.new_velocity);
        }
        for band in &plan.bands {
            r.for_band(band.index, |r| {
                r.when(&band.runs, |r| {
                    filter(r, plan, band);
                    if !plan.published_law {
                        vorticity(r, plan, &s.band_velocity);
                    }
                    r.dispatch_neighbours(&turbulence::CONFINE, "vorticity confinement", n.clusters_of_air())
                        .bind("band", &s.band.at(band.law));
                });
            });
        }
        r.run(&reduce::CHANGES, "sums of the changes", n.air().div_ceil(TERMS)).bind("changes", &s.confinement);
        r.run(&reduce::TOTAL, "totals of the changes", ONE_WORKGROUP).bind("totals", &s.confinement_total);
        r.run(&turbulence::STRENGTHEN, "eddies are strengthened", n.air());
    });
}

/// Records the vorticity of the air's velocity, for pictures.
pub fn record_vorticity(r: &mut Recorder<'_>, plan: &Plan) {
    r.stage("turbulence");
    let velocity = r.state().new_velocity;
    r.when(&plan.neighbours, |r| vorticity(r, plan, &velocity));
}

/// Records the velocity of the first band.
pub fn record_band(r: &mut Recorder<'_>, plan: &Plan) {
    r.stage("turbulence");
    r.when(&plan.turbulence, |r| {
        r.when(&plan.direct_filter, |r| prepare_direct(r, plan));
        plan.bands.iter().take(1).for_each(|band| filter(r, plan, band));
    });
}

/// The direct filter takes the order of the neighbour search, and where its particles are by now.
fn prepare_direct(r: &mut Recorder<'_>, plan: &Plan) {
    r.run(&turbulence::LOCATE, "where sorted particles are now", plan.sizes.particles);
    r.run(&turbulence::WEIGH, "terms of the filter", plan.sizes.particles);
}

fn filter(r: &mut Recorder<'_>, plan: &Plan, band: &BandPlan) {
    r.when(&plan.direct_filter, |r| direct(r, band));
    r.when(&plan.grid_filter, |r| grid(r, plan, band));
}

fn direct(r: &mut Recorder<'_>, band: &BandPlan) {
    for &(task, invocations) in &band.tasks {
        let uniform = r.state().band.at(task);
        r.run(&turbulence::BAND, "band velocity by direct sum", invocations).bind("band", &uniform);
    }
}

fn grid(r: &mut Recorder<'_>, plan: &Plan, band: &BandPlan) {
    let s = r.state();
    let (axis, _) = band.axes[0];
    let (params, mesh) = (s.params.at(band.cells), s.mesh.at(axis));
    r.when(&band.deposit, |r| {
        neighbours::sort(r, band.cells, &band.sort, &s.flow_sorted);
        r.run(&turbulence::WEIGH, "terms of the filter", plan.sizes.air())
            .bind("params", &params)
            .bind("sorted", &s.flow_sorted);
        r.run(&turbulence::DEPOSIT, "air onto the filter's grid", band.blocks).bind("mesh", &mesh);
    });
    let smooth = [
        (&turbulence::SMOOTH_X, "smooth along x"),
        (&turbulence::SMOOTH_Y, "smooth along y"),
        (&turbulence::SMOOTH_Z, "smooth along z"),
    ];
    for ((pass, label), (axis, invocations)) in smooth.into_iter().zip(band.axes) {
        r.run(pass, label, invocations).bind("mesh", &s.mesh.at(axis));
    }
    r.run(&turbulence::GATHER, "band velocity from the grid", plan.sizes.air())
        .bind("params", &params)
        .bind("mesh", &mesh)
        .bind("sorted", &s.flow_sorted);
}

fn vorticity(r: &mut Recorder<'_>, plan: &Plan, field: &AnyArray) {
    r.dispatch_neighbours(&turbulence::VORTICITY, "vorticity", plan.whirling_clusters()).bind("field", field);
}
