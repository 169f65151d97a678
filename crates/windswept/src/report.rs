//! What a run reports: `report.json`.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::gpu::AdapterInfo;

/// The report of a run so far. What was not measured is left out, never null.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// Version of this schema.
    pub schema: u32,
    /// Version of windswept.
    pub windswept: String,
    /// Commit that it was built from, where the build knew it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub commit: Option<String>,
    /// Title of the scene.
    pub scene: String,
    /// `accurate` or `published`.
    pub method: String,
    /// The adapter that ran.
    pub adapter: AdapterInfo,
    /// Counts.
    pub particles: Particles,
    /// Steps since t = 0.
    pub steps: u64,
    /// Time reached \[s\].
    pub time_s: f64,
    /// Median wall time of a step, stepping alone, first step excluded \[ms\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ms_per_step: Option<f64>,
    /// Wall time of the first step, pipelines' compilation included \[ms\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ms_first_step: Option<f64>,
    /// GPU time per pass and step, of the timed steps.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub passes: Vec<PassReport>,
    /// What the scene does not need.
    pub skipped: Vec<SkippedReport>,
    /// max |l/l0 − 1| over the run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_stretch: Option<f64>,
    /// Steps of strands, summed over all strands and steps, that went otherwise than by a solve of the integrator asked for:
    /// `euler_steps` by implicit Euler instead of BDF2, `quiet_steps` without a solve because nothing pushed the strand,
    /// `asleep_steps` of strands at rest, `teleports` of strands that a far jump of their root took along as they were, and
    /// `rescued_steps` by Gauss-Seidel because the direct solve did not converge in f32.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub strand_steps: Option<BTreeMap<String, u64>>,
    /// rms of ρ/ρ0 − 1 over the air.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub density_error_rms: Option<f64>,
    /// rms of max(ρ/ρ0 − 1, 0) over the air.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub over_density_rms: Option<f64>,
    /// Σ m v over hair and air; clamped roots left out.
    pub momentum_kg_m_per_s: [f64; 3],
    /// What confinement has given the air in the whole run, its mean taken out; without bands left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub confinement_impulse_kg_m_per_s: Option<[f64; 3]>,
    /// Steps in which the confinement's limiter acted on some particle: a band may gain 0.12 of its speed in a step, which
    /// strong bands do; without bands left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub confinement_limited_steps: Option<u64>,
    /// Energy and cost of each of `turbulence.bands`; without air particles or bands left out.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub band_energy: Vec<BandEnergy>,
    /// Bytes of the engine's buffers.
    pub memory_bytes: u64,
    /// How often each cause acted.
    pub warnings: BTreeMap<String, u64>,
}

/// Counts.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Particles {
    /// Points of all strands.
    pub hair: u64,
    /// Air particles.
    pub air: u64,
    /// Hair points outside the box of air, now.
    pub hair_outside_box: u64,
}

/// A band of eddies: the mean over the air of ½ |û|², about the mean wind \[m²/s²\], and what it cost.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct BandEnergy {
    /// s \[m\].
    pub scale: f64,
    /// At t = 0.
    pub m2_per_s2_at_start: f64,
    /// Now.
    pub m2_per_s2: f64,
    /// GPU time of all its passes in a step \[ms\], a grid that bands share with the finest of them; left out where it was
    /// not timed or has no strength.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ms: Option<f64>,
}

/// GPU time of a pass.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PassReport {
    /// Its label.
    pub name: String,
    /// The pass, `folder/name`.
    pub pass: String,
    /// Which of `turbulence.bands` it is for; a grid that bands share counts with the first of them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub band: Option<usize>,
    /// Mean time in a step, all its runs in the step together \[ms\].
    pub ms: f64,
    /// Runs in a step.
    pub runs: u64,
}

/// A pass that the scene does not need.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct SkippedReport {
    /// Its label.
    pub name: String,
    /// The reason.
    pub why: String,
}
