//! Whole runs of the scenes in `examples/scenes`.

mod figures;
mod quick;
