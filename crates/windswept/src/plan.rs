//! Which passes a scene needs, and why. Decided once, from the scene; `windswept plan` prints it.

use windswept_scene::{InitialState, Model, Scene, SceneError, ViscosityForm};

use crate::{
    params::Params,
    recorder::{Decision, Recorder},
    state::{Array, Sizes, State},
    step,
};

/// What runs, and over how many elements.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Counts of everything.
    pub sizes: Sizes,
    /// Jacobi iterations of the density constraint.
    pub fluid_iterations: u32,
    /// Are there strands?
    pub hair: Decision,
    /// Are there air particles?
    pub air: Decision,
    /// Does a wind blow over air particles?
    pub wind: Decision,
    /// Do particles meet?
    pub neighbours: Decision,
    /// Is the density constraint solved?
    pub fluid: Decision,
    /// Is density needed although the constraint is not solved?
    pub density_alone: Decision,
    /// XSPH.
    pub viscosity: Decision,
    /// Can XSPH overshoot?
    pub limiter: Decision,
}

impl Plan {
    /// The plan of a scene.
    #[must_use]
    pub fn new(scene: &Scene, initial: &InitialState, sizes: Sizes) -> Self {
        let hair = Decision::when(sizes.strands > 0, "the scene has no hair");
        let air = match scene.model {
            Model::Particles => Decision::when(sizes.air() > 0, "the scene has no air particles"),
            Model::Drag => Decision::when(false, "interaction.model is drag: no air particles"),
            Model::None => Decision::when(false, "interaction.model is none: hair alone"),
        };
        let still = scene.air.as_ref().is_none_or(|air| air.wind == [0.0; 3]);
        let wind = air.and(Decision::when(!still, "air.wind is zero"));
        let viscous = scene.viscosity.hair > 0.0 || scene.viscosity.air > 0.0;
        let solved = scene.fluid.iterations > 0;
        let neighbours =
            air.and(Decision::when(solved || viscous, "neither density nor viscosity asks for neighbours"));
        let fluid = air.and(Decision::when(solved, "fluid.iterations is 0"));
        let viscosity = air.and(Decision::when(viscous, "viscosity.hair and viscosity.air are 0"));
        let density_alone = viscosity.and(Decision::when(!solved, "the density constraint has it already"));
        let limiter = viscosity.and(limiter(scene, initial));
        Self {
            sizes,
            fluid_iterations: scene.fluid.iterations,
            hair,
            air,
            wind,
            neighbours,
            fluid,
            density_alone,
            viscosity,
            limiter,
        }
    }

    /// The array that holds the velocities at the end of the step.
    #[must_use]
    pub fn final_velocity(&self, s: &State) -> Array {
        let last = if self.viscosity.runs { &s.viscous_velocity } else { &s.new_velocity };
        last.named("final_velocity")
    }
}

/// S_i = Σ c_ij w_ij ≤ 2 c √(V_max/V_min), since Σ_j V_j W ≤ θ_i: below 1 the limiter can never act.
fn limiter(scene: &Scene, initial: &InitialState) -> Decision {
    if scene.viscosity.form == ViscosityForm::Published {
        return Decision::when(false, "viscosity.form is published");
    }
    let volumes = initial.hair.volume.iter().copied();
    let air = (!initial.air.positions.is_empty()).then_some(initial.air.volume);
    let (mut smallest, mut largest) = (f64::INFINITY, 0.0_f64);
    for volume in volumes.chain(air) {
        smallest = smallest.min(volume);
        largest = largest.max(volume);
    }
    let hair = if initial.hair.is_empty() { 0.0 } else { scene.viscosity.hair };
    let coefficient = hair.max(scene.viscosity.air) / f64::from(scene.time.substeps);
    let bound = 2.0 * coefficient * (largest / smallest).sqrt();
    Decision::when(bound > 1.0, format!("no particle can exchange more than {bound:.2} of its velocity"))
}

/// A row of `windswept plan`: a pass of the step.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PlanRow {
    /// The heading of the step.
    pub heading: &'static str,
    /// The pass, `folder/name`.
    pub pass: &'static str,
    /// What it does.
    pub label: &'static str,
    /// How often it runs in a step.
    pub runs: u32,
    /// Why it does not run.
    pub skipped: Option<String>,
}

/// The step of a scene, pass by pass in execution order: a dry run of [`step::record`], with no GPU.
///
/// # Errors
/// [`SceneError`] when the initial state cannot be made.
pub fn table(scene: &Scene) -> Result<Vec<PlanRow>, SceneError> {
    let initial = InitialState::new(scene)?;
    let sizes = Params::new(scene, &initial, 0).sizes();
    let plan = Plan::new(scene, &initial, sizes);
    let state = State::new(&sizes);
    let recording = Recorder::record(|r| step::record(r, &state, &plan));
    let mut rows: Vec<PlanRow> = Vec::new();
    for command in &recording.commands {
        let known = rows.iter_mut().find(|row| row.pass == command.pass.name && row.label == command.label);
        match known {
            Some(row) => row.runs += 1,
            None => rows.push(PlanRow {
                heading: command.heading,
                pass: command.pass.name,
                label: command.label,
                runs: u32::from(command.skipped.is_none()),
                skipped: command.skipped.clone(),
            }),
        }
    }
    Ok(rows)
}
