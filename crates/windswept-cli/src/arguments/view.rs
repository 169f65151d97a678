//! The arguments of `windswept view`.

use std::path::{Path, PathBuf};

use clap::Args;

use super::Changes;
use crate::failure::Failure;
use windswept_scene::CheckedScene;

#[derive(Debug, Args)]
pub(crate) struct ViewOptions {
    /// Scene file (TOML), checkpoint (.windswept) or folder of a run
    #[arg(value_name = "SCENE")]
    path: PathBuf,
    #[command(flatten)]
    changes: Changes,
    /// Folder that the window proposes for films, pictures, scenes and checkpoints; made when something is saved
    #[arg(long, value_name = "DIR", default_value = "out/view")]
    pub(crate) out: PathBuf,
    /// Part of a GPU's name, or `software` [default: $WGPU_ADAPTER_NAME, else the best that has the display]
    #[arg(long, value_name = "NAME")]
    pub(crate) adapter: Option<String>,
}

/// What the window opens on.
pub(crate) enum What<'a> {
    /// A scene with its `--set`s, checked.
    Scene(Box<CheckedScene>),
    Checkpoint(&'a Path),
    /// A run's folder, and the `--set`s.
    Run(&'a Path, &'a [String]),
}

impl ViewOptions {
    /// What the window opens on, by the kind of the path and its ending.
    pub(crate) fn what(&self) -> Result<What<'_>, Failure> {
        let (path, sets) = (self.path.as_path(), self.changes.sets.as_slice());
        if path.is_dir() {
            super::of_pictures(sets)?;
            return Ok(What::Run(path, sets));
        }
        if path.extension().is_some_and(|ending| ending == "windswept") {
            if let Some(set) = sets.first() {
                let words = format!("--set {set}: a checkpoint goes on with its own scene; the window has dials");
                return Err(Failure::Input(words));
            }
            return Ok(What::Checkpoint(path));
        }
        if path.extension().is_some_and(|ending| ending == "vtkhdf") {
            let folder = path.parent().unwrap_or(path).display();
            return Err(Failure::Input(format!(
                "{}: expected the folder that the film is in, {folder}",
                path.display()
            )));
        }
        Ok(What::Scene(Box::new(self.changes.load(path)?)))
    }
}
