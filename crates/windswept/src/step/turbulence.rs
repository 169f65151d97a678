//! 7. Strengthen the eddies of each band (eqs. 2, 4-6), air only.

use windswept_shaders::turbulence;

use crate::{
    plan::{BandPlan, Plan},
    recorder::Recorder,
    state::{Array, State},
    step::neighbours,
};

/// Invocations of `turbulence/mean`: one workgroup.
const ONE_WORKGROUP: u32 = 1;

/// Records the passes of this heading.
pub fn record(r: &mut Recorder, s: &State, plan: &Plan) {
    r.heading("7. turbulence");
    let n = &plan.sizes;
    r.when(&plan.turbulence, |r| {
        r.when(&plan.direct_filter, |r| weigh(r, s, plan));
        if plan.published_law {
            vorticity(r, s, plan, &s.new_velocity);
        }
        for band in &plan.bands {
            r.for_band(band.index, |r| {
                r.when(&band.runs, |r| {
                    filter(r, s, plan, band);
                    if !plan.published_law {
                        vorticity(r, s, plan, &s.band_velocity);
                    }
                    confine(r, s, plan, band);
                });
            });
        }
        r.run(&turbulence::SUM, "sum of the changes", n.air(), &[&s.params, &s.confinement, &s.partial_sum]);
        r.run(
            &turbulence::MEAN,
            "mean change of the air",
            ONE_WORKGROUP,
            &[&s.params, &s.status, &s.partial_sum, &s.mean_confinement],
        );
        r.run(
            &turbulence::STRENGTHEN,
            "eddies are strengthened",
            n.air(),
            &[&s.params, &s.status, &s.confinement, &s.mean_confinement, &s.new_velocity],
        );
    });
}

/// Records the vorticity of the air's velocity, for pictures.
pub fn record_vorticity(r: &mut Recorder, s: &State, plan: &Plan) {
    r.heading("7. turbulence");
    r.when(&plan.neighbours, |r| vorticity(r, s, plan, &s.new_velocity));
}

/// Records the velocity of the first band.
pub fn record_band(r: &mut Recorder, s: &State, plan: &Plan) {
    r.heading("7. turbulence");
    r.when(&plan.turbulence, |r| {
        r.when(&plan.direct_filter, |r| weigh(r, s, plan));
        plan.bands.iter().take(1).for_each(|band| filter(r, s, plan, band));
    });
}

fn weigh(r: &mut Recorder, s: &State, plan: &Plan) {
    r.run(
        &turbulence::WEIGH,
        "what the filter sums",
        plan.sizes.particles,
        &[&s.params, &s.status, &s.sorted, &s.predicted, &s.new_velocity, &s.flow_position, &s.flow],
    );
}

fn filter(r: &mut Recorder, s: &State, plan: &Plan, band: &BandPlan) {
    r.when(&plan.direct_filter, |r| direct(r, s, band));
    r.when(&plan.grid_filter, |r| grid(r, s, plan, band));
}

fn direct(r: &mut Recorder, s: &State, band: &BandPlan) {
    for &(task, invocations) in &band.pairs {
        r.run(
            &turbulence::BAND,
            "band velocity by direct sum",
            invocations,
            &[
                &s.params,
                &s.status,
                &s.band.at(task),
                &s.cell_start,
                &s.sorted,
                &s.sorted_position,
                &s.flow_position,
                &s.flow,
                &s.band_velocity,
            ],
        );
    }
}

fn grid(r: &mut Recorder, s: &State, plan: &Plan, band: &BandPlan) {
    let (mesh, _) = band.axes[0];
    let params = s.params.at(band.cells);
    r.when(&band.deposit, |r| {
        neighbours::sort(r, s, &params, plan.sizes.particles, band.buckets);
        weigh(r, s, plan);
        r.run(
            &turbulence::DEPOSIT,
            "air onto the filter's grid",
            band.blocks,
            &[
                &params,
                &s.status,
                &s.mesh.at(mesh),
                &s.cell_start,
                &s.sorted_position.named("flow_position"),
                &s.flow,
                &s.deposited,
            ],
        );
    });
    smooth(r, s, "smooth along x", band.axes[0], [&s.deposited, &s.deposited], [&s.smoothed, &s.curvature]);
    smooth(r, s, "smooth along y", band.axes[1], [&s.smoothed, &s.curvature], [&s.smoother, &s.smoother_curvature]);
    smooth(r, s, "smooth along z", band.axes[2], [&s.smoother, &s.smoother_curvature], [&s.smoothed, &s.curvature]);
    r.run(
        &turbulence::GATHER,
        "band velocity from the grid",
        plan.sizes.particles,
        &[
            &s.params,
            &s.status,
            &s.mesh.at(mesh),
            &s.sorted,
            &s.sorted_position.named("flow_position"),
            &s.curvature,
            &s.band_velocity,
        ],
    );
}

fn smooth(
    r: &mut Recorder,
    s: &State,
    label: &'static str,
    (task, invocations): (usize, u32),
    [smoothed, curvature]: [&Array; 2],
    [smoother, smoother_curvature]: [&Array; 2],
) {
    r.run(
        &turbulence::SMOOTH,
        label,
        invocations,
        &[
            &s.params,
            &s.status,
            &s.mesh.at(task),
            &s.taps,
            &smoothed.named("smoothed"),
            &curvature.named("curvature"),
            &smoother.named("smoother"),
            &smoother_curvature.named("smoother_curvature"),
        ],
    );
}

fn vorticity(r: &mut Recorder, s: &State, plan: &Plan, field: &Array) {
    r.run(
        &turbulence::VORTICITY,
        "vorticity",
        plan.sizes.particles,
        &[
            &s.params,
            &s.status,
            &s.predicted,
            &s.neighbour_range,
            &s.neighbour_list,
            &field.named("field"),
            &s.vorticity,
        ],
    );
}

fn confine(r: &mut Recorder, s: &State, plan: &Plan, band: &BandPlan) {
    r.run(
        &turbulence::CONFINE,
        "vorticity confinement",
        plan.sizes.air(),
        &[
            &s.params,
            &s.status,
            &s.band.at(band.law),
            &s.predicted,
            &s.neighbour_range,
            &s.neighbour_list,
            &s.band_velocity,
            &s.vorticity,
            &s.confinement,
        ],
    );
}
