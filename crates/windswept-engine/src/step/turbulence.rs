//! Strengthen the eddies of each band (eqs. 2 to 6), air only.

use std::ops::Range;

use windswept_scene::Law;
use windswept_shaders::{
    common::{band::Band, list::PAGES, mesh::Mesh, params::Params, reduce::TERMS},
    reduce, turbulence,
};

use crate::{
    array::{AnyArray, Index},
    recorder::{Decision, Recorder},
    setup::Setup,
    step::{ONE_WORKGROUP, Plan, conditions::Conditions, neighbours},
    upload::{bands::invocations, params, sort::Sort},
};

/// Decisions of this stage.
#[derive(Debug, Clone)]
pub struct TurbulencePlan {
    /// Whether the confinement is that of the paper as printed.
    pub published_law: bool,
    /// The clusters that have a vorticity: of air, as printed of hair too.
    pub whirling_clusters: Range<u32>,
    /// Whether the velocity of a band is summed over all pairs.
    pub direct_filter: Decision,
    /// Whether the velocity of a band is found on a grid.
    pub grid_filter: Decision,
    /// Bands of eddies, in the order in which they run.
    pub bands: Vec<BandPlan>,
}

/// A band of eddies: whether it is strengthened, and the dispatches of its filter.
#[derive(Debug, Clone)]
pub struct BandPlan {
    /// Index into the scene's bands.
    pub index: usize,
    /// Whether the band is strengthened.
    pub runs: Decision,
    /// Element of `band` with its law.
    pub law: Index<Band>,
    /// Dispatches of the direct filter, at least one: the element of `band`, and the invocations.
    pub tasks: Vec<(Index<Band>, u32)>,
    /// Element of `params` with the cells of its grid.
    pub cells: Index<Params>,
    /// Whether the band fills a grid of its own; close bands share one.
    pub deposit: Decision,
    /// Blocks of nodes of the deposit.
    pub blocks: u32,
    /// How air is sorted into the cells of its grid.
    pub sort: Sort,
    /// Per axis: the element of `mesh`, and the invocations that smooth along it.
    pub axes: [(Index<Mesh>, u32); 3],
}

pub(super) fn plan(setup: &Setup<'_>, c: &Conditions) -> TurbulencePlan {
    let (turbulence, n) = (&setup.scene.turbulence, setup.sizes());
    let on_grid = turbulence.filter.is_grid();
    let published_law = turbulence.law == Law::Published;
    TurbulencePlan {
        published_law,
        whirling_clusters: if published_law { n.clusters_of_all() } else { n.clusters_of_air() },
        direct_filter: Decision::when(!on_grid, "turbulence.filter is grid"),
        grid_filter: Decision::when(on_grid, "turbulence.filter is direct"),
        bands: bands(setup, c),
    }
}

/// Bands in the order in which they run: those that share a grid follow one another. There is at least one, so that the
/// plan always names the passes of a band.
fn bands(setup: &Setup<'_>, c: &Conditions) -> Vec<BandPlan> {
    let (scene, params, cut, meshes) = (setup.scene, &setup.params, &setup.bands, &setup.meshes);
    let plan = |index: usize, runs: Decision| {
        let tasks = cut.ranges.get(index).cloned().unwrap_or(0..1);
        let mesh = meshes.bands.iter().find(|mesh| mesh.band == index);
        let first = mesh.map_or(0, |mesh| mesh.first);
        let smooth = mesh.map_or([0; 3], |mesh| mesh.smooth);
        let blocks = mesh.and_then(|mesh| mesh.deposit);
        let grid_params = mesh.map(|mesh| params::with_cells(params, meshes.grids[mesh.grid]));
        BandPlan {
            index,
            runs,
            law: Index::new(tasks.start),
            // Without air there are no tasks: never run, so that the plan can say of every pass why.
            tasks: tasks.map(|k| (Index::new(k), cut.tasks.get(k).map_or(0, invocations))).collect(),
            cells: Index::new(mesh.map_or(0, |mesh| PAGES as usize + mesh.grid)),
            deposit: Decision::when(blocks.is_some() || mesh.is_none(), "it shares the grid of the band before"),
            blocks: blocks.unwrap_or(0),
            sort: grid_params.as_ref().map_or_else(Sort::default, Sort::new),
            axes: [0, 1, 2].map(|axis| (Index::new(first + axis), smooth[axis])),
        }
    };
    let mut order: Vec<usize> = meshes.bands.iter().map(|mesh| mesh.band).collect();
    order.extend((0..scene.turbulence.bands.len()).filter(|i| !order.contains(i)).collect::<Vec<_>>());
    let strength = |i: usize| {
        let runs = scene.turbulence.bands[i].strength > 0.0;
        Decision::when(runs, format!("turbulence.bands.{i}.strength is 0"))
    };
    let all: Vec<_> = order.into_iter().map(|i| plan(i, strength(i))).collect();
    if all.is_empty() { vec![plan(0, c.turbulence.clone())] } else { all }
}

/// Records the passes of this stage.
pub fn record(r: &mut Recorder<'_>, plan: &Plan) {
    r.stage("turbulence");
    let (n, s) = (r.sizes(), r.state());
    r.when(&plan.conditions.turbulence, |r| {
        r.when(&plan.turbulence.direct_filter, |r| prepare_direct(r));
        if plan.turbulence.published_law {
            vorticity(r, plan, &s.new_velocity);
        }
        for band in &plan.turbulence.bands {
            r.for_band(band.index, |r| {
                r.when(&band.runs, |r| {
                    filter(r, plan, band);
                    if !plan.turbulence.published_law {
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
    r.when(&plan.conditions.neighbours, |r| vorticity(r, plan, &velocity));
}

/// Records the velocity of the first band.
pub fn record_band(r: &mut Recorder<'_>, plan: &Plan) {
    r.stage("turbulence");
    r.when(&plan.conditions.turbulence, |r| {
        r.when(&plan.turbulence.direct_filter, |r| prepare_direct(r));
        plan.turbulence.bands.iter().take(1).for_each(|band| filter(r, plan, band));
    });
}

/// The direct filter takes the order of the neighbour search, and where its particles are by now.
fn prepare_direct(r: &mut Recorder<'_>) {
    r.run(&turbulence::LOCATE, "where sorted particles are now", r.sizes().particles);
    r.run(&turbulence::WEIGH, "terms of the filter", r.sizes().particles);
}

fn filter(r: &mut Recorder<'_>, plan: &Plan, band: &BandPlan) {
    r.when(&plan.turbulence.direct_filter, |r| direct(r, band));
    r.when(&plan.turbulence.grid_filter, |r| grid(r, band));
}

fn direct(r: &mut Recorder<'_>, band: &BandPlan) {
    for &(task, invocations) in &band.tasks {
        let uniform = r.state().band.at(task);
        r.run(&turbulence::BAND, "band velocity by direct sum", invocations).bind("band", &uniform);
    }
}

fn grid(r: &mut Recorder<'_>, band: &BandPlan) {
    let s = r.state();
    let (axis, _) = band.axes[0];
    let (params, mesh) = (s.params.at(band.cells), s.mesh.at(axis));
    r.when(&band.deposit, |r| {
        neighbours::sort(r, band.cells, &band.sort, &s.flow_sorted);
        r.run(&turbulence::WEIGH, "terms of the filter", r.sizes().air())
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
    r.run(&turbulence::GATHER, "band velocity from the grid", r.sizes().air())
        .bind("params", &params)
        .bind("mesh", &mesh)
        .bind("sorted", &s.flow_sorted);
}

fn vorticity(r: &mut Recorder<'_>, plan: &Plan, field: &AnyArray) {
    r.dispatch_neighbours(&turbulence::VORTICITY, "vorticity", plan.turbulence.whirling_clusters.clone())
        .bind("field", field);
}
