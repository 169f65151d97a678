//! `windswept.Simulation`.

mod held;
mod shown;

use std::{
    path::PathBuf,
    sync::{Arc, Mutex, atomic::AtomicU64},
};

use glam::{DQuat, DVec3};
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::{
    PyTraverseError, PyVisit,
    prelude::*,
    types::{PyBytes, PyDict, PyTuple},
};
use windswept::{Checkpoint, CheckpointError, Pose, RunError};
use windswept_export::Renderer;

use self::{
    held::lock,
    shown::{Shot, side},
};
use crate::{
    arrays::{Numbers, is_false, maybe_rows, quaternions, rows, shown, triple, values, vectors, whole},
    errors::{export_error, of_checkpoint, of_run, of_start, of_value},
    frames::{Frame, Frames},
    gpu,
    groom::Groom,
    scene::{checked, parsed},
    views::{AirState, Followers, HairState, Snapshot},
    warn::warn,
    without_gil,
};

/// Hair and air of one scene on a GPU.
///
///     sim = ws.Simulation(ws.Scene.load("examples/scenes/quick.toml"))
///     sim.step(100)
///     sim.hair.positions          # (points, 3) float32, m
///     for frame in sim.frames(60):
///         frame.time, frame.hair.positions
///     sim.report()["max_stretch"]
///
/// SI, right-handed, Y up. Between steps, `set_body`, `set_roots`, `set_pins`, `set_wind`, `set_force`, `set_hair` and
/// `set_air` drive it; `run` calls back for that. `render` draws it, `VtkHdfWriter` writes it.
///
/// Args:
///     scene: what to simulate.
///     groom: strands of your own in place of the scene's [hair].
///     adapter: "software", or part of an adapter's name; None: WGPU_ADAPTER_NAME, else the best. Simulations on the
///         same adapter share its device; each may be stepped from a thread of its own.
///
/// A `UserWarning` for each of the state's warnings, which `report()["warnings"]` has too, says what `windswept check`
/// would: strands of a file that are left out or do not hang as given, hair inside bodies, a step that is too long for
/// the wind.
///
/// Raises:
///     SceneError: the scene's initial state cannot be made.
///     GpuError: there is no such adapter, or it has too little room.
#[pyclass(frozen, module = "windswept")]
pub(crate) struct Simulation {
    engine: Arc<Mutex<windswept::Simulation>>,
    /// Rises with whatever changes the state.
    epoch: AtomicU64,
    snapshot: Mutex<Snapshot>,
    renderer: Mutex<Option<Renderer>>,
    followers: Mutex<Option<Arc<windswept_export::Followers>>>,
    /// The function that says what pushes in each step, where one was set.
    force: Mutex<Option<Py<PyAny>>>,
}

impl Simulation {
    fn of(engine: windswept::Simulation) -> Self {
        Self {
            engine: Arc::new(Mutex::new(engine)),
            epoch: AtomicU64::new(0),
            snapshot: Mutex::default(),
            renderer: Mutex::default(),
            followers: Mutex::default(),
            force: Mutex::default(),
        }
    }

    /// The simulation of a checkpoint that was read.
    fn go_on(py: Python<'_>, read: Result<Checkpoint, CheckpointError>, adapter: Option<&str>) -> PyResult<Self> {
        let checkpoint = read.map_err(|error| of_checkpoint(py, &error))?;
        let choice = without_gil(py, || checkpoint.choice(adapter))?;
        let gpu = gpu::device_of(py, &choice)?;
        warn(py, checkpoint.differs(&gpu))?;
        let started = without_gil(py, || checkpoint.start(&gpu))?;
        Ok(Self::of(started.map_err(|error| of_checkpoint(py, &error))?))
    }
}

#[pymethods]
impl Simulation {
    #[new]
    #[pyo3(signature = (scene, groom=None, adapter=None))]
    fn new(py: Python<'_>, scene: &Bound<'_, PyAny>, groom: Option<&Groom>, adapter: Option<&str>) -> PyResult<Self> {
        let scene = checked(scene)?;
        let gpu = gpu::device(py, adapter)?;
        let mut interrupted = None;
        let made = without_gil(py, || {
            let stop = || {
                interrupted = Python::attach(|py| py.check_signals()).err();
                interrupted.is_some()
            };
            windswept::Simulation::new_until(&gpu, &scene.inner, groom.map(|groom| &groom.inner), stop)
        })?;
        if let Some(interrupt) = interrupted {
            return Err(interrupt);
        }
        let made = made.map_err(|error| of_start(py, &error))?;
        warn(py, &made.initial().warnings)?;
        Ok(Self::of(made))
    }

    /// Runs n steps of dt. Ctrl-C stops between steps.
    ///
    /// Raises:
    ///     RunError: names what ended the run; the state is that of the last good step.
    #[pyo3(signature = (n=1))]
    fn step(&self, py: Python<'_>, n: i64) -> PyResult<()> {
        self.goal(py, n)?;
        self.step_by(py, n as u64)
    }

    /// Runs for a time, in whole steps.
    ///
    /// Args:
    ///     duration: [s], rounded to steps.
    ///     callback: called with the simulation after every `every` steps, e.g. to set roots or wind for the next; the
    ///         run ends early if it returns False.
    ///     every: steps between two calls.
    ///
    /// Raises:
    ///     RunError: as `step`; and what the callback raises.
    #[pyo3(signature = (duration, callback=None, *, every=1))]
    fn run(slf: &Bound<'_, Self>, duration: f64, callback: Option<&Bound<'_, PyAny>>, every: i64) -> PyResult<()> {
        let (py, this) = (slf.py(), slf.get());
        let steps = (duration / this.dt(py)?).round();
        if !(0.0..=f64::from(u32::MAX)).contains(&steps) {
            return Err(of_value("duration", format!("expected seconds that some steps fill, found {duration}")));
        }
        if every < 1 {
            return Err(of_value("every", format!("expected at least 1 step, found {every}")));
        }
        let goal = this.goal(py, steps as i64)?;
        let Some(callback) = callback else { return this.step_by(py, steps as u64) };
        loop {
            let now = this.steps(py)?;
            if now >= goal {
                return Ok(());
            }
            this.step_by(py, (goal - now).min(every as u64))?;
            if is_false(&callback.call1((slf,))?)? {
                return Ok(());
            }
        }
    }

    /// The next n frames of the scene's frame rate, stepping as they are asked for; None: all that its duration has
    /// left.
    ///
    /// Frame k is the state after step round(k / (frame_rate dt)). `len()` of it is n: `for frame in
    /// tqdm(sim.frames(240))`.
    #[pyo3(signature = (n=None))]
    fn frames(slf: &Bound<'_, Self>, n: Option<i64>) -> PyResult<Frames> {
        Frames::new(slf, n)
    }

    /// The state now, with the scalar of the air that the scene's `picture.air` names.
    fn frame(&self, py: Python<'_>) -> PyResult<Frame> {
        let frame = self.run_engine(py, windswept_export::frame)?;
        Frame::new(py, frame)
    }

    /// Time since the start [s].
    #[getter]
    fn time(&self, py: Python<'_>) -> PyResult<f64> {
        self.engine(py, |sim| sim.time())
    }

    /// Steps since the start.
    #[getter]
    pub(crate) fn steps(&self, py: Python<'_>) -> PyResult<u64> {
        self.engine(py, |sim| sim.steps())
    }

    /// The time step [s], `time.step`.
    #[getter]
    fn dt(&self, py: Python<'_>) -> PyResult<f64> {
        self.engine(py, |sim| sim.dt())
    }

    /// The scene as it runs: without its [hair] where a groom replaced it, with the wind that `set_wind` set. A
    /// copy: `update` takes a changed one.
    #[getter]
    fn scene<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        parsed(py, &self.engine(py, |sim| sim.scene().text().to_owned())?)
    }

    /// The scene that the simulation began with, with each `update` since as a `Change`: a run of it goes the same way.
    fn recorded<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        parsed(py, &self.engine(py, |sim| sim.recorded().to_toml())?)
    }

    /// The adapter that runs it: name, backend, driver, kind.
    #[getter]
    fn adapter(&self, py: Python<'_>) -> PyResult<String> {
        self.engine(py, |sim| sim.engine().gpu().info().to_string())
    }

    /// The strands now.
    #[getter]
    fn hair(slf: &Bound<'_, Self>) -> HairState {
        HairState { sim: slf.clone().unbind() }
    }

    /// The air particles now.
    #[getter]
    fn air(slf: &Bound<'_, Self>) -> AirState {
        AirState { sim: slf.clone().unbind() }
    }

    /// All hairs that the strands stand for, now: those of the groom, or of the scene's groom file, where it has more
    /// than are simulated, or fibres_per_strand to each strand. The strands are among them.
    ///
    /// Raises:
    ///     ExportError: a groom file that cannot be read any more.
    #[getter]
    fn followers(&self, py: Python<'_>) -> PyResult<Followers> {
        let (followers, hair) = without_gil(py, || {
            let engine = lock(&self.engine);
            let followers = self.following(&engine)?;
            let frame = engine.frame().map_err(|error| of_run(&error))?;
            let hair = followers.of(&frame).map_err(|error| export_error(&error))?;
            Ok::<_, PyErr>((followers, hair))
        })??;
        Followers::new(py, &followers, hair)
    }

    /// The report of the run so far: the command's report.json as a dict. Values that were not measured are missing.
    fn report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let report = self.run_engine(py, windswept::Simulation::report)?;
        let text = serde_json::to_string(&report).map_err(|e| of_value("report", e))?;
        py.import("json")?.call_method1("loads", (text,))
    }

    /// Keeps from now on when each pass of a timed step began and ended on the GPU, for `write_trace`.
    fn keep_trace(&self, py: Python<'_>) -> PyResult<()> {
        self.engine(py, windswept::Simulation::keep_trace)
    }

    /// Writes what was kept since `keep_trace` as a trace in Chrome's format, for chrome://tracing or Perfetto: a bar
    /// for each run of a pass. About one step in eight is timed, from the second on; none where the adapter has no
    /// timestamps.
    ///
    /// Raises:
    ///     OSError: the file cannot be written.
    fn write_trace(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        Ok(self.engine(py, |sim| sim.write_trace(&path))??)
    }

    /// Energy of the air's eddies now, by their size: the mean of ½ |û|² over the air, about the mean wind.
    ///
    /// û is `ops.band_velocity` of the scene's filter. A scale s stands for waves of about 4.44 s.
    ///
    /// Args:
    ///     scales: s of each band, `(n,)` [m].
    ///
    /// Returns:
    ///     `(n,)` float64 [m²/s²]; empty without air particles.
    ///
    /// Raises:
    ///     ValueError: a scale is not above 0, or too small for a grid on this adapter.
    fn spectrum<'py>(&self, py: Python<'py>, scales: &Bound<'_, PyAny>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let (scales, shape) = values("scales", scales, Numbers::Any)?;
        if shape.len() != 1 {
            return Err(of_value("scales", format!("expected shape (n,), found {}", shown(&shape))));
        }
        let energies = self.engine(py, |sim| sim.spectrum(&scales))?.map_err(|error| match error {
            RunError::Measurement(words) => of_value("scales", words),
            error => of_run(&error),
        })?;
        Ok(PyArray1::from_vec(py, energies))
    }

    /// Impulse that the air has given each body so far, by its pressure and by friction, in the order of the scene:
    /// `(bodies, 3)` float64 [kg m/s]; no rows without air particles. The change over a step, divided by it, is the
    /// force on the body.
    fn body_impulses<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let impulses = self.run_engine(py, |sim| sim.body_impulses())?;
        Ok(PyArray2::from_owned_array(py, numpy::ndarray::Array2::from(impulses)))
    }

    /// Where the root of each strand goes in the next step, and stays.
    ///
    /// Args:
    ///     positions: `(strands, 3)` [m].
    ///     frames: `(strands, 4)` quaternions x, y, z, w of the clamps; None: as they are.
    ///
    /// A root that jumps farther than its strand is long takes the strand along as it is, at rest.
    ///
    /// Raises:
    ///     ValueError: names the argument that does not fit; or the scene's hair.motion moves the roots.
    #[pyo3(signature = (positions, frames=None))]
    fn set_roots(
        &self,
        py: Python<'_>,
        positions: &Bound<'_, PyAny>,
        frames: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let positions: Vec<DVec3> = rows("positions", positions)?.into_iter().map(DVec3::from_array).collect();
        let frames = quaternions(maybe_rows("frames", frames)?);
        self.run_engine(py, |sim| sim.set_roots(&positions, frames.as_deref()))
    }

    /// Moves a body of the scene, in place of its keyframes: at the end of the next step it has this pose, and keeps it
    /// until it is moved again. A mesh may deform instead, by the places of its points. Hair on the body goes with it.
    ///
    /// Args:
    ///     name: of the body.
    ///     translation: `(3,)` [m], at most 1e18, from where the scene has the body without a motion; None: none.
    ///     rotation: quaternion x, y, z, w of a length above 1e-6, about the body's centre, a mesh's the origin of its
    ///         file;
    ///         None: none.
    ///     velocity: `(3,)` [m/s]; with it the body jumps there instead of coming evenly from where it is.
    ///     angular_velocity: `(3,)` [rad/s], as `velocity`.
    ///     vertices: `(n, 3)` [m], in place of all these: where the points of a mesh are, in the order of its file. It
    ///         comes there evenly.
    ///
    /// Raises:
    ///     ValueError: there is no such body, or names the argument that does not fit.
    #[pyo3(signature = (name, translation=None, rotation=None, *, velocity=None, angular_velocity=None, vertices=None))]
    #[allow(clippy::too_many_arguments)] // as Python has them
    fn set_body(
        &self,
        py: Python<'_>,
        name: &str,
        translation: Option<&Bound<'_, PyAny>>,
        rotation: Option<&Bound<'_, PyAny>>,
        velocity: Option<&Bound<'_, PyAny>>,
        angular_velocity: Option<&Bound<'_, PyAny>>,
        vertices: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        if let Some(vertices) = vertices {
            if [translation, rotation, velocity, angular_velocity].iter().any(Option::is_some) {
                return Err(of_value("vertices", "expected no pose and no velocity beside them".to_owned()));
            }
            let vertices: Vec<DVec3> = rows("vertices", vertices)?.into_iter().map(DVec3::from_array).collect();
            return self.run_engine(py, |sim| sim.set_body_vertices(name, &vertices));
        }
        let three = |name: &str, value: Option<&Bound<'_, PyAny>>| {
            value.map(|value| triple(name, value).map(DVec3::from_array)).transpose()
        };
        let rotation = rotation.map(|value| {
            let (numbers, shape) = values("rotation", value, Numbers::Any)?;
            <[f64; 4]>::try_from(numbers)
                .map(DQuat::from_array)
                .map_err(|_| of_value("rotation", format!("expected shape (4,), found {}", shown(&shape))))
        });
        let pose = Pose {
            translation: three("translation", translation)?.unwrap_or_default(),
            rotation: rotation.transpose()?.unwrap_or_default(),
        };
        let velocities = [three("velocity", velocity)?, three("angular_velocity", angular_velocity)?];
        let velocity = velocities.iter().any(Option::is_some).then(|| velocities.map(Option::unwrap_or_default));
        self.run_engine(py, |sim| sim.set_body(name, pose, velocity))
    }

    /// Pins points of hair to places, in place of all pins before. Each goes there within the next step, and stays.
    ///
    /// Args:
    ///     points: `(n,)` rows of `frame().hair.positions`.
    ///     places: `(n, 3)` [m].
    ///
    /// A pinned point is where its pin is; of several pins on a strand, those nearer to the root give by less than 0.1
    /// mm. Empty arrays release all points; tips that the scene holds go back to where it has them.
    ///
    /// Raises:
    ///     ValueError: names the argument that does not fit: a point that does not exist, is given twice, or is a root
    ///         that is held; or rods.solver is gauss-seidel, or hair.motion moves a tip.
    fn set_pins(&self, py: Python<'_>, points: &Bound<'_, PyAny>, places: &Bound<'_, PyAny>) -> PyResult<()> {
        if points.len()? == 0 && places.len()? == 0 {
            return self.run_engine(py, |sim| sim.set_pins(&[], &[]));
        }
        let places: Vec<DVec3> = rows("places", places)?.into_iter().map(DVec3::from_array).collect();
        let (points, shape) = values("points", points, Numbers::Whole)?;
        if shape.len() != 1 {
            return Err(of_value("points", format!("expected shape (n,), found {}", shown(&shape))));
        }
        let points: Vec<usize> = whole("points", &points)?.into_iter().map(|point| point as usize).collect();
        self.run_engine(py, |sim| sim.set_pins(&points, &places))
    }

    /// The mean wind from the next step on, in place of the scene's wind, ramp and gusts. All air takes the change
    /// alike in that step; the inflow's eddies stay.
    ///
    /// Args:
    ///     wind: `(3,)` [m/s].
    ///
    /// Raises:
    ///     ValueError: it is not three finite numbers, it is above 1e4 m/s, or the scene has no [air].
    fn set_wind(&self, py: Python<'_>, wind: &Bound<'_, PyAny>) -> PyResult<()> {
        let wind = DVec3::from_array(triple("wind", wind)?);
        self.run_engine(py, |sim| sim.set_wind(wind))
    }

    /// Goes on with another scene, or with other values under dotted keys, from the next step on; the state stays.
    ///
    ///     sim.update(**{"turbulence.scale": 0.012, "gravity": [0, -3, 0]})
    ///     sim.update(scene)
    ///
    /// Wind, gusts, fields, bands, viscosity, gravity, damping, stiffness and radius of fibres, motions and the camera
    /// may change; strands, points, bodies, the box of air, the step, model and solvers may not. With `sim.scene` as it
    /// is now the values are those of a new simulation. Roots, pins and a force that were set stay, and so does a wind
    /// that was set, unless the scene's wind changes.
    ///
    /// Changes go on top of a scene that is given. Buffers on the device are made anew, strands that sleep wake, and
    /// new warnings are `UserWarning`s.
    ///
    /// Raises:
    ///     SceneError: a fault of the scene, or the key of a value that a simulation keeps.
    #[pyo3(signature = (scene=None, /, **changes))]
    fn update(
        &self,
        py: Python<'_>,
        scene: Option<&Bound<'_, PyAny>>,
        changes: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<()> {
        let mut next = scene.cloned().map_or_else(|| self.scene(py), Ok)?;
        if changes.is_some() {
            next = next.call_method("replace", (), changes)?;
        }
        let next = checked(&next)?;
        let made = self.engine(py, |sim| {
            let before = sim.warnings();
            sim.update(&next.inner)?;
            Ok(sim.warnings().into_iter().filter(|warning| !before.contains(warning)).collect::<Vec<_>>())
        })?;
        warn(py, made.map_err(|error: windswept::Error| of_start(py, &error))?)?;
        // Hairs may be as thick as others, and a picture may show other things.
        lock(&self.renderer).take();
        Ok(())
    }

    /// A force of your own, from the next step on until another one is set: accelerations of hair points and air
    /// particles. Without arguments nothing is pushed any more.
    ///
    ///     sim.set_force(hair=np.broadcast_to(np.float32([0, 9.81, 0]), sim.hair.positions.shape))
    ///     sim.set_force(callback=lambda frame: 50 * (center - frame.hair.positions))
    ///
    /// Held points ignore it, and sleeping strands wake when it changes. The air does not lose what hair gets from it,
    /// and pressure takes out of it what would compress the air. Checkpoints and pickles hold the accelerations that
    /// were set last, and not a callback.
    ///
    /// Args:
    ///     hair: `(points, 3)` [m/s²]; None: hair is not pushed.
    ///     air: `(n, 3)` [m/s²], in the order of `sim.air.positions`; None: air is not pushed.
    ///     callback: called with the frame as it is before each step, in place of arrays; it returns the array of hair,
    ///         or a tuple (hair, air) in which either may be None. An exception of it ends the stepping there.
    ///
    /// Raises:
    ///     ValueError: names the argument that has not a row for each point or particle, or numbers beyond 1e18.
    #[pyo3(signature = (hair=None, air=None, *, callback=None))]
    fn set_force(
        &self,
        py: Python<'_>,
        hair: Option<&Bound<'_, PyAny>>,
        air: Option<&Bound<'_, PyAny>>,
        callback: Option<Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        if let Some(callback) = callback {
            if hair.is_some() || air.is_some() {
                return Err(of_value("callback", "expected no arrays beside it"));
            }
            if !callback.is_callable() {
                return Err(of_value(
                    "callback",
                    format!("expected a function, found {}", callback.get_type().name()?),
                ));
            }
            *lock(&self.force) = Some(callback.unbind());
            return Ok(());
        }
        self.push(py, hair, air)?;
        *lock(&self.force) = None;
        Ok(())
    }

    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        match self.force.try_lock() {
            Ok(force) => visit.call(&*force),
            // The holder of the lock keeps the force alive.
            Err(_) => Ok(()),
        }
    }

    fn __clear__(&self) {
        *lock(&self.force) = None;
    }

    /// Puts air somewhere else; what is not given stays.
    ///
    /// Args:
    ///     positions: `(n, 3)` [m], wrapped into the box.
    ///     velocities: `(n, 3)` [m/s].
    ///
    /// Raises:
    ///     ValueError: names the argument that has not a row for each particle, or numbers beyond 1e18.
    #[pyo3(signature = (positions=None, velocities=None))]
    fn set_air(
        &self,
        py: Python<'_>,
        positions: Option<&Bound<'_, PyAny>>,
        velocities: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let positions = vectors(maybe_rows("positions", positions)?);
        let velocities = vectors(maybe_rows("velocities", velocities)?);
        let done = self.run_engine(py, |sim| sim.set_air(positions.as_deref(), velocities.as_deref()));
        self.changed();
        done
    }

    /// Puts hair somewhere else; what is not given stays, and so do the places of held points.
    ///
    /// Args:
    ///     positions: `(points, 3)` [m].
    ///     velocities: `(points, 3)` [m/s].
    ///     orientations: `(segments, 4)` quaternions x, y, z, w.
    ///
    /// Raises:
    ///     ValueError: names the argument that has not a row for each point or segment, or numbers beyond 1e18.
    #[pyo3(signature = (positions=None, velocities=None, orientations=None))]
    fn set_hair(
        &self,
        py: Python<'_>,
        positions: Option<&Bound<'_, PyAny>>,
        velocities: Option<&Bound<'_, PyAny>>,
        orientations: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let positions = vectors(maybe_rows("positions", positions)?);
        let velocities = vectors(maybe_rows("velocities", velocities)?);
        let orientations = quaternions(maybe_rows("orientations", orientations)?);
        let done = self
            .run_engine(py, |sim| sim.set_hair(positions.as_deref(), velocities.as_deref(), orientations.as_deref()));
        self.changed();
        done
    }

    /// A picture of the hair now, as the command draws it: `(height, width, 4)` uint8, sRGB, opaque.
    ///
    /// The scene's [camera] and [picture] say from where and what, unless these arguments do.
    ///
    ///     sim.render(eye=[0.3, 0.1, 0.2], target=[0, 0, 0])
    ///     sim.render(camera="side")
    ///
    /// Args:
    ///     width, height: [px]; None: those of the scene's camera.
    ///     camera: name of one of the scene's cameras; None: the first.
    ///     eye, target: `(3,)` [m], place and aim of the camera; None: those of the scene's camera.
    ///     fov: vertical field of view [degrees]; None: that of the scene's camera.
    ///
    /// Raises:
    ///     ValueError: there is no such camera, or an argument is no such value.
    ///     ExportError: there is no strand to draw, or the adapter cannot.
    #[pyo3(signature = (width=None, height=None, *, camera=None, eye=None, target=None, fov=None))]
    #[allow(clippy::too_many_arguments)] // they have names
    fn render<'py>(
        &self,
        py: Python<'py>,
        width: Option<i64>,
        height: Option<i64>,
        camera: Option<String>,
        eye: Option<&Bound<'_, PyAny>>,
        target: Option<&Bound<'_, PyAny>>,
        fov: Option<f64>,
    ) -> PyResult<Bound<'py, PyArray3<u8>>> {
        let size = [side("width", width)?, side("height", height)?];
        let place = |name, place: Option<&Bound<'_, PyAny>>| place.map(|place| triple(name, place)).transpose();
        let shot = Shot { camera, eye: place("eye", eye)?, target: place("target", target)?, fov, size };
        let drawn = without_gil(py, || {
            let mut engine = lock(&self.engine);
            let camera = shot.camera(engine.scene())?;
            self.picture(&mut engine, &camera)
        })??;
        let (width, height) = (drawn.width() as usize, drawn.height() as usize);
        PyArray1::from_vec(py, drawn.into_raw()).reshape([height, width, 4])
    }

    /// Saves the simulation to a file, from which `load` goes on with the same bits.
    ///
    /// The file is written beside `path`, flushed to the disk and renamed: whatever becomes of the process, `path` is a
    /// whole checkpoint or what it was before. A simulation can be pickled and copied too.
    ///
    /// Raises:
    ///     OSError: the file cannot be written.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        self.engine(py, |sim| sim.save(&path))?.map_err(|error| of_checkpoint(py, &error))
    }

    /// Goes on with a simulation that `save` wrote, or `windswept run --checkpoint-every`. Timings start anew.
    ///
    /// On the adapter that it was saved on it has the same bits as if it had never been saved. On another one, or with
    /// another version of windswept, it goes on with a warning.
    ///
    /// Args:
    ///     path: the file.
    ///     adapter: as `Simulation`'s; None: `WGPU_ADAPTER_NAME`, else the one that it was saved on if it is there.
    ///
    /// Raises:
    ///     OSError: the file cannot be read.
    ///     ValueError: it is no checkpoint, of another version, cut off or damaged; says what, and where.
    ///     GpuError: as `Simulation`.
    #[staticmethod]
    #[pyo3(signature = (path, adapter=None))]
    fn load(py: Python<'_>, path: PathBuf, adapter: Option<&str>) -> PyResult<Self> {
        let opened = without_gil(py, || Checkpoint::open(&path))?;
        Self::go_on(py, opened, adapter)
    }

    /// The simulation of a pickle.
    #[staticmethod]
    fn _unpickled(py: Python<'_>, bytes: Vec<u8>) -> PyResult<Self> {
        let read = without_gil(py, || Checkpoint::from_bytes(&bytes, "the pickled simulation"))?;
        Self::go_on(py, read, None)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let bytes = self.engine(py, |sim| sim.to_bytes())?.map_err(|error| of_checkpoint(py, &error))?;
        let unpickled = py.get_type::<Self>().getattr("_unpickled")?;
        Ok((unpickled, PyTuple::new(py, [PyBytes::new(py, &bytes)])?))
    }

    /// Destroys the device under all simulations on it, as a driver that fails does: so that tests see what is left
    /// then.
    fn _lose_device(&self, py: Python<'_>) -> PyResult<()> {
        self.engine(py, |sim| sim.gpu().device().destroy())
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let facts = self.facts(py)?;
        let words: Vec<String> = facts.into_iter().map(|(name, value)| format!("{name} {value}")).collect();
        Ok(format!("<windswept.Simulation: {}>", words.join(", ")))
    }

    fn _repr_html_(&self, py: Python<'_>) -> PyResult<String> {
        let plain = |text: &str| text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
        let row = |(name, value): (&str, String)| format!("<tr><th>{name}</th><td>{}</td></tr>", plain(&value));
        let rows: String = self.facts(py)?.into_iter().map(row).collect();
        Ok(format!("<table>{rows}</table>"))
    }
}
