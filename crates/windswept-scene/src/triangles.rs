//! Triangles of mesh files: the contents of a file, and the closed surface that follows from it.

pub(crate) mod band;
pub(crate) mod cache;
mod close;
pub(crate) mod distance;
mod glb;
mod obj;
pub(crate) mod tree;

use std::{ops::Range, path::Path, sync::Arc};

use glam::DVec3;

pub use band::Lattice;
pub use distance::DistanceGrid;

use crate::{
    curves,
    error::SceneError,
    limits::{LARGEST, MAX_TRIANGLES},
    scene::Up,
};

/// Triangles of a mesh file, in the units and axes of the file.
///
/// Triangles from a file have finite points and indices of points that exist; an index that is too large panics
/// elsewhere.
///
/// ```no_run
/// use glam::DVec3;
/// use windswept_scene::{DistanceGrid, Triangles, Up};
///
/// let head = Triangles::load("head.obj")?.in_metres(0.01, Up::Y);
/// let (head, holes) = head.closed();
/// let grid = DistanceGrid::bake(&head, 0.002, 0.02)?;
/// let (distance, normal) = grid.signed_distance(DVec3::new(0.0, 0.1, 0.0));
/// println!("{holes} holes closed; the surface is {distance} m away, against {normal}");
/// # Ok::<(), windswept_scene::SceneError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Triangles {
    /// Points that triangles have their corners in \[units of the file\].
    pub points: Vec<DVec3>,
    /// Indices of the three corners of each triangle, counter-clockwise as seen from outside.
    pub corners: Vec<[u32; 3]>,
    /// Normal at each corner of each triangle, zero where the file says none; empty where it says none at all.
    pub normals: Vec<[DVec3; 3]>,
    /// Place of each corner of each triangle in the texture, whose lower left corner is (0, 0); zero where the file
    /// says none, and empty where it says none at all.
    pub uvs: Vec<[[f32; 2]; 3]>,
    /// Parts of the triangles that the file gives names.
    pub parts: Vec<Part>,
    /// Metres per unit, where the file says it.
    pub unit: Option<f64>,
}

/// Successive triangles that have names.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Part {
    /// Names of the object and the groups that they belong to, and of their material; parts may share them.
    pub names: Vec<Arc<str>>,
    /// Indices of the triangles.
    pub triangles: Range<usize>,
}

impl Triangles {
    /// Endings of the files' names that are read, without the dot.
    pub const EXTENSIONS: [&'static str; 3] = ["obj", "ply", "glb"];

    /// Reads a Wavefront `.obj`, a polygon file `.ply` or a binary glTF `.glb`; polygons are cut into triangles.
    ///
    /// # Errors
    /// [`SceneError`] names the file, and says what was expected.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, SceneError> {
        let path = path.as_ref();
        let read = curves::file_bytes(path).and_then(|bytes| Self::of_bytes(path, &bytes));
        read.map_err(|error| error.of(&path.display().to_string(), ""))
    }

    /// The triangles of a file that has these bytes; `path` says of which kind it is.
    pub(crate) fn of_bytes(path: &Path, bytes: &[u8]) -> Result<Self, SceneError> {
        Self::read(&path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default(), bytes)
    }

    /// The triangles of the bytes of a file whose name ends so: one of [`Self::EXTENSIONS`].
    ///
    /// # Errors
    /// [`SceneError`] says what was expected.
    pub fn read(extension: &str, bytes: &[u8]) -> Result<Self, SceneError> {
        let read: fn(&[u8]) -> Result<Self, SceneError> = match extension {
            "obj" => obj::read,
            "ply" => polygons,
            "glb" => glb::read,
            _ => {
                let known = Self::EXTENSIONS.map(|ending| format!(".{ending}")).join(", ");
                return Err(SceneError::new(format!("expected a file of triangles: {known}")));
            }
        };
        read(bytes)?.checked()
    }

    /// The triangles in metres, with the file's `up` turned to +Y; `scale` is metres per unit. A mirror image keeps its
    /// outside.
    #[must_use]
    pub fn in_metres(mut self, scale: f64, up: Up) -> Self {
        for point in &mut self.points {
            *point = DVec3::from_array(up.turned((scale * *point).to_array()));
        }
        for normal in self.normals.as_flattened_mut() {
            *normal = DVec3::from_array(up.turned(normal.to_array()));
        }
        if up.mirrors() {
            self.corners.iter_mut().for_each(|corners| corners.swap(1, 2));
            self.normals.iter_mut().for_each(|corners| corners.swap(1, 2));
            self.uvs.iter_mut().for_each(|corners| corners.swap(1, 2));
        }
        self.unit = Some(1.0);
        self
    }

    /// Corners of the box about all triangles; `None` where there are none.
    #[must_use]
    pub fn bounds(&self) -> Option<[DVec3; 2]> {
        let points = self.corners.as_flattened().iter().map(|&i| self.points[i as usize]);
        points.fold(None, |all, x| {
            let [low, high] = all.unwrap_or([x, x]);
            Some([low.min(x), high.max(x)])
        })
    }

    /// Longest side of the box about all triangles \[units of the file\]; 0 where there are none.
    pub(crate) fn size(&self) -> f64 {
        self.bounds().map_or(0.0, |[low, high]| (high - low).max_element())
    }

    /// Area of all triangles \[square units of the file\].
    pub(crate) fn area(&self) -> f64 {
        self.places().map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length()).sum()
    }

    /// Indices of the triangles of every part that has this name; all where none is said. `None` where no part has it.
    pub(crate) fn named(&self, name: Option<&str>) -> Option<Vec<usize>> {
        let Some(name) = name else { return Some((0..self.corners.len()).collect()) };
        let parts = self.parts.iter().filter(|part| part.names.iter().any(|own| **own == *name));
        let all: Vec<usize> = parts.flat_map(|part| part.triangles.clone()).collect();
        (!all.is_empty()).then_some(all)
    }

    /// Adds triangles that have these names; normals and places in the texture are as many, or none.
    fn append(
        &mut self,
        names: Vec<Arc<str>>,
        corners: impl Iterator<Item = [u32; 3]>,
        normals: Vec<[DVec3; 3]>,
        uvs: Vec<[[f32; 2]; 3]>,
    ) {
        let first = self.corners.len();
        self.corners.extend(corners);
        if !normals.is_empty() {
            self.normals.resize(first, [DVec3::ZERO; 3]);
            self.normals.extend(normals);
        }
        if !uvs.is_empty() {
            self.uvs.resize(first, [[0.0; 2]; 3]);
            self.uvs.extend(uvs);
        }
        if !names.is_empty() {
            self.parts.push(Part { names, triangles: first..self.corners.len() });
        }
    }

    /// How far the points reach across the plane of the largest triangle \[units of the file\]; 0 for a flat surface.
    pub(crate) fn thickness(&self) -> f64 {
        let normals = self.places().map(|[a, b, c]| (b - a).cross(c - a));
        let across = normals.reduce(|a, b| if b.length() > a.length() { b } else { a });
        let across = across.unwrap_or_default().normalize_or_zero();
        let [low, high] = self.places().flatten().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| {
            [low.min(x.dot(across)), high.max(x.dot(across))]
        });
        high - low
    }

    /// Places of the corners of each triangle.
    fn places(&self) -> impl Iterator<Item = [DVec3; 3]> + '_ {
        self.corners.iter().map(|corners| corners.map(|i| self.points[i as usize]))
    }

    fn checked(mut self) -> Result<Self, SceneError> {
        let (points, triangles) = (self.points.len(), self.corners.len());
        if triangles == 0 || triangles > MAX_TRIANGLES {
            return Err(SceneError::new(format!("expected 1 to {MAX_TRIANGLES} triangles, found {triangles}")));
        }
        check_indices(&self.corners, points)?;
        if let Some(i) = self.points.iter().position(|x| !(x.abs().max_element() <= LARGEST && x.is_finite())) {
            return Err(SceneError::new(format!(
                "point {i} is {}: expected finite numbers of at most {LARGEST:e}",
                self.points[i]
            )));
        }
        let odd = |triangle: usize, what: &str| {
            SceneError::new(format!("triangle {triangle} has {what} that is not finite: expected finite numbers"))
        };
        if let Some(i) = self.normals.iter().position(|corners| !corners.iter().all(|normal| normal.is_finite())) {
            return Err(odd(i, "a normal"));
        }
        if let Some(i) = self.uvs.iter().position(|corners| !corners.iter().flatten().all(|x| x.is_finite())) {
            return Err(odd(i, "a place in the texture"));
        }
        if !self.normals.is_empty() {
            self.normals.resize(triangles, [DVec3::ZERO; 3]);
        }
        if !self.uvs.is_empty() {
            self.uvs.resize(triangles, [[0.0; 2]; 3]);
        }
        Ok(self)
    }
}

/// Triangles of a polygon file: each polygon is a fan about its first corner. A corner has the normal and the place of
/// its point.
fn polygons(bytes: &[u8]) -> Result<Triangles, SceneError> {
    let polygons = curves::ply_polygons(bytes)?;
    let fan = |polygon: Vec<u32>| -> Vec<[u32; 3]> {
        let Some((&first, rest)) = polygon.split_first() else { return Vec::new() };
        rest.windows(2).map(|pair| [first, pair[0], pair[1]]).collect()
    };
    let points: Vec<_> = polygons.points.into_iter().map(DVec3::from_array).collect();
    let corners: Vec<_> = polygons.corners.into_iter().flat_map(fan).collect();
    check_indices(&corners, points.len())?;
    let normals: Vec<_> =
        polygons.normals.iter().map(|normal| DVec3::from_array(*normal).normalize_or_zero()).collect();
    let places: Vec<_> = polygons.places.iter().map(|place| place.map(|x| x as f32)).collect();
    Ok(Triangles {
        normals: of_corners(&corners, &normals),
        uvs: of_corners(&corners, &places),
        points,
        corners,
        ..Triangles::default()
    })
}

/// Value of the point of each corner, where there is a value for each point.
fn of_corners<T: Copy>(corners: &[[u32; 3]], of_points: &[T]) -> Vec<[T; 3]> {
    let found = |corners: &[u32; 3]| corners.map(|index| of_points[index as usize]);
    if of_points.is_empty() { Vec::new() } else { corners.iter().map(found).collect() }
}

/// An error if a triangle has a point that there is not.
fn check_indices(corners: &[[u32; 3]], points: usize) -> Result<(), SceneError> {
    let beyond = |corners: &&[u32; 3]| corners.iter().any(|&index| index as usize >= points);
    let Some(triangle) = corners.iter().position(|corners| beyond(&corners)) else { return Ok(()) };
    let words =
        format!("triangle {triangle} has the points {:?}: expected numbers less than {points}", corners[triangle]);
    Err(SceneError::new(words))
}
