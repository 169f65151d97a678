//! `sim.hair` and `sim.air`: arrays of the state as it is when they are asked for.

use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use windswept::{HairLoads, glam::DVec3};

use crate::{
    arrays::{matrix, rows, strand_ids},
    simulation::Simulation,
};

/// Velocities and densities.
type Sampled<'py> = (Bound<'py, PyArray2<f32>>, Bound<'py, PyArray1<f32>>);

/// A read-back of which each array is handed out once, without a copy.
#[derive(Debug, Default)]
pub(crate) struct Snapshot {
    /// The state it is of.
    pub(crate) epoch: Option<u64>,
    hair_positions: Option<Vec<[f32; 3]>>,
    hair_velocities: Option<Vec<[f32; 3]>>,
    orientations: Option<Vec<[f32; 4]>>,
    air_positions: Option<Vec<[f32; 3]>>,
    air_velocities: Option<Vec<[f32; 3]>>,
}

impl Snapshot {
    pub(crate) fn new(epoch: u64, frame: windswept::Frame) -> Self {
        Self {
            epoch: Some(epoch),
            hair_positions: Some(frame.hair.positions),
            hair_velocities: Some(frame.hair.velocities),
            orientations: Some(frame.hair.orientations),
            air_positions: Some(frame.air.positions),
            air_velocities: Some(frame.air.velocities),
        }
    }
}

/// The strands of a simulation: points root to tip, one strand after the other.
///
/// Every array is a copy of the state now; write with `sim.set_hair`.
#[pyclass(frozen, module = "windswept")]
pub(crate) struct HairState {
    pub(crate) sim: Py<Simulation>,
}

#[pymethods]
impl HairState {
    /// `(points, 3)` float32 [m].
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        matrix(py, self.sim.get().take(py, |state| state.hair_positions.take())?)
    }

    /// `(points, 3)` float32 [m/s].
    #[getter]
    fn velocities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        matrix(py, self.sim.get().take(py, |state| state.hair_velocities.take())?)
    }

    /// `(segments, 4)` float32: quaternions x, y, z, w, material frame to world; d3 is the tangent. A strand of n
    /// points has n - 1.
    #[getter]
    fn orientations<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        matrix(py, self.sim.get().take(py, |state| state.orientations.take())?)
    }

    /// `(strands + 1,)` int64: first point of each strand, and the number of points.
    #[getter]
    fn offsets<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<i64>>> {
        let offsets = self.sim.get().engine(py, |sim| sim.initial().hair.point_offsets.clone())?;
        Ok(PyArray1::from_iter(py, offsets.into_iter().map(i64::from)))
    }

    /// `(strands,)` int64: number of each strand in the groom file that it comes from, or its index.
    #[getter]
    fn ids<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<i64>>> {
        let (ids, strands) =
            self.sim.get().engine(py, |sim| (sim.initial().hair.ids.clone(), sim.initial().hair.len()))?;
        Ok(strand_ids(py, &ids, strands))
    }

    /// `(strands, 4)` float32: quaternions x, y, z, w of the frames that clamp the roots.
    #[getter]
    fn root_frames<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let clamps = self.sim.get().run_engine(py, |sim| sim.clamps())?;
        matrix(py, clamps.into_iter().map(|(_, frame)| frame.as_quat().to_array()).collect())
    }

    /// `(points, 3)` float32 [N]: force of the air on each point in the last step, drag and lift, of all fibres that
    /// the strand stands for.
    #[getter]
    fn drag<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        matrix(py, self.loads(py)?.drag)
    }

    /// `(points, 3)` float32 [m/s]: velocity of the air at each point, that its drag was found with. Zero with
    /// interaction.model particles and none.
    #[getter]
    fn air_velocity<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        matrix(py, self.loads(py)?.air_velocity)
    }

    /// `(strands, 3)` float32 [N]: force of each strand's first segment on its clamp in the last step, with the
    /// pressure of other strands in it. Not a number where something else holds the strand too: a held tip, a pin, a
    /// body that it touches; zero with interaction.model particles.
    ///
    /// Raises:
    ///     RunError: there was no step since an update, a load, or a force that was set; so for drag and the others.
    #[getter]
    fn root_force<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        matrix(py, self.loads(py)?.root_force)
    }

    /// `(strands, 3)` float32 [N m]: moment of each strand on its clamp, about the root; not a number, and zero, where
    /// `root_force` is.
    #[getter]
    fn root_moment<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        matrix(py, self.loads(py)?.root_moment)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let counts = self.sim.get().engine(py, |sim| sim.counts())?;
        Ok(format!("<windswept.HairState: {} strands, {} points>", counts.strands, counts.hair_points))
    }
}

impl HairState {
    fn loads(&self, py: Python<'_>) -> PyResult<HairLoads> {
        self.sim.get().run_engine(py, |sim| sim.hair_loads())
    }
}

/// Hairs that go with the strands of a simulation at one time: points root to tip, one hair after the other. Its arrays
/// are its own.
#[pyclass(frozen, module = "windswept", get_all)]
pub(crate) struct Followers {
    /// `(points, 3)` float32 [m].
    positions: Py<PyArray2<f32>>,
    /// `(points, 3)` float32 [m/s].
    velocities: Py<PyArray2<f32>>,
    /// `(hairs + 1,)` int64: first point of each hair, and the number of points.
    offsets: Py<PyArray1<i64>>,
    /// `(hairs,)` int64: number of each hair in the groom file that it comes from, or its index.
    ids: Py<PyArray1<i64>>,
    /// `(hairs, 3)` int64: indices of the strands that each hair goes with.
    guides: Py<PyArray2<i64>>,
    /// `(hairs, 3)` float32: how much it goes with each of them.
    weights: Py<PyArray2<f32>>,
}

impl Followers {
    pub(crate) fn new(
        py: Python<'_>,
        followers: &windswept_export::Followers,
        hair: windswept::HairFrame,
    ) -> PyResult<Self> {
        let hairs = followers.len();
        let guides = followers.guides().flat_map(|(guides, _)| guides.map(i64::from));
        Ok(Self {
            ids: strand_ids(py, &hair.ids, hairs).unbind(),
            offsets: PyArray1::from_iter(py, hair.offsets.into_iter().map(i64::from)).unbind(),
            positions: matrix(py, hair.positions)?.unbind(),
            velocities: matrix(py, hair.velocities)?.unbind(),
            guides: PyArray1::from_iter(py, guides).reshape([hairs, 3])?.unbind(),
            weights: matrix(py, followers.guides().map(|(_, weights)| weights).collect())?.unbind(),
        })
    }
}

#[pymethods]
impl Followers {
    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let (hairs, points) = (self.ids.bind(py).len()?, self.positions.bind(py).len()?);
        Ok(format!("<windswept.Followers: {hairs} hairs, {points} points>"))
    }
}

/// The air particles of a simulation, in the order of their stable ids; none without air particles.
///
/// Every array is a copy of the state now; write with `sim.set_air`.
#[pyclass(frozen, module = "windswept")]
pub(crate) struct AirState {
    pub(crate) sim: Py<Simulation>,
}

#[pymethods]
impl AirState {
    /// `(n, 3)` float32 [m], wrapped into the box.
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        matrix(py, self.sim.get().take(py, |state| state.air_positions.take())?)
    }

    /// `(n, 3)` float32 [m/s].
    #[getter]
    fn velocities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        matrix(py, self.sim.get().take(py, |state| state.air_velocities.take())?)
    }

    /// `(2, 3)` float64: lower and upper corner of the box of air [m]; zeros without air particles.
    #[getter(r#box)]
    fn bounds<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let (min, size) = self.sim.get().engine(py, |sim| (sim.initial().air.min, sim.initial().air.size))?;
        Ok(PyArray2::from_owned_array(py, numpy::ndarray::arr2(&[min.to_array(), (min + size).to_array()])))
    }

    /// ρ/ρ0 of every particle now: `(n,)` float32; empty when particles do not meet.
    #[getter]
    fn density_ratio<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f32>>> {
        let ratios = self.sim.get().run_engine(py, |sim| {
            let hair = sim.counts().hair_points as usize;
            Ok(sim.density()?.into_iter().skip(hair).collect::<Vec<_>>())
        })?;
        Ok(PyArray1::from_vec(py, ratios))
    }

    /// |ω| of every particle now, plain SPH sum [1/s]: `(n,)` float32; empty when particles do not meet.
    #[getter]
    fn vorticity<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f32>>> {
        let vorticity = self.sim.get().run_engine(py, windswept::Simulation::air_vorticity)?;
        Ok(PyArray1::from_vec(py, vorticity))
    }

    /// ½ |û|² of the first of the scene's turbulence.bands at every particle now [m²/s²]: `(n,)` float32; empty when no
    /// band is strengthened. See `Simulation.spectrum` for its mean.
    #[getter]
    fn band_energy<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f32>>> {
        let energy = self.sim.get().run_engine(py, |sim| sim.band_energy())?;
        Ok(PyArray1::from_vec(py, energy))
    }

    /// The air at any places; the periodic box repeats it.
    ///
    /// Args:
    ///     points: `(n, 3)` [m].
    ///
    /// Returns:
    ///     Velocity [m/s], `(n, 3)` float32, the kernel's mean over the particles around, and density [kg/m³], `(n,)`
    ///     float32.
    ///
    /// Raises:
    ///     ValueError: a point is not finite, or the scene has no air particles.
    fn sample<'py>(&self, py: Python<'py>, points: &Bound<'py, PyAny>) -> PyResult<Sampled<'py>> {
        let places: Vec<DVec3> = rows("points", points)?.into_iter().map(DVec3::from_array).collect();
        let air = self.sim.get().run_engine(py, |sim| sim.sample_air(&places))?;
        let velocities = air.iter().map(|air| air.velocity.as_vec3().to_array()).collect();
        Ok((matrix(py, velocities)?, PyArray1::from_iter(py, air.iter().map(|air| air.density as f32))))
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let counts = self.sim.get().engine(py, |sim| sim.counts())?;
        Ok(format!("<windswept.AirState: {} particles>", counts.air))
    }
}
