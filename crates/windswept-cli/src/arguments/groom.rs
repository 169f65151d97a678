//! The arguments of `windswept groom`.

use std::path::PathBuf;

use clap::{Args, Subcommand, value_parser};
use windswept_scene::{GroomFormat, Up, keys::Key, limits::MAX_POINTS_OF_A_STRAND};

use super::numbers::{count, positive, whole};

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
    #[arg(
        long,
        value_name = "N",
        value_parser = value_parser!(u32).range(2..=i64::from(MAX_POINTS_OF_A_STRAND)),
        allow_negative_numbers = true
    )]
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

fn up(word: &str) -> Result<Up, String> {
    let expected = || Key::find("hair.up").map(Key::expected).unwrap_or_default();
    word.parse().map_err(|()| format!("expected {}", expected()))
}
