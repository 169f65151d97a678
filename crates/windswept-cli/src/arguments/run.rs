//! The arguments of `windswept run`.

use std::num::NonZeroU64;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use windswept_export::{CHECKPOINT, DEFAULT_FORMATS, Format, files_of_run};
use windswept_scene::CheckedScene;

use super::Changes;
use super::numbers::{every, whole};
use crate::failure::Failure;

#[derive(Debug, Args)]
pub(crate) struct RunOptions {
    /// Scene file (TOML)
    #[arg(value_name = "SCENE", required_unless_present = "resume")]
    path: Option<PathBuf>,
    #[command(flatten)]
    changes: Changes,
    #[arg(long, value_name = "DIR", required_unless_present = "resume", help = out_help())]
    out: Option<PathBuf>,
    /// Stop after this many steps since t = 0, whatever time.duration says
    #[arg(long, value_name = "N", value_parser = whole, allow_negative_numbers = true)]
    pub(crate) steps: Option<u64>,
    /// Part of a GPU's name, or `software` [default: $WGPU_ADAPTER_NAME, else the run's own with --resume, else the
    /// best]
    #[arg(long, value_name = "NAME")]
    pub(crate) adapter: Option<String>,
    #[arg(long, value_delimiter = ',', value_parser = format, help = formats_help())]
    formats: Vec<String>,
    /// Write the report to this file too
    #[arg(long, value_name = "FILE")]
    pub(crate) report: Option<PathBuf>,
    /// Write to this file when each pass of the timed steps ran on the GPU, as a trace for chrome://tracing or Perfetto
    #[arg(long, value_name = "FILE")]
    pub(crate) trace: Option<PathBuf>,
    /// Replace what an earlier run left in DIR; other files there stay
    #[arg(long)]
    pub(crate) overwrite: bool,
    #[arg(
        long,
        value_name = "K",
        value_parser = every::<NonZeroU64>,
        allow_negative_numbers = true,
        help = checkpoint_help()
    )]
    pub(crate) checkpoint_every: Option<NonZeroU64>,
    /// What to do when a run blows up, which it does where air is not finite, or too many strands at once: end it with
    /// a checkpoint of the state before, or put what is not finite back to rest and go on. A few strands are put back
    /// in either case, and counted
    #[arg(long, value_name = "WHAT", default_value = "stop")]
    pub(crate) on_blowup: OnBlowup,
    /// Go on with the run in DIR from its checkpoint, with its scene, formats, --steps and --checkpoint-every, unless
    /// others are given
    #[arg(long, value_name = "DIR", conflicts_with_all = ["path", "out", "sets", "overwrite"])]
    resume: Option<PathBuf>,
}

/// `--on-blowup`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum OnBlowup {
    /// End the run
    Stop,
    /// Go on
    Reset,
}

/// The run that is asked for.
pub(crate) enum Asked<'a> {
    /// A scene from its start, into a folder.
    Start(&'a Path, &'a Path),
    /// The run of a folder, behind its checkpoint.
    GoOn(&'a Path),
}

/// The word that `--formats` takes beside the names of formats.
const NONE: &str = "none";

pub(super) fn format(word: &str) -> Result<String, String> {
    if word == NONE || Format::of_run(word).is_some() {
        return Ok(word.to_owned());
    }
    let names: Vec<_> = Format::of_runs().map(|format| format.name).collect();
    Err(format!("expected {} or {NONE}", names.join(", ")))
}

fn formats_help() -> String {
    let rows = Format::of_runs().map(|format| format!("{} ({})", format.name, format.writes));
    let default = DEFAULT_FORMATS.join(",");
    format!("What to write per frame: {}, or {NONE} [default: {default}]", rows.collect::<Vec<_>>().join(", "))
}

fn out_help() -> String {
    format!("Folder for {}; made if it is not there; frames are numbered from 0000 on", files_of_run().join(", "))
}

fn checkpoint_help() -> String {
    format!(
        "Write {CHECKPOINT} after every K steps, at the start and at the end, for --resume; a new one replaces the last"
    )
}

impl RunOptions {
    /// The run that is asked for.
    pub(crate) fn asked(&self) -> Asked<'_> {
        match (&self.path, &self.out, &self.resume) {
            (Some(scene), Some(out), None) => Asked::Start(scene, out),
            // The parser lets nothing else through.
            (_, _, dir) => Asked::GoOn(dir.as_deref().unwrap_or(Path::new("."))),
        }
    }

    /// The scene with its `--set`s, checked.
    pub(crate) fn load(&self, path: &Path) -> Result<CheckedScene, Failure> {
        self.changes.load(path)
    }

    /// Formats that are written per frame; `own` where none are named.
    pub(crate) fn formats(&self, own: &[impl AsRef<str>]) -> Result<Vec<&'static Format>, Failure> {
        if self.formats.len() > 1 && self.formats.iter().any(|word| word == NONE) {
            return Err(Failure::Input(format!("--formats: {NONE} stands alone")));
        }
        if self.formats.is_empty() {
            return Ok(own.iter().filter_map(|word| Format::of_run(word.as_ref())).collect());
        }
        Ok(self.formats.iter().filter_map(|word| Format::of_run(word)).collect())
    }
}
