//! The arguments that can be typed.

use std::ffi::OsStr;
use std::fmt::Display;
use std::num::{NonZeroU64, NonZeroUsize};
use std::path::{Path, PathBuf};
use std::str::FromStr;

#[cfg(feature = "validate")]
use clap::builder::PossibleValuesParser;
use clap::builder::{EnumValueParser, PossibleValue, TypedValueParser};
use clap::error::ErrorKind;
use clap::{Arg, Args, Parser, Subcommand, ValueEnum, value_parser};
use windswept_export::{CHECKPOINT, DEFAULT_FORMATS, FORMATS, Format, SHEET, files_of_run};
use windswept_scene::{GroomFormat, Scene, Up, keys::Key, limits::MAX_POINTS_OF_A_STRAND};
#[cfg(feature = "validate")]
use windswept_validate::{CHECKS, LONG_CHECKS};

use crate::failure::Failure;
use crate::render::Range;

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

Exit status: 0 done; 1 the run or a row of a validation failed, or the disk refused; 2 bad input or no such adapter (nothing was written);
130 stopped by Ctrl-C (the files hold every frame finished until then)."
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
  windswept plan scene.toml
      the passes of a step, and why some are skipped
  windswept groom info curly.hair
      what a groom file holds, and how large it is";

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Simulate a scene and write what happens into a folder
    Run(RunOptions),
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
    /// Read a scene, say what was understood, and write nothing
    Check {
        /// Scene file (TOML)
        #[arg(value_name = "SCENE", required_unless_present = "explain")]
        path: Option<PathBuf>,
        #[command(flatten)]
        changes: Changes,
        /// Print every key there is: its default, meaning and unit; needs no SCENE
        #[arg(long)]
        explain: bool,
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

#[derive(Debug, Subcommand)]
#[command(after_help = groom_formats())]
pub(crate) enum Groom {
    /// Say what a groom file holds: strands, points, how large it is, and which strands cannot be simulated
    #[command(after_help = groom_formats())]
    Info {
        /// Groom file
        #[arg(value_name = "FILE")]
        file: PathBuf,
        /// Points of each strand, where the file does not say where one ends
        #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
        points_per_strand: Option<u32>,
    },
    /// Write the strands of a groom file that can be simulated as another groom file, in their order
    #[command(after_help = groom_formats())]
    Convert(ConvertOptions),
}

/// The formats of groom files.
fn groom_formats() -> String {
    let rows = GroomFormat::ALL.iter().map(|format| {
        let how = if format.writes() { "" } else { "; read only" };
        format!("\n  .{:<6} {}{how}", format.extension, format.what)
    });
    format!(
        "Formats, by the ending of the file's name:{}\n
Examples:
  windswept groom info wCurly.hair
  windswept groom convert wCurly.hair curly.npz --scale 0.00254 --up yzx --strands 2000 --points 40
  windswept groom convert 1_strands.ply strands.hair --points-per-strand 100",
        rows.collect::<String>()
    )
}

#[derive(Debug, Args)]
pub(crate) struct ConvertOptions {
    /// Groom file to read
    #[arg(value_name = "IN")]
    pub(crate) input: PathBuf,
    /// Groom file to write
    #[arg(value_name = "OUT")]
    pub(crate) output: PathBuf,
    /// Metres per unit of IN; OUT is in metres then [default: OUT has the units of IN]
    #[arg(long, value_name = "M", value_parser = positive, allow_negative_numbers = true)]
    pub(crate) scale: Option<f64>,
    /// Axis of IN that becomes +Y, or its axes that become x, y and z; xzy, yxz and zyx mirror [default: y]
    #[arg(long, value_name = "AXES", value_parser = up)]
    pub(crate) up: Option<Up>,
    /// Divide strands anew into so many points, evenly along their length
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(2..=i64::from(MAX_POINTS_OF_A_STRAND)), allow_negative_numbers = true)]
    pub(crate) points: Option<u32>,
    /// Keep so many strands, those whose roots are far from one another
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
    pub(crate) strands: Option<u32>,
    /// Seed that draws the first strand that is kept
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole, allow_negative_numbers = true)]
    pub(crate) seed: u64,
    /// Points of each strand of IN, where the file does not say where one ends
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
    pub(crate) points_per_strand: Option<u32>,
    /// Replace OUT if it is there
    #[arg(long)]
    pub(crate) overwrite: bool,
}

/// A whole number of at least so many.
fn at_least<T: FromStr + PartialOrd + Display>(least: T, word: &str) -> Result<T, String> {
    let number = word.parse().ok().filter(|number| *number >= least);
    number.ok_or_else(|| format!("expected a whole number of at least {least}"))
}

fn whole(word: &str) -> Result<u64, String> {
    at_least(0, word)
}

fn count(word: &str) -> Result<u32, String> {
    at_least(1, word)
}

fn every<T: TryFrom<NonZeroU64>>(word: &str) -> Result<T, String> {
    let number = at_least(1, word)?;
    let fits = NonZeroU64::new(number).and_then(|number| T::try_from(number).ok());
    fits.ok_or_else(|| format!("{number} is too large"))
}

fn seconds(word: &str) -> Result<f64, String> {
    let number = word.parse().ok().filter(|time: &f64| time.is_finite());
    number.ok_or_else(|| "expected a time in seconds".to_owned())
}

fn moment(word: &str) -> Result<f64, String> {
    seconds(word).map_err(|_| "expected times in seconds, e.g. 0,0.5,1".to_owned())
}

fn positive(word: &str) -> Result<f64, String> {
    let number = word.parse().ok().filter(|x: &f64| x.is_finite() && *x > 0.0);
    number.ok_or_else(|| "expected a number greater than 0".to_owned())
}

fn up(word: &str) -> Result<Up, String> {
    let expected = || Key::find("hair.up").map(Key::expected).unwrap_or_default();
    word.parse().map_err(|()| format!("expected {}", expected()))
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
    pub(crate) fn load(&self, path: &Path) -> Result<Scene, Failure> {
        let scene = Scene::load_with(path, &self.sets)?;
        if scene.hair.is_empty() {
            // Code may give a groom instead; the command has none.
            return Err(Failure::Input(format!("{}: hair: is missing, expected a table [hair]", path.display())));
        }
        Ok(scene)
    }
}

impl SceneOptions {
    /// The scene with its `--set`s, checked.
    pub(crate) fn load(&self) -> Result<Scene, Failure> {
        self.changes.load(&self.path)
    }
}

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
    #[arg(long, value_name = "K", value_parser = every::<NonZeroU64>, allow_negative_numbers = true, help = checkpoint_help())]
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

/// The word that `--formats` takes beside the names of [`FORMATS`].
const NONE: &str = "none";

fn format(word: &str) -> Result<String, String> {
    if word == NONE || Format::named(word).is_some() {
        return Ok(word.to_owned());
    }
    let names: Vec<_> = FORMATS.iter().map(|format| format.name).collect();
    Err(format!("expected {} or {NONE}", names.join(", ")))
}

fn formats_help() -> String {
    let rows = FORMATS.iter().map(|format| format!("{} ({})", format.name, format.writes));
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
    pub(crate) fn load(&self, path: &Path) -> Result<Scene, Failure> {
        self.changes.load(path)
    }

    /// Formats that are written per frame; `own` where none are named.
    pub(crate) fn formats(&self, own: &[impl AsRef<str>]) -> Result<Vec<&'static Format>, Failure> {
        if self.formats.len() > 1 && self.formats.iter().any(|word| word == NONE) {
            return Err(Failure::Input(format!("--formats: {NONE} stands alone")));
        }
        if self.formats.is_empty() {
            return Ok(own.iter().filter_map(|word| Format::named(word.as_ref())).collect());
        }
        Ok(self.formats.iter().filter_map(|word| Format::named(word)).collect())
    }
}

#[cfg(feature = "validate")]
#[derive(Debug, Args)]
pub(crate) struct ValidateOptions {
    /// Only these checks [default: all]
    #[arg(value_name = "CHECK", value_parser = PossibleValuesParser::new(CHECKS.iter().chain(LONG_CHECKS).map(|check| check.name)))]
    pub(crate) checks: Vec<String>,
    /// Part of a GPU's name, or `software` [default: $WGPU_ADAPTER_NAME, else the best]
    #[arg(long, value_name = "NAME")]
    pub(crate) adapter: Option<String>,
    /// Print one JSON document instead of a table: windswept, adapter, rows, passed
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct MeasureArguments {
    /// Folder of the run, with its hair.vtkhdf and scene.toml
    #[arg(value_name = "DIR")]
    pub(crate) dir: PathBuf,
    /// Start of the time that is measured, in seconds [default: 0.2, or the first frame of a run shorter than 0.4 s]
    #[arg(long, value_name = "S", value_parser = seconds, allow_negative_numbers = true)]
    pub(crate) from: Option<f64>,
    /// End of the time that is measured, in seconds [default: the last frame]
    #[arg(long, value_name = "S", value_parser = seconds, allow_negative_numbers = true)]
    pub(crate) to: Option<f64>,
    /// Print one JSON document instead of a table: numbers with their units in their names, null where one has no
    /// meaning, and the spectrum
    #[arg(long)]
    pub(crate) json: bool,
}

#[cfg(feature = "spectrum")]
#[derive(Debug, Args)]
pub(crate) struct SpectrumOptions {
    /// Folder of the run, with its air.vtkhdf and scene.toml
    #[arg(value_name = "DIR")]
    pub(crate) dir: PathBuf,
    /// Scales to measure, in metres [default: the scene's, and a ladder from what particles carry to the box]
    #[arg(long, value_name = "S,S", value_delimiter = ',', value_parser = scale, allow_negative_numbers = true)]
    pub(crate) scales: Option<Vec<f64>>,
    /// The picture, SVG; it is replaced [default: DIR/spectrum.svg]
    #[arg(long, value_name = "FILE")]
    pub(crate) picture: Option<PathBuf>,
    /// Part of a GPU's name, or `software` [default: $WGPU_ADAPTER_NAME, else the best]
    #[arg(long, value_name = "NAME")]
    pub(crate) adapter: Option<String>,
    /// Print one JSON document instead of a table: time_s, band_energy
    #[arg(long)]
    pub(crate) json: bool,
}

#[cfg(feature = "spectrum")]
fn scale(word: &str) -> Result<f64, String> {
    let expected = || "expected lengths in metres above 0, e.g. 0.006,0.018".to_owned();
    word.parse().ok().filter(|scale: &f64| scale.is_finite() && *scale > 0.0).ok_or_else(expected)
}

/// Help text about Alembic, which Blender makes of a film.
const OF_ALEMBIC: &str = "\
windswept writes no Alembic, but Blender makes it of USD, without a window: export --format usdc, and then run

blender --background --python-expr 'import bpy
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.wm.usd_import(filepath=\"film.usdc\")
bpy.ops.wm.alembic_export(filepath=\"film.abc\")'
";

/// Reads a [`FilmFormat`], and says the way to a format that is none.
#[derive(Debug, Clone, Copy)]
struct FilmFormats;

impl TypedValueParser for FilmFormats {
    type Value = FilmFormat;

    fn parse_ref(&self, command: &clap::Command, arg: Option<&Arg>, word: &OsStr) -> Result<FilmFormat, clap::Error> {
        if ["abc", "alembic"].iter().any(|other| word.eq_ignore_ascii_case(other)) {
            return Err(clap::Error::raw(ErrorKind::InvalidValue, OF_ALEMBIC).with_cmd(command));
        }
        EnumValueParser::new().parse_ref(command, arg, word)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new(FilmFormat::value_variants().iter().filter_map(ValueEnum::to_possible_value)))
    }
}

/// Kinds of films that `windswept export` makes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum FilmFormat {
    /// USD as text, for Blender, Houdini, Maya, usdview
    Usda,
    /// USD as numbers, a third as large; a Python with usd-core writes it (pip install usd-core)
    Usdc,
    /// NumPy's arrays
    Npz,
}

#[derive(Debug, Args)]
pub(crate) struct ExportOptions {
    /// Folder of the run
    #[arg(value_name = "DIR")]
    pub(crate) dir: PathBuf,
    /// What to write
    #[arg(long, value_name = "FORMAT", value_parser = FilmFormats)]
    pub(crate) format: FilmFormat,
    /// File to write [default: film.usda, film.usdc or film.npz in DIR]
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    /// Write all hairs that the strands stand for: those of the groom file, or hair.fibres_per_strand to each strand
    #[arg(long)]
    pub(crate) followers: bool,
    /// Replace the file if it is there
    #[arg(long)]
    pub(crate) overwrite: bool,
}

#[derive(Debug, Args)]
pub(crate) struct RenderOptions {
    /// Folder of the run; gets frames/0000.png and so on, and preview.gif
    #[arg(value_name = "DIR")]
    pub(crate) dir: PathBuf,
    /// Part of a GPU's name, or `software` [default: $WGPU_ADAPTER_NAME, else the best]
    #[arg(long, value_name = "NAME")]
    pub(crate) adapter: Option<String>,
    /// Only the frames from A to before B; A.. and ..B will do [default: all]
    #[arg(long, value_name = "A..B")]
    pub(crate) frames: Option<Range>,
    /// Only every N-th of them
    #[arg(long, value_name = "N", default_value = "1", value_parser = every::<NonZeroUsize>, allow_negative_numbers = true)]
    pub(crate) every: NonZeroUsize,
    /// Change a key of camera or picture, e.g. picture.hairs=50000; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub(crate) sets: Vec<String>,
    /// One picture of the frames at these times [s] instead
    #[arg(long, value_name = "T,T,...", value_delimiter = ',', value_parser = moment, allow_negative_numbers = true, conflicts_with_all = ["frames", "every"])]
    pub(crate) contact_sheet: Option<Vec<f64>>,
    /// File for the contact sheet [default: DIR/contact-sheet.png]
    #[arg(long, value_name = "FILE", requires = "contact_sheet")]
    out: Option<PathBuf>,
    /// Replace the pictures that are there
    #[arg(long)]
    pub(crate) overwrite: bool,
}

impl RenderOptions {
    pub(crate) fn sheet_path(&self) -> PathBuf {
        self.out.clone().unwrap_or_else(|| self.dir.join(SHEET))
    }
}
