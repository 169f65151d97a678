//! `windswept.Groom`.

use std::path::PathBuf;

use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::{prelude::*, types::PyBytes};
use windswept_scene::{
    Curves, End, Fibre, GroomFile, Moduli, PerStrand, Profile, RestCurvature, RestShape, Stiffness, keys::Key,
};

use crate::{
    arrays::{Numbers, chunks, finite, shown, strand_ids, unchecked, values, whole},
    errors::{of_value, scene_error},
    warn::warn,
    without_gil,
};

const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Strands of your own, or of a groom file (`Groom.load`): they replace the scene's [hair] wholly.
///
/// Each value is a scalar or an array `(strands,)`. Where only some strands are guides, those are simulated, and all
/// strands are the simulation's `followers`, which go with them.
///
/// Args:
///     points: `(strands, n, 3)` or, with offsets, `(points, 3)` floats, root to tip [m].
///     offsets: `(strands + 1,)` first point of each strand, and the number of points.
///     group: number of a strand's group, for your own use.
///     radius: of a fibre [m]; of a flat one the semi-major axis, along d2.
///     density: of a fibre [kg/m³].
///     youngs_modulus: E [Pa].
///     poissons_ratio: above -1, at most 0.5.
///     rest_curvature: rest Darboux vector (kappa1, kappa2, tau) [1/m] in the material frame: `(3,)`, `(strands, 3)`,
///         `(strands, n - 1, 3)` or, with offsets, `(segments, 3)`: one a joint, joint 0 the clamp. A clamped tip's
///         joint is as the last. None: the given shape is the rest shape, tip_frame included; frames go from segment to
///         segment by the smallest rotation.
///     root_frame: `(4,)` or `(strands, 4)` quaternion x, y, z, w of the clamp, of any length but 0; its d3 need not be
///         along the first segment. None: d3 along the first segment, d1 by the smallest rotation from +x (from +z if
///         parallel).
///     root: "clamped", "pinned" or "free".
///     tip: the same; "clamped" with the direct solver only.
///     fibres_per_strand: real hairs that a strand stands for.
///     point_mass: of every point [kg]. None: from density, radius and lengths.
///     aspect: semi-minor over semi-major axis of the cross-section, above 0, at most 1.
///     tip_frame: `(4,)` or `(strands, 4)` quaternion of a clamped tip; other tips have none. None: turned on by half a
///         joint from the last segment.
///     friction: Coulomb's coefficient of the strands on other strands, at least 0; model two-way only.
///     rest: "weightless": the given shape is the rest shape, and weight bends strands from it. "hanging": gravity
///         alone leaves strands with a clamped root as they are given; those of another root are warned of. Not with
///         rest_curvature.
///     guides: `(strands,)` bool, which strands are simulated; the others follow the three of those whose roots are
///         nearest. None: all are simulated.
///     stiffness: factor of the stiffness to bend and twist along each strand: `(pairs, 2)` floats, parts of the length
///         from the root, from 0 to 1, with the factors there, linear between. None: 1.
///
/// Raises:
///     ValueError: a wrong shape or dtype, a NaN; names the argument.
///     SceneError: points that coincide, a strand of one point, values out of range; `key` is `groom.` and the
///         argument.
#[pyclass(frozen, module = "windswept")]
#[derive(Debug, Clone)]
pub(crate) struct Groom {
    pub(crate) inner: windswept_scene::Groom,
}

#[pymethods]
impl Groom {
    #[new]
    #[pyo3(signature = (
        points, offsets=None, group=None, radius=None, density=None, youngs_modulus=None, poissons_ratio=None,
        rest_curvature=None, root_frame=None, root=None, tip=None, fibres_per_strand=None, point_mass=None, aspect=None,
        tip_frame=None, friction=None, rest=None, guides=None, stiffness=None
    ), text_signature = "(points, offsets=None, group=None, radius=4e-5, density=1320.0, youngs_modulus=4e9, \
        poissons_ratio=0.38, rest_curvature=None, root_frame=None, root='clamped', tip='free', fibres_per_strand=1.0, \
        point_mass=None, aspect=1.0, tip_frame=None, friction=0.3, rest='weightless', guides=None, stiffness=None)")]
    fn new(
        py: Python<'_>,
        points: &Bound<'_, PyAny>,
        offsets: Option<&Bound<'_, PyAny>>,
        group: Option<&Bound<'_, PyAny>>,
        radius: Option<&Bound<'_, PyAny>>,
        density: Option<&Bound<'_, PyAny>>,
        youngs_modulus: Option<&Bound<'_, PyAny>>,
        poissons_ratio: Option<&Bound<'_, PyAny>>,
        rest_curvature: Option<&Bound<'_, PyAny>>,
        root_frame: Option<&Bound<'_, PyAny>>,
        root: Option<&Bound<'_, PyAny>>,
        tip: Option<&Bound<'_, PyAny>>,
        fibres_per_strand: Option<&Bound<'_, PyAny>>,
        point_mass: Option<&Bound<'_, PyAny>>,
        aspect: Option<&Bound<'_, PyAny>>,
        tip_frame: Option<&Bound<'_, PyAny>>,
        friction: Option<&Bound<'_, PyAny>>,
        rest: Option<&str>,
        guides: Option<&Bound<'_, PyAny>>,
        stiffness: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let (points, offsets) = strands(points, offsets)?;
        let mut groom = windswept_scene::Groom::new(points, offsets);
        let strands = groom.len();
        for (name, value, set) in [
            ("radius", radius, (|fibre, x| fibre.radius = x) as fn(&mut Fibre, f64)),
            ("density", density, |fibre, x| fibre.density = x),
            ("youngs_modulus", youngs_modulus, |fibre, x| {
                if let Stiffness::Moduli(Moduli { youngs_modulus, .. }) = &mut fibre.stiffness {
                    *youngs_modulus = x;
                }
            }),
            ("poissons_ratio", poissons_ratio, |fibre, x| {
                if let Stiffness::Moduli(Moduli { poissons_ratio, .. }) = &mut fibre.stiffness {
                    *poissons_ratio = x;
                }
            }),
            ("fibres_per_strand", fibres_per_strand, |fibre, x| fibre.fibres_per_strand = x),
            ("aspect", aspect, |fibre, x| fibre.aspect = x),
            ("point_mass", point_mass, |fibre, x| fibre.point_mass = Some(x)),
        ] {
            if let Some(value) = value {
                let values = scalars(name, value)?;
                groom.fibre.set(strands, name, &values, set).map_err(|error| scene_error(py, &error))?;
            }
        }
        groom.guides = guides.map(|value| flags("guides", value)).transpose()?.unwrap_or_default();
        if let Some(value) = group {
            groom.group = groups(value)?;
        }
        groom.root_frame = root_frame.map(|value| frames("root_frame", value)).transpose()?;
        groom.tip_frame = tip_frame.map(|value| frames("tip_frame", value)).transpose()?;
        if let Some(value) = friction {
            groom.friction = scalars("friction", value)?;
        }
        if let Some(value) = root {
            groom.root = ends("root", value)?;
        }
        if let Some(value) = tip {
            groom.tip = ends("tip", value)?;
        }
        groom.stiffness = stiffness.map(profile).transpose()?;
        groom.rest = rest.map_or(Ok(RestShape::Weightless), rest_shape)?;
        groom.rest_curvature = rest_curvature.map(|value| curvature(value, &groom)).transpose()?;
        groom.check().map_err(|error| scene_error(py, &error))?;
        Ok(Self { inner: groom })
    }

    /// Reads strands from a groom file, as `hair.file` of a scene does.
    ///
    /// The ending of the name says the format: .hair, .data, .bin, .npz, .npy or .ply. All strands of the file are the
    /// groom's, but for those that cannot be simulated. Where the file marks guides (`guides` of a .npz), or `strands`
    /// asks for fewer than there are, only those are simulated, and the others follow them: `guides` says which. A
    /// `UserWarning` says how many strands are left out, and how many follow.
    ///
    /// Args:
    ///     path: the file.
    ///     scale: metres per unit of the file; needed, unless the file says its unit.
    ///     up: axis of the file that points up ("y", "z" or "x"), or its axes that become x, y and z ("yzx").
    ///     points: points per strand; they are placed anew, evenly along each. None: the file's.
    ///     strands: how many are simulated, of the file's guides, or of all its strands, those whose roots are far from
    ///         one another.
    ///         None: all guides, or all strands where the file marks none.
    ///     radius: of a fibre [m]. None: the file's, where it has one that is a hair's, 15 to 150 µm on average; else
    ///         40 µm.
    ///     points_per_strand: of a file that does not say where a strand ends.
    ///     seed: draws the first of the strands that are kept.
    ///     rest: "hanging": gravity alone leaves the strands as the file has them. "weightless": it bends them from
    ///         there.
    ///     file_guides: whether the file's marks count; False: as if it marked no guides.
    ///
    /// Raises:
    ///     SceneError: a file that cannot be read, with the byte and what was expected there; no strand that can be
    ///         simulated.
    ///     ValueError: a number out of range; names the argument.
    #[staticmethod]
    #[pyo3(signature = (
        path, scale=None, up="y", points=None, strands=None, radius=None, points_per_strand=None, seed=1, rest="hanging",
        file_guides=true
    ))]
    fn load(
        py: Python<'_>,
        path: PathBuf,
        scale: Option<f64>,
        up: &str,
        points: Option<i64>,
        strands: Option<i64>,
        radius: Option<&Bound<'_, PyAny>>,
        points_per_strand: Option<i64>,
        seed: i128,
        rest: &str,
        file_guides: bool,
    ) -> PyResult<Self> {
        let fits = |_| of_value("seed", format!("expected a whole number from 0 to {}, found {seed}", u64::MAX));
        let drawn_by = u64::try_from(seed).map_err(fits)?;
        let up = up.parse().map_err(|()| {
            let expected = Key::find("hair.up").map(Key::expected).unwrap_or_default();
            of_value("up", format!("expected {expected}; found {up:?}"))
        })?;
        let file = GroomFile {
            scale,
            up,
            rest: rest_shape(rest)?,
            file_radius: radius.is_none(),
            file_guides,
            points_per_strand: count("points_per_strand", points_per_strand)?,
            strands: count("strands", strands)?,
            points: count("points", points)?,
            ..GroomFile::new(path.to_string_lossy())
        };
        let (mut inner, notes) = without_gil(py, || file.groom(drawn_by))?.map_err(|error| scene_error(py, &error))?;
        if let Some(radius) = radius {
            let values = scalars("radius", radius)?;
            let set = |fibre: &mut Fibre, x| fibre.radius = x;
            inner.fibre.set(inner.len(), "radius", &values, set).map_err(|error| scene_error(py, &error))?;
        }
        inner.check().map_err(|error| scene_error(py, &error))?;
        warn(py, notes)?;
        Ok(Self { inner })
    }

    /// Writes all strands to a groom file, in metres; the ending of its name says the format: .hair, .data, .npz, .npy,
    /// .ply.
    ///
    /// A .npz file keeps everything: `points`, `offsets`, `ids`, `radius`, `groups`, `root_uv`, `guides` and
    /// `meters_per_unit`. A `UserWarning` says what of it another format cannot hold. A file that is there is replaced.
    ///
    /// Raises:
    ///     SceneError: a format that cannot hold the strands; a file that cannot be written.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let saved = without_gil(py, || self.inner.curves().and_then(|curves| curves.save(&path)))?;
        warn(py, saved.map_err(|error| scene_error(py, &error))?)
    }

    /// Points of all strands, strand by strand, root to tip: `(points, 3)` float64 [m].
    #[getter]
    fn points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let points = &self.inner.points;
        PyArray1::from_slice(py, points.as_flattened()).reshape([points.len(), 3])
    }

    /// First point of each strand, and the number of points: `(strands + 1,)` int64.
    #[getter]
    fn offsets<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        PyArray1::from_iter(py, self.inner.offsets.iter().map(|&offset| offset.into()))
    }

    /// Number of each strand in the file that it came from, or its index: `(strands,)` int64.
    #[getter]
    fn ids<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        strand_ids(py, &self.inner.ids, self.inner.len())
    }

    /// Which strands are simulated; the others follow them: `(strands,)` bool.
    #[getter]
    fn guides<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        PyArray1::from_iter(py, (0..self.inner.len()).map(|s| self.inner.is_guide(s)))
    }

    /// The groom of a pickle.
    #[staticmethod]
    fn _unpickled(py: Python<'_>, version: &str, bytes: Vec<u8>) -> PyResult<Self> {
        let refused = |what: String| of_value("the pickled groom", what);
        if version != VERSION {
            return Err(refused(format!("expected one of windswept {VERSION}, found one of {version}")));
        }
        let inner: windswept_scene::Groom = postcard::from_bytes(&bytes).map_err(|e| refused(e.to_string()))?;
        inner.check().map_err(|error| scene_error(py, &error))?;
        Ok(Self { inner })
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        let bytes = postcard::to_stdvec(&self.inner).map_err(|e| of_value("groom", e))?;
        let unpickled = py.get_type::<Self>().getattr("_unpickled")?;
        Ok((unpickled, (VERSION, PyBytes::new(py, &bytes))))
    }

    fn __len__(&self) -> usize {
        self.inner.len()
    }

    fn __repr__(&self) -> String {
        let (strands, points) = (self.inner.len(), self.inner.points.len());
        let simulated = (0..strands).filter(|&s| self.inner.is_guide(s)).count();
        let guides = if simulated < strands { format!(", {simulated} of them guides") } else { String::new() };
        format!("<windswept.Groom: {strands} strands{guides}, {points} points>")
    }
}

/// Result of `__reduce__`: a function, and the version and the bytes that it is called with.
type Reduced<'py> = (Bound<'py, PyAny>, (&'static str, Bound<'py, PyBytes>));

/// Points and offsets, from either way to say them.
fn strands(points: &Bound<'_, PyAny>, offsets: Option<&Bound<'_, PyAny>>) -> PyResult<(Vec<[f64; 3]>, Vec<u32>)> {
    let (numbers, shape) = unchecked("points", points, Numbers::Floats, |values, _| values.to_vec())?;
    let found = shown(&shape);
    // Padding may be of not-a-numbers.
    let check = |values: &[f64], shape: &[usize]| finite("points", values, shape);
    match (&shape[..], offsets) {
        (&[strands, n, 3], None) => {
            let offsets = (0..=strands).map(|s| u32::try_from(s * n));
            let offsets = offsets.collect::<Result<_, _>>().map_err(|_| of_value("points", "too many for 32 bits"))?;
            let curves = Curves { points: chunks(&numbers), offsets, ..Curves::default() };
            let (curves, padded) = curves.without_padding();
            if padded == 0 {
                check(&numbers, &shape)?;
            } else {
                check(curves.points.as_flattened(), &[curves.points.len(), 3])?;
                let words =
                    format!("{padded} of the {strands} strands had padding behind their tips, which is cut off");
                warn(points.py(), [words])?;
            }
            Ok((curves.points, curves.offsets))
        }
        (&[_, 3], Some(offsets)) => {
            check(&numbers, &shape)?;
            let (offsets, shape) = values("offsets", offsets, Numbers::Whole)?;
            if shape.len() != 1 {
                return Err(of_value("offsets", format!("expected shape (strands + 1,), found {}", shown(&shape))));
            }
            Ok((chunks(&numbers), whole("offsets", &offsets)?))
        }
        (_, None) => Err(of_value("points", format!("expected shape (strands, n, 3), or offsets; found {found}"))),
        (_, Some(_)) => Err(of_value("points", format!("expected shape (points, 3) with offsets, found {found}"))),
    }
}

/// A scalar, or one for each strand.
fn scalars(name: &str, value: &Bound<'_, PyAny>) -> PyResult<PerStrand<f64>> {
    let (numbers, shape) = values(name, value, Numbers::Any)?;
    match shape.len() {
        0 => Ok(numbers[0].into()),
        1 => Ok(numbers.into()),
        _ => Err(of_value(name, format!("expected a scalar or shape (strands,), found {}", shown(&shape)))),
    }
}

/// Pairs of a part of the length and a factor.
fn profile(value: &Bound<'_, PyAny>) -> PyResult<Profile> {
    let (numbers, shape) = values("stiffness", value, Numbers::Any)?;
    match shape[..] {
        [_, 2] => Ok(Profile(chunks(&numbers))),
        _ => Err(of_value("stiffness", format!("expected shape (pairs, 2), found {}", shown(&shape)))),
    }
}

fn rest_shape(word: &str) -> PyResult<RestShape> {
    word.parse().map_err(|()| of_value("rest", format!("expected \"hanging\" or \"weightless\", found {word:?}")))
}

/// A number of strands or points.
fn count(name: &str, value: Option<i64>) -> PyResult<Option<u32>> {
    let fits = |n: i64| u32::try_from(n).map_err(|_| of_value(name, format!("expected a whole number, found {n}")));
    value.map(fits).transpose()
}

fn groups(value: &Bound<'_, PyAny>) -> PyResult<PerStrand<u32>> {
    let (numbers, shape) = values("group", value, Numbers::Whole)?;
    let numbers = whole("group", &numbers)?;
    match shape.len() {
        0 => Ok(numbers[0].into()),
        1 => Ok(numbers.into()),
        _ => Err(of_value("group", format!("expected a scalar or shape (strands,), found {}", shown(&shape)))),
    }
}

/// A truth value for each strand, as booleans or as 0 and 1.
fn flags(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<bool>> {
    let (numbers, shape) = values(name, value, Numbers::Flags)?;
    match numbers.iter().find(|x| ![0.0, 1.0].contains(*x)) {
        Some(x) => Err(of_value(name, format!("expected True or False, or 1 or 0, found {x}"))),
        None if shape.len() != 1 => Err(of_value(name, format!("expected shape (strands,), found {}", shown(&shape)))),
        None => Ok(numbers.iter().map(|x| *x != 0.0).collect()),
    }
}

fn frames(name: &str, value: &Bound<'_, PyAny>) -> PyResult<PerStrand<[f64; 4]>> {
    let (numbers, shape) = values(name, value, Numbers::Any)?;
    match shape[..] {
        [4] => Ok(PerStrand::All([numbers[0], numbers[1], numbers[2], numbers[3]])),
        [_, 4] => Ok(PerStrand::Each(chunks(&numbers))),
        _ => Err(of_value(name, format!("expected shape (4,) or (strands, 4), found {}", shown(&shape)))),
    }
}

fn ends(name: &str, value: &Bound<'_, PyAny>) -> PyResult<PerStrand<End>> {
    let end = |word: String| {
        let words = || of_value(name, format!("expected \"clamped\", \"pinned\" or \"free\", found {word:?}"));
        word.parse::<End>().map_err(|()| words())
    };
    if let Ok(word) = value.extract::<String>() {
        return Ok(PerStrand::All(end(word)?));
    }
    // NumPy's arrays of strings come as their own type.
    let list = if value.hasattr("tolist")? { value.call_method0("tolist")? } else { value.clone() };
    let words: Vec<String> = list.extract().map_err(|_| of_value(name, "expected a word, or one for each strand"))?;
    words.into_iter().map(end).collect::<PyResult<Vec<_>>>().map(PerStrand::Each)
}

fn curvature(value: &Bound<'_, PyAny>, groom: &windswept_scene::Groom) -> PyResult<RestCurvature> {
    let name = "rest_curvature";
    let (numbers, shape) = values(name, value, Numbers::Any)?;
    let strands = groom.len();
    let segments = groom.points.len().saturating_sub(strands);
    let even = |n: usize| groom.offsets.windows(2).all(|w| i64::from(w[1]) - i64::from(w[0]) == n as i64 + 1);
    match shape[..] {
        [3] => Ok(RestCurvature::Strand([numbers[0], numbers[1], numbers[2]].into())),
        [rows, 3] if rows == segments => Ok(RestCurvature::Joints(chunks(&numbers))),
        [rows, 3] if rows == strands => Ok(RestCurvature::Strand(chunks(&numbers).into())),
        [rows, n, 3] if rows == strands && even(n) => Ok(RestCurvature::Joints(chunks(&numbers))),
        _ => {
            let words = format!("expected shape (3,), ({strands}, 3), ({segments}, 3) or (strands, n - 1, 3)");
            Err(of_value(name, format!("{words}; found {}", shown(&shape))))
        }
    }
}
