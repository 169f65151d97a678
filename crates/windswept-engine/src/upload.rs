//! Values that follow from the scene, in the structs that the shaders read.

pub(crate) mod bands;
pub(crate) mod bodies;
pub(crate) mod bonds;
pub(crate) mod coarse;
pub(crate) mod fields;
pub(crate) mod meshes;
pub(crate) mod motion;
pub(crate) mod params;
pub(crate) mod pressure;
pub(crate) mod rods;
pub(crate) mod sort;
pub(crate) mod taps;
pub(crate) mod vectors;
pub(crate) mod winds;
