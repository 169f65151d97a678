//! The arguments of commands that read a run which is over: `render`, `export`, `measure`, `spectrum`.

use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;
use windswept_export::{FilmFile, Format, SHEET, UpAxis};

#[cfg(feature = "spectrum")]
use super::numbers::scale;
use super::numbers::{every, moment, seconds};

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

/// The way to Alembic, which Blender makes of a film.
const OF_ALEMBIC: &str = "\
windswept writes no Alembic, but Blender makes it of USD, without a window: export --format usdc, and then run

blender --background --python-expr 'import bpy
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.wm.usd_import(filepath=\"film.usdc\")
bpy.ops.wm.alembic_export(filepath=\"film.abc\")'";

fn film_format(word: &str) -> Result<&'static FilmFile, String> {
    if ["abc", "alembic"].iter().any(|other| word.eq_ignore_ascii_case(other)) {
        return Err(OF_ALEMBIC.to_owned());
    }
    let names: Vec<_> = Format::of_films().map(|(format, _)| format.name).collect();
    let found = Format::of_films().find(|(format, _)| format.name == word);
    found.map(|(_, film)| film).ok_or_else(|| format!("expected one of {}", names.join(", ")))
}

/// Metres per unit of a file.
fn unit(word: &str) -> Result<f64, String> {
    let number = word.parse().ok().filter(|x| (1e-9..=1e9).contains(x));
    number.ok_or_else(|| "expected a number from 1e-9 to 1e9".to_owned())
}

fn up_axis(word: &str) -> Result<UpAxis, String> {
    match word {
        "y" => Ok(UpAxis::Y),
        "z" => Ok(UpAxis::Z),
        _ => Err("expected y or z".to_owned()),
    }
}

fn film_formats_help() -> String {
    let rows: Vec<_> = Format::of_films().map(|(format, _)| format!("{} ({})", format.name, format.writes)).collect();
    format!("What to write: {}", rows.join(", "))
}

fn film_help() -> String {
    let files: Vec<_> = Format::of_films().map(|(_, film)| film.file).collect();
    format!("File to write [default: one of {} in DIR]", files.join(", "))
}

#[derive(Debug, Args)]
pub(crate) struct ExportOptions {
    /// Folder of the run
    #[arg(value_name = "DIR")]
    pub(crate) dir: PathBuf,
    #[arg(long, value_name = "FORMAT", value_parser = film_format, help = film_formats_help())]
    pub(crate) format: &'static FilmFile,
    #[arg(long, value_name = "FILE", help = film_help())]
    pub(crate) out: Option<PathBuf>,
    /// Axis that points up in the file: y as in windswept, or z
    #[arg(long, value_name = "AXIS", value_parser = up_axis, default_value = "y")]
    pub(crate) up: UpAxis,
    /// Metres per unit of the file: 0.01 for centimetres
    #[arg(long, value_name = "M", value_parser = unit, default_value = "1")]
    pub(crate) scale: f64,
    /// Write all hairs that the strands stand for: those of the groom file, or hair.fibres_per_strand to each strand
    #[arg(long)]
    pub(crate) followers: bool,
    /// Write the hair alone, without bodies and cameras
    #[arg(long)]
    pub(crate) hair_only: bool,
    /// Replace the file if it is there
    #[arg(long)]
    pub(crate) overwrite: bool,
}

#[derive(Debug, Args)]
pub(crate) struct RenderOptions {
    /// Folder of the run
    #[arg(value_name = "DIR")]
    pub(crate) dir: PathBuf,
    /// Part of a GPU's name, or `software` [default: $WGPU_ADAPTER_NAME, else the best]
    #[arg(long, value_name = "NAME")]
    pub(crate) adapter: Option<String>,
    /// Only the frames from A to before B; A.. and ..B will do [default: all]
    #[arg(long, value_name = "A..B")]
    pub(crate) frames: Option<Range>,
    /// Only every N-th of them
    #[arg(
        long,
        value_name = "N",
        default_value = "1",
        value_parser = every::<NonZeroUsize>,
        allow_negative_numbers = true
    )]
    pub(crate) every: NonZeroUsize,
    /// Name of the camera that takes the pictures [default: the scene's first]
    #[arg(long, value_name = "NAME")]
    pub(crate) camera: Option<String>,
    /// Change a key of camera or picture, e.g. picture.hairs=50000; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub(crate) sets: Vec<String>,
    /// One picture of the frames at these times [s] instead
    #[arg(
        long,
        value_name = "T,T,...",
        value_delimiter = ',',
        value_parser = moment,
        allow_negative_numbers = true,
        conflicts_with_all = ["frames", "every"]
    )]
    pub(crate) contact_sheet: Option<Vec<f64>>,
    /// Folder that gets frames/0000.png and so on, and preview.gif [default: DIR]; with --contact-sheet its file
    /// [default: DIR/contact-sheet.png]
    #[arg(long, value_name = "PATH")]
    pub(crate) out: Option<PathBuf>,
    /// Replace the pictures that are there
    #[arg(long)]
    pub(crate) overwrite: bool,
}

impl RenderOptions {
    pub(crate) fn sheet_path(&self) -> PathBuf {
        self.out.clone().unwrap_or_else(|| self.dir.join(SHEET))
    }
}

/// `--frames A..B`: from A to before B.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Range {
    pub(crate) from: usize,
    pub(crate) to: Option<usize>,
}

impl FromStr for Range {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || "expected A..B, A.. or ..B, frames from A to before B".to_owned();
        let (from, to) = text.split_once("..").ok_or_else(expected)?;
        let number = |text: &str| text.parse::<usize>().map_err(|_| expected());
        let range = Self {
            from: if from.is_empty() { 0 } else { number(from)? },
            to: if to.is_empty() { None } else { Some(number(to)?) },
        };
        if range.to.is_some_and(|to| to <= range.from) { Err(expected()) } else { Ok(range) }
    }
}

#[cfg(test)]
mod tests {
    use super::Range;

    #[test]
    fn ranges_are_read() {
        let range = |from, to| Ok(Range { from, to });
        assert_eq!("3..7".parse(), range(3, Some(7)));
        assert_eq!("3..".parse(), range(3, None));
        assert_eq!("..7".parse(), range(0, Some(7)));
        for wrong in ["", "3", "7..3", "3..3", "a..b", "-1..2", "1.5..2"] {
            assert!(wrong.parse::<Range>().is_err(), "{wrong}");
        }
    }
}
