//! Frames out of the engine, into files that other programs open.
//!
//! [`VtkHdfWriter`] streams a film of frames into a VTKHDF file (feature `vtkhdf`, on by default), for ParaView, VTK
//! and h5py.

mod error;
#[cfg(feature = "vtkhdf")]
mod vtkhdf;

pub use error::ExportError;
#[cfg(feature = "vtkhdf")]
pub use vtkhdf::{Kind, Provenance, VtkHdfWriter};
