//! Frames: the state at one time, and the frames of a run.

use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::{exceptions::PyStopIteration, prelude::*};

use windswept_export::Schedule;

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
    /// `(bodies, 7)` float64: translation [m] and rotation, quaternion x, y, z, w, of each body in the scene's order,
    /// as `Simulation.set_body` takes them.
    bodies: Py<PyArray2<f64>>,
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
    /// `(n,)` float32: |ω| [1/s]; empty unless the scene's `picture.air` is "vorticity".
    vorticity: Py<PyArray1<f32>>,
    /// `(n,)` float32: ½ |û|² of the first of turbulence.bands [m²/s²]; empty unless `picture.air` is "band_energy".
    band_energy: Py<PyArray1<f32>>,
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
            vorticity: PyArray1::from_vec(py, frame.air.vorticity).unbind(),
            band_energy: PyArray1::from_vec(py, frame.air.band_energy).unbind(),
        };
        let poses = frame.bodies.iter();
        let poses: Vec<f64> =
            poses.flat_map(|pose| pose.translation.to_array().into_iter().chain(pose.rotation.to_array())).collect();
        Ok(Self {
            step: frame.step,
            time: frame.time,
            hair: Py::new(py, hair)?,
            air: Py::new(py, air)?,
            bodies: PyArray1::from_vec(py, poses).reshape([frame.bodies.len(), 7])?.unbind(),
        })
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
    schedule: Schedule,
    left: u64,
}

impl Frames {
    pub(crate) fn new(sim: &Bound<'_, Simulation>, n: Option<i64>) -> PyResult<Self> {
        let (time, steps) = sim.get().engine(sim.py(), |sim| (sim.scene().time.clone(), sim.steps()))?;
        let (schedule, left) = match n {
            Some(n) => {
                let wrong = |_| of_value("n", format!("expected at least 0 frames, found {n}"));
                (Schedule::new(&time, Some(Schedule::most_steps(&time))), u64::try_from(n).map_err(wrong)?)
            }
            None => {
                let schedule = Schedule::new(&time, None);
                let left = schedule.frames().saturating_sub(schedule.frame_after(steps));
                (schedule, left)
            }
        };
        Ok(Self { sim: sim.clone().unbind(), schedule, left })
    }
}

#[pymethods]
impl Frames {
    fn __iter__(slf: PyRef<'_, Self>) -> PyRef<'_, Self> {
        slf
    }

    fn __next__(slf: &Bound<'_, Self>) -> PyResult<Frame> {
        let py = slf.py();
        let (sim, schedule) = {
            let this = slf.borrow();
            if this.left == 0 {
                return Err(PyStopIteration::new_err(()));
            }
            (this.sim.clone_ref(py), this.schedule.clone())
        };
        let frame = sim.get().next_frame(py, &schedule)?;
        let mut this = slf.borrow_mut();
        this.left = if frame.is_some() { this.left.saturating_sub(1) } else { 0 };
        frame.map_or_else(|| Err(PyStopIteration::new_err(())), |frame| Frame::new(py, frame))
    }

    fn __repr__(&self) -> String {
        format!("<windswept.Frames: {} left>", self.left)
    }

    fn __len__(&self) -> usize {
        usize::try_from(self.left).unwrap_or(usize::MAX)
    }
}
