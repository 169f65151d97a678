//! `windswept view`: a window on a scene that runs, or on the film of a run.

use windswept::{AdapterChoice, CheckpointError};
use windswept_view::{Opened, ViewError};

use crate::arguments::{ViewOptions, What};
use crate::failure::Failure;

pub(crate) fn view(options: &ViewOptions) -> Result<(), Failure> {
    let opened = match options.what()? {
        What::Scene(scene) => Opened::Scene(scene),
        What::Checkpoint(path) => Opened::Checkpoint(path.into()),
        What::Run(folder, sets) => Opened::Run(folder.into(), sets.to_vec()),
    };
    let adapter = AdapterChoice::from_flag(options.adapter.as_deref());
    windswept_view::view(opened, adapter, options.out.clone()).map_err(|error| match error {
        ViewError::Start(error) => error.into(),
        ViewError::Export(error) => error.into(),
        ViewError::Gpu(error) | ViewError::Checkpoint(CheckpointError::Gpu(error)) => error.into(),
        ViewError::Window(_) => Failure::Run(error.to_string()),
        // Nothing has been written.
        error => Failure::Input(error.to_string()),
    })
}
