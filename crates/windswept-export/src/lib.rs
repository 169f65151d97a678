//! Frames out of the engine, into files that other programs open.
//!
//! A [`Recording`] writes a simulation into a folder, frame by frame, in any of the [`FORMATS`]; a [`Run`] steps it
//! from frame to frame of a [`Schedule`]. Both the `windswept` command and the Python package are made of these three.
//!
//! A format is a row of [`FORMATS`]: a [`FrameSink`] for a run, or a [`FilmFile`] for a run that is over.
//! [`VtkHdfWriter`] streams frames into a VTKHDF file (feature `vtkhdf`, on by default), for ParaView, VTK and h5py;
//! [`VtkHdfReader`] reads such a file again. Strands also become USD files and NumPy arrays, and [`Followers`] are the
//! hairs that go with them. [`Renderer`] draws pictures of frames; [`write_png`] and [`Preview`] save them, the latter
//! as a GIF that moves. [`image`] is the crate that holds them. [`Measure`] describes a film of hair by a
//! [`Measurement`]: swing, frequency, wavelength, turning, gathering and more.

mod arrays;
mod bodies;
mod error;
mod film;
mod folder;
mod followers;
mod formats;
mod measure;
mod picture;
mod pictures;
mod preview;
mod provenance;
mod render;
mod run;
mod sink;
mod strands;
mod usd;
#[cfg(feature = "vtkhdf")]
mod vtkhdf;

pub use error::ExportError;
pub use film::{Film, Scenery, Units, UpAxis};
pub use folder::{CHECKPOINT, Folder, LOCK, Lock, REPORT, SCENE, SHEET, real_path};
pub use followers::Followers;
pub use formats::{CreateSink, DEFAULT_FORMATS, FORMATS, FilmFile, Format, files_of_run, files_with_made};
pub use image;
#[cfg(feature = "vtkhdf")]
pub use measure::measure_film;
pub use measure::{Measure, MeasureOptions, Measurement};
pub use picture::{check_sheet, contact_sheet, write_png};
pub use pictures::Pictures;
pub use preview::Preview;
pub use provenance::Provenance;
pub use render::{Renderer, Solids, View, read_texture};
pub use run::{Loss, Pace, Recording, Run, Schedule, Stop, frame};
pub use sink::{FrameSink, Start};
pub use usd::UsdWriter;
#[cfg(feature = "vtkhdf")]
pub use vtkhdf::{Kind, VtkHdfReader, VtkHdfWriter};
