//! Frames: the state at one time, and the frames of a run.

use numpy::{PyArray1, PyArray2};
use pyo3::{exceptions::PyStopIteration, prelude::*};

use crate::{arrays::matrix, errors::of_value, simulation::Simulation};

/// The state at one time. Its arrays are its own.
#[pyclass(frozen, module = "windswept", get_all)]
pub(crate) struct Frame {
    /// Steps since the start.
    step: u64,
    /// Time since the start [s].
    time: f64,
    /// The strands.
    hair: Py<FrameHair>,
    /// The air particles.
    air: Py<FrameAir>,
}

/// The strands of a frame: points root to tip, one strand after the other.
#[pyclass(frozen, module = "windswept", get_all)]
pub(crate) struct FrameHair {
    /// `(points, 3)` float32 [m].
    positions: Py<PyArray2<f32>>,
    /// `(points, 3)` float32 [m/s].
    velocities: Py<PyArray2<f32>>,
    /// `(segments, 4)` float32: quaternions x, y, z, w, material frame to world.
    orientations: Py<PyArray2<f32>>,
    /// `(strands + 1,)` int64: first point of each strand, and the number of points.
    offsets: Py<PyArray1<i64>>,
}

/// The air particles of a frame, in the order of their stable ids.
#[pyclass(frozen, module = "windswept", get_all)]
pub(crate) struct FrameAir {
    /// `(n, 3)` float32 [m], wrapped into the box.
    positions: Py<PyArray2<f32>>,
    /// `(n, 3)` float32 [m/s].
    velocities: Py<PyArray2<f32>>,
}

impl Frame {
    pub(crate) fn new(py: Python<'_>, frame: windswept::Frame) -> PyResult<Self> {
        let hair = FrameHair {
            positions: matrix(py, frame.hair.positions)?.unbind(),
            velocities: matrix(py, frame.hair.velocities)?.unbind(),
            orientations: matrix(py, frame.hair.orientations)?.unbind(),
            offsets: PyArray1::from_iter(py, frame.hair.offsets.into_iter().map(i64::from)).unbind(),
        };
        let air = FrameAir {
            positions: matrix(py, frame.air.positions)?.unbind(),
            velocities: matrix(py, frame.air.velocities)?.unbind(),
        };
        Ok(Self { step: frame.step, time: frame.time, hair: Py::new(py, hair)?, air: Py::new(py, air)? })
    }
}

#[pymethods]
impl Frame {
    fn __repr__(&self) -> String {
        format!("<windswept.Frame: step {}, {:.6} s>", self.step, self.time)
    }
}

/// An iterator over the frames of a run; `len()` is how many are left.
#[pyclass(module = "windswept")]
pub(crate) struct Frames {
    sim: Py<Simulation>,
    left: u64,
}

impl Frames {
    pub(crate) fn new(sim: &Bound<'_, Simulation>, n: Option<i64>) -> PyResult<Self> {
        let left = match n {
            Some(n) => u64::try_from(n).map_err(|_| of_value("n", format!("expected at least 0 frames, found {n}")))?,
            None => sim.get().engine(sim.py(), |sim| {
                let time = &sim.scene().time;
                let last = (time.duration / time.step).round() as u64;
                (next_frame(sim)..).take_while(|k| time.step_of_frame(*k) <= last).count() as u64
            })?,
        };
        Ok(Self { sim: sim.clone().unbind(), left })
    }
}

/// The first frame that is still to come.
fn next_frame(sim: &windswept::Simulation) -> u64 {
    let time = &sim.scene().time;
    let guess = (sim.steps() as f64 / time.steps_per_frame()) as u64;
    (guess..).find(|k| time.step_of_frame(*k) > sim.steps()).unwrap_or(guess)
}

#[pymethods]
impl Frames {
    fn __iter__(slf: PyRef<'_, Self>) -> PyRef<'_, Self> {
        slf
    }

    fn __next__(slf: &Bound<'_, Self>) -> PyResult<Frame> {
        let py = slf.py();
        let sim = {
            let this = slf.borrow();
            if this.left == 0 {
                return Err(PyStopIteration::new_err(()));
            }
            this.sim.clone_ref(py)
        };
        let sim = sim.get();
        let goal = sim.engine(py, |sim| sim.scene().time.step_of_frame(next_frame(sim)))?;
        sim.step_to(py, goal)?;
        let frame = Frame::new(py, sim.run_engine(py, |sim| sim.frame())?)?;
        let mut this = slf.borrow_mut();
        this.left = this.left.saturating_sub(1);
        Ok(frame)
    }

    fn __repr__(&self) -> String {
        format!("<windswept.Frames: {} left>", self.left)
    }

    fn __len__(&self) -> usize {
        usize::try_from(self.left).unwrap_or(usize::MAX)
    }
}
