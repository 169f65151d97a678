//! `windswept.VtkHdfWriter`.

use std::{
    path::PathBuf,
    sync::{Mutex, PoisonError},
};

use pyo3::prelude::*;
use windswept_export::{Kind, Provenance};

use crate::{
    errors::{of_export, of_run, of_value},
    outside,
    simulation::Simulation,
};

/// Frames that a file has room for where the scene's duration has fewer: room that is not used takes none on the disk.
const ROOM: usize = 256;

/// Writes frames of a simulation into a VTKHDF file, for ParaView, VTK and h5py.
///
///     with ws.VtkHdfWriter("hair.vtkhdf", sim) as writer:
///         for frame in sim.frames(240):
///             writer.append(sim)
///
/// Every frame that `append` returned from is in the file, whatever becomes of the process.
///
/// Args:
///     path: a file of that name is replaced.
///     sim: whose strands or air particles are written.
///     kind: "hair" or "air"; a file holds one of them.
///     frames: the most it has room for; None: as many as the scene's duration has, at least 256.
///
/// Raises:
///     ExportError: it cannot be written, or the simulation has nothing of this kind.
#[pyclass(frozen, module = "windswept")]
pub(crate) struct VtkHdfWriter {
    path: PathBuf,
    kind: Kind,
    writer: Mutex<Option<windswept_export::VtkHdfWriter>>,
}

#[pymethods]
impl VtkHdfWriter {
    #[new]
    #[pyo3(signature = (path, sim, *, kind="hair", frames=None))]
    fn new(py: Python<'_>, path: PathBuf, sim: &Simulation, kind: &str, frames: Option<i64>) -> PyResult<Self> {
        let kind = match kind {
            "hair" => Kind::Hair,
            "air" => Kind::Air,
            other => return Err(of_value("kind", format!("expected \"hair\" or \"air\", found {other:?}"))),
        };
        let room = frames.map(|n| {
            let fits = usize::try_from(n).ok().filter(|n| *n > 0);
            fits.ok_or_else(|| of_value("frames", format!("expected at least 1, found {n}")))
        });
        let room = room.transpose()?;
        let writer = sim.engine(py, |sim| {
            let frame = sim.frame().map_err(|error| of_run(&error))?;
            let scene = sim.scene();
            let adapter = sim.engine().gpu().info().to_string();
            let provenance = Provenance {
                scene: scene.text(),
                version: env!("CARGO_PKG_VERSION"),
                adapter: &adapter,
                seed: scene.seed,
            };
            let whole = (scene.time.duration * scene.time.frame_rate) as usize + 2;
            let room = room.unwrap_or(whole.max(ROOM));
            windswept_export::VtkHdfWriter::create(&path, kind, &frame, room, &provenance)
                .map_err(|error| of_export(&error))
        })??;
        Ok(Self { path, kind, writer: Mutex::new(Some(writer)) })
    }

    /// Writes the state of `sim` as the next frame.
    ///
    /// Raises:
    ///     ExportError: it is before the last one, or of other strands or particles; the file has no room, or cannot be written.
    ///     ValueError: the writer is closed.
    fn append(&self, py: Python<'_>, sim: &Simulation) -> PyResult<()> {
        let frame = sim.run_engine(py, |sim| sim.frame())?;
        outside(py, || match &mut *self.writer.lock().unwrap_or_else(PoisonError::into_inner) {
            Some(writer) => writer.append(&frame).map_err(|error| of_export(&error)),
            None => Err(of_value("append", "the writer is closed")),
        })?
    }

    /// Closes the file.
    fn close(&self, py: Python<'_>) -> PyResult<()> {
        outside(py, || {
            let writer = self.writer.lock().unwrap_or_else(PoisonError::into_inner).take();
            writer.map_or(Ok(()), |writer| writer.finish().map_err(|error| of_export(&error)))
        })?
    }

    fn __enter__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    #[pyo3(signature = (*_exception))]
    fn __exit__(&self, py: Python<'_>, _exception: &Bound<'_, pyo3::types::PyTuple>) -> PyResult<bool> {
        self.close(py)?;
        Ok(false)
    }

    fn __repr__(&self) -> String {
        let kind = if self.kind == Kind::Hair { "hair" } else { "air" };
        format!("<windswept.VtkHdfWriter: {kind} into {}>", self.path.display())
    }
}
