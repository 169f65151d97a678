//! The arguments that can be typed.

mod finished;
mod groom;
mod numbers;
mod run;
#[cfg(feature = "view")]
mod view;

use std::path::{Path, PathBuf};

#[cfg(feature = "validate")]
use clap::builder::PossibleValuesParser;
use clap::{Args, Parser, Subcommand};
use windswept_scene::{CheckedScene, Scene};
#[cfg(feature = "validate")]
use windswept_validate::{CHECKS, LONG_CHECKS};

use crate::failure::Failure;
#[cfg(feature = "spectrum")]
pub(crate) use finished::SpectrumOptions;
pub(crate) use finished::{ExportOptions, MeasureArguments, Range, RenderOptions};
pub(crate) use groom::{ConvertOptions, Groom};
pub(crate) use run::{Asked, OnBlowup, RunOptions};
#[cfg(feature = "view")]
pub(crate) use view::{ViewOptions, What};

/// Hair in turbulent wind, simulated on the GPU: a scene file in, frames out.
#[derive(Debug, Parser)]
#[command(name = "windswept", version, after_help = examples())]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Command,
}

/// Examples of the commands that this build has, and the exit status.
fn examples() -> String {
    let mut text = String::from(EXAMPLES);
    if cfg!(feature = "view") {
        text += "
  windswept view scene.toml
      a window on it while it runs, with dials for wind, eddies and hair; or, of a run's folder, its film";
    }
    if cfg!(feature = "spectrum") {
        text += "
  windswept spectrum out/wind
      how much energy its air has in eddies of which size, at first and at last";
    }
    if cfg!(feature = "validate") {
        text += "
  windswept validate --adapter software
      formulas and independent numbers beside what an adapter computes";
    }
    text + "

Exit status: 0 done; 1 the run or a row of a validation failed, or the disk refused; 2 bad input or no such adapter
(nothing was written); 130 stopped by Ctrl-C (the files hold every frame finished until then)."
}

const EXAMPLES: &str = "\
Examples:
  windswept run scene.toml --out out/wind
      simulate; write frames and a report into out/wind
  windswept run scene.toml --out out/wind6 --set 'air.wind=[6, 0, 0]' --set time.duration=0.5
      the same with other values
  windswept run scene.toml --out out/try --steps 100 --adapter software --overwrite
      a short look, on the CPU
  windswept render out/wind --overwrite --set picture.hairs=50000
      new pictures of that run, with more hairs
  windswept render out/wind --contact-sheet 0,0.5,1,1.5
      four moments of it in one picture
  windswept run scene.toml --out out/long --checkpoint-every 500
  windswept run --resume out/long
      a long run, and on from its last checkpoint if it was ended, or past its end with a larger --steps
  windswept export out/wind --format usdc
      its strands for Blender, Houdini or Maya
  windswept measure out/wind
      how far its tips swing, how fast, how much its strands turn and gather
  windswept check --explain
      every key there is, with its default and its meaning
  windswept check --schema > windswept.schema.json
      what an editor needs to complete keys, with a first line `#:schema windswept.schema.json` in the scene
  windswept plan scene.toml
      the passes of a step, and why some are skipped
  windswept groom info curly.hair
      what a groom file holds, and how large it is";

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Simulate a scene and write what happens into a folder
    Run(RunOptions),
    #[cfg(feature = "view")]
    /// Open a window on a scene that runs, with dials, or on the film of a run
    View(ViewOptions),
    #[cfg(not(feature = "view"))]
    #[command(hide = true)]
    View {
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        _all: Vec<String>,
    },
    /// Make pictures of a run that is over or was stopped, from its hair.vtkhdf and scene.toml
    Render(RenderOptions),
    /// Make one film for other programs of a run that is over or was stopped, from its hair.vtkhdf and scene.toml
    Export(ExportOptions),
    /// Numbers of a run's hair, from its hair.vtkhdf: swing, frequency, wavelength, turning, gathering, coherence,
    /// lean, stretch
    Measure(MeasureArguments),
    #[cfg(feature = "spectrum")]
    /// Energy of a run's air by size of eddies, at its first and at its last frame, as a table and a picture
    Spectrum(SpectrumOptions),
    /// Read a scene, say what was understood, try a few steps, and write nothing
    Check {
        /// Scene file (TOML)
        #[arg(value_name = "SCENE", required_unless_present_any = ["explain", "schema"])]
        path: Option<PathBuf>,
        #[command(flatten)]
        changes: Changes,
        /// The adapter on which the steps are tried: part of a GPU's name, or `software` [default: $WGPU_ADAPTER_NAME,
        /// else the best]
        #[arg(long, value_name = "NAME")]
        adapter: Option<String>,
        /// What the run writes whose time is said, as `run --formats` takes it [default: png,vtkhdf]
        #[arg(long, value_delimiter = ',', value_parser = run::format)]
        formats: Vec<String>,
        /// Print every key there is: its default, meaning and unit; needs no SCENE
        #[arg(long)]
        explain: bool,
        /// Print a JSON schema of scene files, by which editors complete keys and underline mistakes; needs no SCENE
        #[arg(long, conflicts_with_all = ["explain", "path", "sets"])]
        schema: bool,
    },
    /// Print the passes of one step: how often each runs and what it moves, or why it is skipped (needs no GPU)
    Plan {
        #[command(flatten)]
        scene: SceneOptions,
        /// Print also what each pass reads and writes, and every buffer with its size and meaning
        #[arg(long)]
        buffers: bool,
    },
    #[cfg(feature = "validate")]
    /// Measure what an adapter computes against formulas and independent numbers; 1 to 3 minutes on a software adapter
    Validate(ValidateOptions),
    /// Look at a groom file, or turn one into another
    #[command(subcommand)]
    Groom(Groom),
    /// List the GPUs that a run can use, the one it would take first
    Adapters,
}

/// Refuses `--set`s that change more of a run that is over than its pictures.
pub(crate) fn of_pictures(sets: &[String]) -> Result<(), Failure> {
    let is_of_pictures = |set: &&String| {
        let table = set.split(['.', '=']).next().unwrap_or_default().trim();
        ["camera", "picture"].contains(&table)
    };
    match sets.iter().find(|set| !is_of_pictures(set)) {
        Some(set) => Err(Failure::Input(format!("--set {set}: only keys of camera and picture change a picture"))),
        None => Ok(()),
    }
}

#[derive(Debug, Args)]
pub(crate) struct SceneOptions {
    /// Scene file (TOML)
    #[arg(value_name = "SCENE")]
    path: PathBuf,
    #[command(flatten)]
    changes: Changes,
}

#[derive(Debug, Clone, Args)]
pub(crate) struct Changes {
    /// Change a key of the scene by its dotted path, e.g. air.wind=[6,0,0]; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,
}

impl Changes {
    /// The scene of a file with them, checked.
    pub(crate) fn load(&self, path: &Path) -> Result<CheckedScene, Failure> {
        let scene = Scene::load_with(path, &self.sets)?.check()?;
        if scene.hair.is_empty() {
            // Code may give a groom instead; the command has none.
            return Err(Failure::Input(format!("{}: hair: is missing, expected a table [hair]", path.display())));
        }
        Ok(scene)
    }
}

impl SceneOptions {
    /// The scene with its `--set`s, checked.
    pub(crate) fn load(&self) -> Result<CheckedScene, Failure> {
        self.changes.load(&self.path)
    }
}

#[cfg(feature = "validate")]
#[derive(Debug, Args)]
pub(crate) struct ValidateOptions {
    /// Only these checks [default: all]
    #[arg(
        value_name = "CHECK",
        value_parser = PossibleValuesParser::new(CHECKS.iter().chain(LONG_CHECKS).map(|check| check.name))
    )]
    pub(crate) checks: Vec<String>,
    /// Part of a GPU's name, or `software` [default: $WGPU_ADAPTER_NAME, else the best]
    #[arg(long, value_name = "NAME")]
    pub(crate) adapter: Option<String>,
    /// Print one JSON document instead of a table: windswept, adapter, rows, passed
    #[arg(long)]
    pub(crate) json: bool,
}
