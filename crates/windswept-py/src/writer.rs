//! `windswept.Writer` and `windswept.VtkHdfWriter`.

use std::{
    path::PathBuf,
    sync::{Mutex, MutexGuard, PoisonError},
};

use pyo3::{
    prelude::*,
    types::{PyDict, PyTuple},
};
use windswept_export::{
    DEFAULT_FORMATS, Folder, Format, Kind, Lock, Provenance, Recording, SCENE, Schedule, files_with_made,
};
use windswept_scene::AtomicFile;

use crate::{
    errors::{ExportError, export_error, of_run, of_value},
    simulation::Simulation,
    without_gil,
};

/// Frames that a file has room for where the scene's duration has fewer: room that is not used takes none on the disk.
const ROOM: u64 = 256;

/// The most frames that a writer has room for: what was asked for, or what the scene's duration has.
fn room(sim: &windswept::Simulation, frames: Option<i64>) -> PyResult<usize> {
    let Some(frames) = frames else {
        let schedule = Schedule::new(&sim.scene().time, None);
        return Ok(usize::try_from(schedule.frames().max(ROOM)).unwrap_or(usize::MAX));
    };
    let fits = usize::try_from(frames).ok().filter(|frames| *frames > 0);
    fits.ok_or_else(|| of_value("frames", format!("expected at least 1, found {frames}")))
}

/// Whatever a writer writes into, until it is closed.
type Open<T> = Mutex<Option<T>>;

fn lock<T>(open: &Open<T>) -> MutexGuard<'_, Option<T>> {
    open.lock().unwrap_or_else(PoisonError::into_inner)
}

fn closed() -> PyErr {
    of_value("append", "the writer is closed")
}

/// Every format that `Writer` writes: its name, and what that writes.
#[pyfunction]
pub(crate) fn formats(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let formats = PyDict::new(py);
    Format::of_runs().try_for_each(|format| formats.set_item(format.name, format.writes))?;
    Ok(formats)
}

/// Writes frames of a simulation into a folder, with the files of `windswept run` but for the report and the
/// checkpoint.
///
///     with ws.Writer("out", sim) as writer:
///         writer.append(sim)
///         for frame in sim.frames(240):
///             writer.append(sim)
///
/// Every frame that `append` returned from is in the files, whatever becomes of the process. scene.toml is the scene of
/// `sim`, with which `windswept render`, `export`, `measure` and `spectrum` read the films. `sim.report()` is what
/// `windswept run` writes into report.json.
///
/// One writer or run at a time writes into a folder; `close` lets the next one in.
///
/// Args:
///     folder: made if it is not there.
///     sim: whose frames are written.
///     formats: names of `windswept.formats()`; None: those that the command writes.
///     frames: the most it has room for; None: as many as the scene's duration has, at least 256.
///     overwrite: removes what an earlier run or writer left in the folder, and what was made of it; other files stay.
///
/// Raises:
///     ExportError: a format cannot be written, or the simulation has nothing for it; the folder has files of an
///         earlier run, without `overwrite`; another run or writer has the folder, or a file in it is in the way, as a
///         link called frames.
///     ValueError: there is no such format.
#[pyclass(frozen, module = "windswept")]
pub(crate) struct Writer {
    folder: PathBuf,
    formats: Vec<&'static Format>,
    /// The lock is let go behind the last file.
    recording: Open<(Recording, Lock)>,
}

#[pymethods]
impl Writer {
    #[new]
    #[pyo3(signature = (folder, sim, *, formats=None, frames=None, overwrite=false))]
    fn new(
        py: Python<'_>,
        folder: PathBuf,
        sim: &Simulation,
        formats: Option<Vec<String>>,
        frames: Option<i64>,
        overwrite: bool,
    ) -> PyResult<Self> {
        let known = |name: &str| {
            let names = || Format::of_runs().map(|format| format.name).collect::<Vec<_>>().join(", ");
            Format::of_run(name)
                .ok_or_else(|| of_value("formats", format!("expected some of {}, found {name:?}", names())))
        };
        let formats = match &formats {
            Some(names) => names.iter().map(|name| known(name)).collect::<PyResult<Vec<_>>>()?,
            None => DEFAULT_FORMATS.iter().map(|name| known(name)).collect::<PyResult<Vec<_>>>()?,
        };
        let recording = sim.engine(py, |sim| {
            let made = std::fs::create_dir_all(&folder);
            made.map_err(|e| ExportError::new_err(format!("{}: could not be made: {e}", folder.display())))?;
            let room = room(sim, frames)?;
            let lock = Folder(&folder).lock().map_err(|error| export_error(&error))?;
            let files = files_with_made();
            Folder(&folder).check(&files).map_err(|error| export_error(&error))?;
            if let Some(earlier) = Folder(&folder).own(&files).into_iter().find(|path| path.exists() && !overwrite) {
                let words = "is of an earlier run; overwrite=True replaces all that it left";
                return Err(ExportError::new_err(format!("{}: {words}", earlier.display())));
            }
            let recording = Recording::new(&formats, sim, &folder, room).map_err(|error| export_error(&error))?;
            Folder(&folder).clear(&files).map_err(|error| export_error(&error))?;
            let scene = folder.join(SCENE);
            let written = AtomicFile::write(&scene, sim.scene().text_in(&folder).as_bytes());
            written.map_err(|e| ExportError::new_err(format!("{}: could not be written: {e}", scene.display())))?;
            Ok::<_, PyErr>((recording, lock))
        })??;
        Ok(Self { folder, formats, recording: Mutex::new(Some(recording)) })
    }

    /// Writes the state of `sim` as the next frame.
    ///
    /// Raises:
    ///     ExportError: it is not later than the last one, and no format has it; or it is of other strands or
    ///         particles, or a file has no room or cannot be written, and all other formats have it and go on.
    ///     ValueError: the writer is closed.
    fn append(&self, py: Python<'_>, sim: &Simulation) -> PyResult<()> {
        let lost = sim.engine(py, |sim| match &mut *lock(&self.recording) {
            Some((recording, _)) => recording.append(sim).map_err(|error| export_error(&error)),
            None => Err(closed()),
        })??;
        lost.first().map_or(Ok(()), |loss| Err(export_error(&loss.error)))
    }

    /// Ends the files.
    fn close(&self, py: Python<'_>) -> PyResult<()> {
        let lost = without_gil(py, || {
            let recording = lock(&self.recording).take();
            recording
                .map_or(Ok(Vec::new()), |(recording, _lock)| recording.finish().map_err(|error| export_error(&error)))
        })??;
        lost.first().map_or(Ok(()), |loss| Err(export_error(&loss.error)))
    }

    fn __enter__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    #[pyo3(signature = (*_exception))]
    fn __exit__(&self, py: Python<'_>, _exception: &Bound<'_, PyTuple>) -> PyResult<bool> {
        self.close(py)?;
        Ok(false)
    }

    fn __repr__(&self) -> String {
        let names: Vec<_> = self.formats.iter().map(|format| format.name).collect();
        format!("<windswept.Writer: {} into {}>", names.join(", "), self.folder.display())
    }
}

/// Writes frames of a simulation into one VTKHDF file, for ParaView, VTK and h5py.
///
///     with ws.VtkHdfWriter("hair.vtkhdf", sim) as writer:
///         for frame in sim.frames(240):
///             writer.append(sim)
///
/// Every frame that `append` returned from is in the file, whatever becomes of the process. Its arrays are those of the
/// command's file of that kind.
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
    writer: Open<windswept_export::VtkHdfWriter>,
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
        let writer = sim.engine(py, |sim| {
            let room = room(sim, frames)?;
            let frame = windswept_export::frame(sim).map_err(|error| of_run(&error))?;
            let adapter = sim.engine().gpu().info().to_string();
            let provenance = Provenance::of(sim.scene(), &adapter);
            windswept_export::VtkHdfWriter::create(&path, kind, &frame, room, &provenance)
                .map_err(|error| export_error(&error))
        })??;
        Ok(Self { path, kind, writer: Mutex::new(Some(writer)) })
    }

    /// Writes the state of `sim` as the next frame.
    ///
    /// Raises:
    ///     ExportError: it is not later than the last one, or of other strands or particles; the file has no room, or
    ///         cannot be written.
    ///     ValueError: the writer is closed.
    fn append(&self, py: Python<'_>, sim: &Simulation) -> PyResult<()> {
        let frame = sim.run_engine(py, windswept_export::frame)?;
        without_gil(py, || match &mut *lock(&self.writer) {
            Some(writer) => writer.append(&frame).map_err(|error| export_error(&error)),
            None => Err(closed()),
        })?
    }

    /// Closes the file.
    fn close(&self, py: Python<'_>) -> PyResult<()> {
        without_gil(py, || {
            let writer = lock(&self.writer).take();
            writer.map_or(Ok(()), |writer| writer.finish().map_err(|error| export_error(&error)))
        })?
    }

    fn __enter__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    #[pyo3(signature = (*_exception))]
    fn __exit__(&self, py: Python<'_>, _exception: &Bound<'_, PyTuple>) -> PyResult<bool> {
        self.close(py)?;
        Ok(false)
    }

    fn __repr__(&self) -> String {
        let kind = if self.kind == Kind::Hair { "hair" } else { "air" };
        format!("<windswept.VtkHdfWriter: {kind} into {}>", self.path.display())
    }
}
