//! The report of a run: `report.json`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use windswept_scene::{Change, Warning};

use crate::{
    error::six_digits,
    gpu::{AdapterInfo, ShaderVariant},
};

/// The report of a run so far. A quantity that was not measured is left out, never null; report.json of a failed run
/// also leaves out quantities that are not finite.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// Version of this schema.
    pub schema: u32,
    /// Version of windswept.
    pub windswept: String,
    /// Commit that windswept was built from, where the build knew it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub commit: Option<String>,
    /// Title of the scene.
    pub scene: String,
    /// Method: `accurate` or `published`.
    pub method: String,
    /// The adapter that ran.
    pub adapter: AdapterInfo,
    /// Variant of the shaders that ran there.
    pub variant: ShaderVariant,
    /// Numbers of particles.
    pub particles: ParticleCounts,
    /// Steps since t = 0.
    pub steps: u64,
    /// Time reached \[s\].
    pub time_s: f64,
    /// Why the run ended before its time. Left out where nothing went wrong, and of [`crate::Simulation::report`],
    /// which does not know when a run is over.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub failure: Option<RunFailure>,
    /// Median wall time of a step, stepping alone, first step excluded \[ms\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ms_per_step: Option<f64>,
    /// Wall time of making the simulation from its initial state: its buffers, and its pipelines, which Mesa's software
    /// driver compiles meanwhile \[ms\].
    pub ms_setup: f64,
    /// Wall time of the first step, in which other drivers may still compile pipelines \[ms\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ms_first_step: Option<f64>,
    /// GPU time per pass and step, of the timed steps.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub passes: Vec<PassReport>,
    /// Passes that the scene does not need.
    pub skipped: Vec<SkippedReport>,
    /// Largest stretch of a segment over the run, max |l/l0 − 1|.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_stretch: Option<f64>,
    /// Steps of strands that went otherwise than by a solve of the integrator asked for, summed over all strands and
    /// steps: `euler_steps` by implicit Euler instead of BDF2, `sleeping_steps` of strands at rest, `teleports` of
    /// strands that a far jump of their root took along as they were, and `unsolved_steps` of strands that had not
    /// settled after `rods.newton` Newton steps and lag behind.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub strand_steps: Option<BTreeMap<String, u64>>,
    /// Density error: rms of ρ/ρ0 − 1 over the air.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub density_error_rms: Option<f64>,
    /// Density error of compressed air alone: rms of max(ρ/ρ0 − 1, 0) over the air.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub over_density_rms: Option<f64>,
    /// Momentum Σ m v of hair and air, without clamped roots.
    pub momentum_kg_m_per_s: [f64; 3],
    /// Impulse that confinement has given the air in the run, after its mean was taken out. Left out without bands.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub confinement_impulse_kg_m_per_s: Option<[f64; 3]>,
    /// Bodies, and what the air has given them. Left out without air particles or bodies.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub bodies: Vec<BodyReport>,
    /// Steps in which the confinement's limiter acted on some particle: it keeps a strong band from gaining more than
    /// half of its speed in a step. Left out without bands.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub confinement_limited_steps: Option<u64>,
    /// Energy and cost of each of `turbulence.bands`. Left out without air particles or bands.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub band_energy: Vec<BandEnergy>,
    /// Size of the engine's buffers and, on a software adapter, of their textures \[bytes\].
    pub memory_bytes: u64,
    /// Strands and air that were reset in the run, with the times; the first thousand. Left out where there were none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub resets: Vec<Reset>,
    /// Changes of the scene while it ran. Left out where there were none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub changes: Vec<Change>,
    /// Warnings: those about the scene, and those whose cause acted in the run, with how often.
    pub warnings: Vec<Warning>,
}

/// The end of a run that could not go on; all else in its report is of the state before that.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RunFailure {
    /// Step of Δt, from 0, that could not be taken or whose frame could not be kept.
    pub step: u64,
    /// Time at the start of that step \[s\].
    pub time_s: f64,
    /// The error, in words.
    pub why: String,
}

/// Strands or air that were reset because a value was not finite or too large, and the time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Reset {
    /// Step of Δt, from 0, in which it was found: the last one, if strands were reset in several steps between two
    /// readings of the status.
    pub step: u64,
    /// Time at the start of that step \[s\].
    pub time_s: f64,
    /// Number of strands that were put into their rest shape at their roots.
    pub strands: u64,
    /// Indices of some of them: the smallest one of that step, or the first ten where the run had ended.
    pub named: Vec<u32>,
    /// Whether all air was put where it was at the start, with the velocity of the mean wind.
    pub air: bool,
    /// Whether the run had ended there and was made to go on ([`crate::Simulation::recover`]).
    pub recovered: bool,
}

impl std::fmt::Display for Reset {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let named: Vec<_> = self.named.iter().map(u32::to_string).collect();
        let strands = match self.strands {
            0 => String::new(),
            1 => format!("strand {}", named.join(", ")),
            n if n == self.named.len() as u64 => format!("strands {}", named.join(", ")),
            n => format!("{n} strands, {} among them", named.join(", ")),
        };
        let air = if self.air { "all air" } else { "" };
        let and = if self.strands > 0 && self.air { ", and " } else { "" };
        write!(
            f,
            "step {} (t = {} s): not finite or too fast, and put back to rest: {strands}{and}{air}",
            self.step,
            six_digits(self.time_s)
        )
    }
}

/// Numbers of particles.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ParticleCounts {
    /// Points of all strands.
    pub hair: u64,
    /// Air particles.
    pub air: u64,
    /// Hair points that are outside the box of air now.
    pub hair_outside_box: u64,
}

/// A band of eddies: its energy, which is the mean of ½ |û|² over the air, about the mean wind, and its cost.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct BandEnergy {
    /// Scale s \[m\].
    pub scale: f64,
    /// Energy at t = 0 \[m²/s²\].
    pub m2_per_s2_at_start: f64,
    /// Energy now \[m²/s²\].
    pub m2_per_s2: f64,
    /// GPU time of all the band's passes in a step \[ms\]; a grid that bands share counts with the finest of them. Left
    /// out where it was not timed or the band has no strength.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ms: Option<f64>,
}

/// A body in the air.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BodyReport {
    /// Name of the body.
    pub name: String,
    /// Impulse that the air has given it in the run, by pressure and friction.
    pub impulse_kg_m_per_s: [f64; 3],
}

/// GPU time of a pass.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PassReport {
    /// Stage of the step under which the pass runs.
    pub stage: String,
    /// Label of the pass.
    pub name: String,
    /// Name of the pass, `folder/name`.
    pub pass: String,
    /// Index of the band in `turbulence.bands` that the pass is for; a grid that bands share counts with the first of
    /// them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub band: Option<usize>,
    /// Mean time of all runs in a step, of all its substeps together \[ms\].
    pub ms: f64,
    /// Number of runs in a step, of all its substeps together.
    pub runs: u64,
}

/// A pass that the scene does not need.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct SkippedReport {
    /// Label of the pass.
    pub name: String,
    /// The reason.
    pub why: String,
}
