//! Which passes a scene needs, and why. Decided once, from the scene; `windswept plan` prints it.

mod table;

use std::ops::Range;

use windswept_scene::{Air, Filter, FluidSolver, InitialState, Law, Model, Scene, Solver, ViscosityForm};
use windswept_shaders::{
    common::{band::Band, list::PAGES, matter::MAX_EDDIES, mesh::Mesh, params::Params},
    fluid::divergence::Iteration,
};

use crate::{
    array::{AnyArray, Index},
    recorder::Decision,
    setup::Setup,
    state::{Sizes, State},
    step::neighbours::Sort,
    upload::{bands::invocations, coarse::Coarse, params, rods},
};

pub use self::table::{BufferRow, MemoryBytes, PlanRow, Uses, buffers, memory_bytes, table};

/// Passes that run, and numbers of their elements.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Counts of everything.
    pub sizes: Sizes,
    /// Jacobi iterations of the density constraint.
    pub fluid_iterations: u32,
    /// Dispatches that Gauss-Seidel's sweeps are cut into.
    pub rod_dispatches: u32,
    /// Dispatches that the direct solver's Newton steps are cut into.
    pub newton_dispatches: u32,
    /// Whether rods are solved by the direct solver.
    pub direct: Decision,
    /// Whether strands that are not finite are held where they were, and put into their rest shape.
    pub recover: Decision,
    /// Whether Gauss-Seidel sweeps over strands.
    pub sweeps: Decision,
    /// Whether hair meets air particles.
    pub hair_meets_air: Decision,
    /// Whether there are strands.
    pub hair: Decision,
    /// Whether there are air particles.
    pub air: Decision,
    /// Whether there is a wind at all, for air or hair.
    pub blows: Decision,
    /// Whether a wind blows over air particles.
    pub wind: Decision,
    /// Whether the wind draws the air behind the faces that it enters through, and is held at what it is there.
    pub fringe: Decision,
    /// Whether the scene has force fields that do something.
    pub fields: Decision,
    /// Whether a force was set that pushes hair and air.
    pub pushes: Decision,
    /// Whether particles meet, so that the neighbour list is made.
    pub neighbours: Decision,
    /// How particles are sorted for the neighbour search.
    pub sort: Sort,
    /// Whether the density constraint is solved.
    pub fluid: Decision,
    /// Whether air is integrated with its moves: with solver pbf.
    pub pbf: Decision,
    /// Whether velocities are freed of divergence.
    pub divergence: Decision,
    /// Whether a pass asks how the flow deforms air.
    pub deformation: Decision,
    /// Whether eddies smaller than the spacing exchange velocity.
    eddies: bool,
    /// Whether pressure acts on hair as on air.
    pub pressed_hair: Decision,
    /// Elements of `iteration`, one per iteration of the pressure.
    pub pressure_iterations: Vec<Index<Iteration>>,
    /// Whether a coarse grid takes the first part.
    pub coarse: Decision,
    /// Elements of `mesh` with the coarse grid, one per axis.
    pub coarse_axes: [Index<Mesh>; 3],
    /// Element of `mesh` with the coarse grid, for the waves along its last axis that are solved for.
    pub coarse_solve: Index<Mesh>,
    /// Blocks of nodes of the deposit on the coarse grid.
    pub coarse_blocks: u32,
    /// Whether density is needed although the constraint is not solved.
    pub density_alone: Decision,
    /// Whether air or the mean wind drags segments.
    pub drag: Decision,
    /// Whether hair and air particles exchange drag.
    pub exchange: Decision,
    /// Whether any band is strengthened.
    pub turbulence: Decision,
    /// Whether the confinement is that of the paper as printed.
    pub published_law: bool,
    /// Whether the velocity of a band is summed over all pairs.
    pub direct_filter: Decision,
    /// Whether the velocity of a band is found on a grid.
    pub grid_filter: Decision,
    /// Bands of eddies, in the order in which they run.
    pub bands: Vec<BandPlan>,
    /// Whether hair rubs on hair.
    pub friction: Decision,
    /// Whether neighbours exchange velocity by XSPH.
    pub viscosity: Decision,
    /// Whether XSPH can overshoot, so that its limiter runs.
    pub limiter: Decision,
    /// The clusters that the limiter has to do with: of hair, where only hair can overshoot, or all.
    pub limited_clusters: Range<u32>,
    /// Whether there is a body to stay out of.
    pub bodies: Decision,
    /// Whether bodies are walls to the air's pressure.
    pub walls: Decision,
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

impl Plan {
    /// The plan of a scene.
    #[must_use]
    pub fn new(setup: &Setup<'_>) -> Self {
        let (scene, initial, sizes) = (setup.scene, setup.initial, setup.sizes());
        let hair = Decision::when(sizes.strands > 0, "the scene has no hair");
        let air = match scene.interaction.model {
            Model::Particles | Model::TwoWay => Decision::when(sizes.air() > 0, "the scene has no air particles"),
            Model::Drag => Decision::when(false, "interaction.model is drag: no air particles"),
            Model::None => Decision::when(false, "interaction.model is none: hair alone"),
        };
        let viscous = scene.viscosity.acts();
        let eddies = setup.params.viscosity_eddies > 0.0;
        let solved = scene.fluid.iterations > 0;
        let bands = bands(setup);
        let on_grid = scene.turbulence.filter == Filter::Grid;
        let turbulence = air.and(turbulence(scene, &bands));
        let drag = hair.and(match scene.interaction.model {
            Model::Drag => Decision::when(true, ""),
            Model::Particles | Model::TwoWay => Decision::when(air.runs, "no air moves"),
            Model::None => Decision::when(false, "interaction.model is none: hair alone"),
        });
        let no_fields = scene.why_no_fields();
        let fields = Decision::when(no_fields.is_none(), no_fields.unwrap_or_default());
        let is_still = scene.air.as_ref().is_none_or(Air::is_still) && !fields.runs;
        let (blows, wind) = wind(&Decision::when(!is_still, "air.wind is zero"), &air, &drag);
        let two_way = scene.interaction.model == Model::TwoWay;
        let is_pbf = scene.fluid.solver == FluidSolver::Pbf;
        let neighbours = air.and(Decision::when(
            solved || !is_pbf || viscous || turbulence.runs || (two_way && hair.runs),
            "neither density nor viscosity nor turbulence nor hair asks for neighbours",
        ));
        let pbf = air.and(Decision::when(is_pbf, "fluid.solver is divergence"));
        let divergence = air.and(Decision::when(!is_pbf, "fluid.solver is pbf"));
        let bodies = Decision::when(sizes.bodies > 0, "the scene has no bodies");
        let coarse =
            divergence.and(scene.why_no_coarse().map_or(Decision::when(true, ""), |why| Decision::when(false, why)));
        let first_coarse = setup.coarse.as_ref().map_or(0, |coarse| coarse.first);
        let fluid = air
            .and(Decision::when(solved, "fluid.iterations is 0"))
            .and(Decision::when(sizes.constrained > 0, "fluid.solver is divergence"));
        let rough = (0..initial.hair.len()).any(|s| initial.hair.friction(s) > 0.0);
        let smooth = scene.why_no_friction();
        let friction = hair
            .and(Decision::when(smooth.is_none(), smooth.unwrap_or_default()))
            .and(fluid.clone())
            .and(Decision::when(rough, "hair.friction is 0"));
        let hair_meets_air = hair.and(neighbours.clone());
        let direct = hair.and(Decision::when(scene.rods.solver == Solver::Direct, "rods.solver is gauss-seidel"));
        let sweeps = hair.and(Decision::when(scene.rods.solver == Solver::GaussSeidel, "rods.solver is direct"));
        let viscosity =
            air.and(Decision::when(viscous, "viscosity.hair, viscosity.air and viscosity.smagorinsky are 0"));
        let density_alone = viscosity
            .and(Decision::when(!solved, "the density constraint has it already"))
            .and(Decision::when(sizes.constrained > 0, "the pressure's moments have it already"));
        let bounds = exchanges(scene, initial);
        let limiter = viscosity.and(limiter(scene, bounds));
        let limited_clusters = if bounds.air > 1.0 { sizes.clusters_of_all() } else { sizes.clusters_of_hair() };
        Self {
            sizes,
            fluid_iterations: scene.fluid.iterations,
            rod_dispatches: scene.rods.iterations / rods::sweeps_per_dispatch(scene.rods.iterations, &initial.hair),
            newton_dispatches: setup.params.newton_steps / setup.params.newton_part,
            sweeps,
            direct,
            recover: hair
                .and(Decision::when(false, "not until a strand is not finite, or somebody puts hair somewhere")),
            hair_meets_air: hair_meets_air.clone(),
            hair,
            air,
            blows,
            wind,
            fields,
            pushes: Decision::when(false, "no force was set"),
            fringe: Decision::when(scene.air.as_ref().is_some_and(|air| air.fringe > 0.0), "air.fringe is 0"),
            neighbours,
            sort: Sort::new(&setup.params),
            fluid,
            pbf,
            pressure_iterations: (1..setup.iterations.len()).map(Index::new).collect(),
            pressed_hair: divergence
                .and(hair_meets_air.clone())
                .and(Decision::when(!two_way, "interaction.model is two-way: hair and air exchange drag")),
            deformation: divergence.and(deformation(eddies, is_still)),
            eddies,
            divergence: divergence.clone(),
            coarse,
            coarse_axes: [0, 1, 2].map(|axis| Index::new(first_coarse + axis)),
            coarse_solve: Index::new(first_coarse + 3),
            coarse_blocks: setup.coarse.as_ref().map_or(0, Coarse::blocks),
            density_alone,
            friction,
            exchange: hair_meets_air.and(Decision::when(two_way, "only interaction.model two-way exchanges drag")),
            drag,
            turbulence,
            published_law: scene.turbulence.law == Law::Published,
            direct_filter: Decision::when(!on_grid, "turbulence.filter is grid"),
            grid_filter: Decision::when(on_grid, "turbulence.filter is direct"),
            bands,
            viscosity,
            limiter,
            limited_clusters,
            walls: divergence.and(bodies.clone()),
            bodies,
        }
    }

    /// Lets the wind's passes run from now on, as the caller sets it, whether it blows or is zero: what was blowing is
    /// taken from the air by them too. Says whether other passes run now.
    pub fn set_wind(&mut self, blows: bool) -> bool {
        let before = (self.blows.clone(), self.deformation.clone());
        self.blow();
        self.deformation = self.divergence.and(deformation(self.eddies, !blows && !self.fields.runs));
        before != (self.blows.clone(), self.deformation.clone())
    }

    /// Lets the wind's passes run from now on.
    fn blow(&mut self) {
        (self.blows, self.wind) = wind(&Decision::when(true, ""), &self.air, &self.drag);
    }

    /// Lets the passes run from now on that recover strands: those that are not finite, or that somebody else than a
    /// step has written. A step freezes where there is one and no pass recovers it.
    pub fn recover_strands(&mut self) {
        self.recover = self.hair.clone();
    }

    /// Lets the force that the caller sets push from now on, or lets it push no longer. It reaches air through the
    /// wind's passes.
    pub fn set_force(&mut self, pushes: bool) {
        self.pushes = Decision::when(pushes, "no force was set");
        if pushes {
            self.blow();
        }
    }

    /// The clusters that the density constraint has to do with.
    #[must_use]
    pub fn constrained_clusters(&self) -> Range<u32> {
        let sizes = &self.sizes;
        if sizes.constrained == sizes.particles { sizes.clusters_of_all() } else { sizes.clusters_of_hair() }
    }

    /// The clusters whose velocity is freed of divergence.
    #[must_use]
    pub fn flowing_clusters(&self) -> Range<u32> {
        if self.pressed_hair.runs { self.sizes.clusters_of_all() } else { self.sizes.clusters_of_air() }
    }

    /// The clusters that have a vorticity: of air, as printed of hair too.
    #[must_use]
    pub fn whirling_clusters(&self) -> Range<u32> {
        if self.published_law { self.sizes.clusters_of_all() } else { self.sizes.clusters_of_air() }
    }

    /// The array that holds the velocities at the end of the step.
    #[must_use]
    pub fn final_velocity(&self, s: &State) -> AnyArray {
        if self.viscosity.runs { *s.viscous_velocity } else { *s.new_velocity }
    }
}

const NO_BANDS: &str = "the scene names no turbulence.bands";

/// Whether a wind blows at all, and whether it blows over air particles.
fn wind(blows: &Decision, air: &Decision, drag: &Decision) -> (Decision, Decision) {
    (if air.runs || drag.runs { blows.clone() } else { air.and(drag.clone()) }, air.and(blows.clone()))
}

/// Whether a pass asks how the flow deforms air: `fluid/spread` where no wind blows, and XSPH where eddies smaller than
/// the spacing exchange velocity.
fn deformation(eddies: bool, is_still: bool) -> Decision {
    Decision::when(eddies || is_still, "wind blows and viscosity.smagorinsky is 0")
}

/// Bands in the order in which they run: those that share a grid follow one another. There is at least one, so that the
/// plan always names the passes of a band.
fn bands(setup: &Setup<'_>) -> Vec<BandPlan> {
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
    if all.is_empty() { vec![plan(0, Decision::when(false, NO_BANDS))] } else { all }
}

fn turbulence(scene: &Scene, bands: &[BandPlan]) -> Decision {
    let still = scene.turbulence.law == Law::Band && scene.turbulence.speed == 0.0;
    Decision::when(!scene.turbulence.bands.is_empty(), NO_BANDS)
        .and(Decision::when(bands.iter().any(|band| band.runs.runs), "all turbulence.bands have strength 0"))
        .and(Decision::when(!still, "turbulence.speed is 0: nothing to measure the bands against"))
}

/// The largest S, the part of its velocity that a particle exchanges by XSPH, which the limiter need not look for.
#[derive(Debug, Clone, Copy)]
struct Exchanges {
    air: f64,
    hair: f64,
}

/// S_i = Σ c_ij w_ij ≤ 2 c √(V_max/V_min), since Σ_j V_j W ≤ θ_i, with the volumes and the coefficient of those that
/// the particle meets.
fn exchanges(scene: &Scene, initial: &InitialState) -> Exchanges {
    let bound = |coefficient: f64, volumes: &mut dyn Iterator<Item = f64>| {
        let (smallest, largest) = volumes.fold((f64::INFINITY, 0.0_f64), |(a, b), v| (a.min(v), b.max(v)));
        if largest > 0.0 {
            2.0 * coefficient / f64::from(scene.time.substeps) * (largest / smallest).sqrt()
        } else {
            0.0
        }
    };
    let most_eddies = if scene.viscosity.smagorinsky > 0.0 { f64::from(MAX_EDDIES) } else { 0.0 };
    let of_air = scene.viscosity.air + f64::from(scene.time.substeps) * most_eddies;
    let hair = || initial.hair.volume.iter().copied();
    let air = || (!initial.air.positions.is_empty()).then_some(initial.air.volume).into_iter();
    let of_hair = if initial.hair.is_empty() { 0.0 } else { scene.viscosity.hair };
    if scene.interaction.model == Model::TwoWay {
        return Exchanges { air: bound(of_air, &mut air()), hair: bound(of_hair, &mut hair()) };
    }
    let all = bound(of_hair.max(of_air), &mut hair().chain(air()));
    Exchanges { air: all, hair: all }
}

/// Below 1 the limiter can never act.
fn limiter(scene: &Scene, bounds: Exchanges) -> Decision {
    if scene.viscosity.form == ViscosityForm::Published {
        return Decision::when(false, "viscosity.form is published");
    }
    let bound = bounds.air.max(bounds.hair);
    Decision::when(bound > 1.0, format!("no particle can exchange more than {bound:.2} of its velocity"))
}
