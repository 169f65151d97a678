//! Frames out of the engine, into files that other programs open.
//!
//! [`VtkHdfWriter`] streams a film of frames into a VTKHDF file (feature `vtkhdf`, on by default), for ParaView, VTK
//! and h5py; [`VtkHdfReader`] reads such a file again. [`Renderer`] draws pictures of
//! frames, [`write_png`] and [`Preview`] save them, the latter as a GIF that moves. [`image`] is the crate that holds them.

mod error;
mod picture;
mod preview;
mod render;
#[cfg(feature = "vtkhdf")]
mod vtkhdf;

pub use error::ExportError;
pub use image;
pub use picture::{contact_sheet, write_png};
pub use preview::Preview;
pub use render::{Renderer, View};
#[cfg(feature = "vtkhdf")]
pub use vtkhdf::{Kind, Provenance, VtkHdfReader, VtkHdfWriter};
