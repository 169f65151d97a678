//! Solids that the triangles of mesh files enclose: `body.shape = "mesh"`.

use std::{
    fmt,
    hash::{DefaultHasher, Hasher},
    ops::RangeInclusive,
    path::Path,
    sync::{Arc, Mutex, PoisonError, Weak},
};

use glam::{DQuat, DVec3};

use crate::{
    body::turned,
    curves::{
        file_bytes, no_unit,
        npz::{self, MovingMesh},
    },
    declare::{Field, Row, Written, table},
    error::SceneError,
    faults::At,
    frames::Frames,
    keys::{
        Fallback::{Derived, RequiredIf, Value},
        Key, Kind,
        Kind::{Choice, Length, Path as PathOf, Positive, Table},
    },
    motion::Motion,
    reader::Reader,
    scatter::Areas,
    scene::{Scene, Up},
    triangles::{DistanceGrid, Triangles, band::Lattice, cache},
    units::with_scale,
    write::Writer,
};

/// Cells that a grid reaches beyond its surface: half a particle spacing of air is within, where distances are those of
/// the surface.
pub(crate) const MARGIN: f64 = 10.0;

/// Longest sides between which a mesh may well be what its scale makes of it \[m\]. Where the grid of a larger one has
/// too many nodes, its scale may be that of other units.
pub(crate) const LIKELY: RangeInclusive<f64> = 0.05..=2.0;

table! {
    /// A mesh file, and how its triangles become a solid.
    #[derive(Debug, Clone, PartialEq)]
    pub struct MeshFile, becomes Solid, by Solid::of_scene {
        /// Solid of the caller's own, in place of the file's. A scene's text cannot say it.
        solid as "": Option<Solid> = Table, "", Derived("");
        /// Mesh file whose triangles enclose the body (.obj, .ply, .glb).
        file: Option<String> = PathOf, "", RequiredIf("without frames");
        /// File of a mesh that deforms, in place of a mesh file (.npz): positions (T, n, 3), triangles (m, 3) and times
        /// (T) in s. It moves by these poses, and has no keyframes.
        frames: Option<String> = PathOf, "", Derived("none: the mesh keeps its shape");
        /// Metres per unit of the file: 0.01 for centimetres.
        scale: Option<f64> = Positive, "m", RequiredIf("with shape mesh, unless the file says its unit");
        /// Axis of the file that points up, or the axes of the file that become x, y and z; xzy, yxz and zyx mirror.
        up: Up = Choice(Up::WORDS), "", Value(Up::Y);
        /// Spacing of the grid of distances from the mesh.
        resolution: Option<f64> = Length, "m", Derived("0.002; less for a small mesh: 128 cells along its longest side; more for one whose grid would be too large");
    }
}

impl MeshFile {
    /// A file that says its unit and points up along y.
    #[must_use]
    pub fn new(file: impl Into<String>) -> Self {
        Self { file: Some(file.into()), ..Self::none() }
    }

    /// A file of poses that says its unit and points up along y.
    #[must_use]
    pub fn frames(file: impl Into<String>) -> Self {
        Self { frames: Some(file.into()), ..Self::none() }
    }

    const fn none() -> Self {
        Self { file: None, frames: None, scale: None, up: Up::Y, resolution: None, solid: None }
    }

    /// The key that names the file, and the file.
    #[must_use]
    pub fn named(&self) -> (&'static str, &str) {
        match (&self.file, &self.frames) {
            (None, Some(frames)) => ("frames", frames),
            (file, _) => ("file", file.as_deref().unwrap_or_default()),
        }
    }
}

/// A solid is written as its file.
impl Written for Solid {
    fn write(&self, name: &'static str, writer: &mut Writer) {
        self.file.write(name, writer);
    }
}

/// A solid has no keys of its own.
impl Field for Solid {
    type Checked = Self;

    fn list(_: Row<Self>, _: &str, _: &mut Vec<Key>) {}

    fn read(_: Row<Self>, _: &Reader<'_>) -> Option<Self> {
        None
    }

    fn check(&self, _: &'static str, _: Kind, _: &Scene, _: &At<'_>) -> Option<Self> {
        Some(self.clone())
    }
}

/// Places where a grid is compared with its triangles: a hundredth of them says enough.
const ERROR_PLACES: u32 = 10_000;
/// Numbers whose multiples' fractions lie evenly in a square (Roberts 2018, "The unreasonable effectiveness of
/// quasirandom sequences").
const EVENLY: [f64; 2] = [0.754_877_666_246_693, 0.569_840_290_998_053];

/// Volume that the surface of a mesh file encloses, its holes covered, somewhere in the world.
///
/// Solids of one content share it, as long as one of them is there: loading a file again costs reading it, and no more
/// memory.
#[derive(Debug, Clone)]
pub struct Solid {
    file: Arc<MeshFile>,
    content: Arc<Content>,
    /// Rotation from the file's axes, after `up`, to the world's.
    rotation: DQuat,
    /// Place of the file's origin, or of the centre of its first pose, in the world \[m\].
    origin: DVec3,
    /// Poses of a mesh that deforms.
    frames: Option<Arc<Frames>>,
}

/// Content of a file, in metres.
struct Content {
    triangles: Triangles,
    /// Holes of the surface, which are covered, and the part of it that is cover.
    holes: usize,
    covered: f64,
    grid: DistanceGrid,
    /// Radius of the largest ball that fits inside \[m\].
    inradius: f64,
    /// Poses of a mesh that deforms.
    frames: Option<Arc<Frames>>,
}

/// How much there is, and not each of millions of numbers.
impl fmt::Debug for Content {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { triangles, holes, covered, grid, inradius, .. } = self;
        let (triangles, nodes) = (triangles.corners.len(), grid.counts);
        write!(
            f,
            "{triangles} triangles, {holes} holes ({covered} of the surface), {nodes:?} nodes {} m apart, inradius {inradius} m",
            grid.spacing
        )
    }
}

/// Key of a content: the inputs that determine it.
#[derive(Debug, Clone, PartialEq)]
struct Print {
    /// Number of the file's bytes, and a number that others hardly have.
    bytes: (usize, u64),
    ending: Option<String>,
    scale: Option<f64>,
    up: Up,
    resolution: Option<f64>,
}

/// Contents that some solid has. It stays locked while a content is made, so that none is made twice.
static KNOWN: Mutex<Vec<(Print, Weak<Content>)>> = Mutex::new(Vec::new());

/// Equal solids are of one file, read in one way, with one content, in one place.
impl PartialEq for Solid {
    fn eq(&self, other: &Self) -> bool {
        self.file == other.file
            && Arc::ptr_eq(&self.content, &other.content)
            && self.rotation == other.rotation
            && self.origin == other.origin
            && self.frames == other.frames
    }
}

impl Solid {
    /// Reads a mesh file, and makes the grid of its distances. A grid that takes longer than 0.3 s to make is kept in
    /// the folder that the environment variable `WINDSWEPT_CACHE` names, if it names one, and read from there the next
    /// time.
    ///
    /// # Errors
    /// [`SceneError`] where the file cannot be read, does not say its unit, or encloses nothing, and where the grid
    /// would be too large. The error names the key of the [`MeshFile`] that is at fault: `file`, `scale`, `up`, or
    /// `resolution` where that is said.
    pub fn load(file: MeshFile) -> Result<Self, SceneError> {
        let (key, path) = file.named();
        let path = Path::new(path).to_owned();
        let of_file = |error: SceneError| error.at(key, None);
        let bytes = file_bytes(&path).map_err(of_file)?;
        let mut hasher = DefaultHasher::new();
        hasher.write(&bytes);
        let print = Print {
            bytes: (bytes.len(), hasher.finish()),
            ending: path.extension().map(|ending| ending.to_string_lossy().to_lowercase()),
            scale: file.scale,
            up: file.up,
            resolution: file.resolution,
        };
        let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
        known.retain(|(_, content)| content.strong_count() > 0);
        let found = known.iter().find(|(other, _)| *other == print).and_then(|(_, content)| content.upgrade());
        let content = match found {
            Some(content) => content,
            None => {
                let content = Arc::new(match file.frames {
                    Some(_) => Content::of_poses(npz::moving_mesh(&bytes).map_err(of_file)?, &file)?,
                    None => Content::new(Triangles::of_bytes(&path, &bytes).map_err(of_file)?, &file)?,
                });
                known.push((print, Arc::downgrade(&content)));
                content
            }
        };
        Ok(Self::of(file, content))
    }

    /// The solid of a content, where it was written.
    fn of(file: MeshFile, content: Arc<Content>) -> Self {
        let frames = content.frames.clone();
        let origin = frames.as_ref().map_or(DVec3::ZERO, |frames| frames.center());
        Self { file: Arc::new(file), content, rotation: DQuat::IDENTITY, origin, frames }
    }

    /// The solid of a scene's mesh.
    fn of_scene(file: &MeshFile, at: &At<'_>) -> Option<Self> {
        if let Some(own) = &file.solid {
            return Some(own.clone());
        }
        match (&file.file, &file.frames) {
            (None, None) => at.fault("file", "is missing: expected a mesh file, or frames"),
            (Some(_), Some(_)) => at.fault("frames", "expected none beside file: it has the triangles itself"),
            _ => {
                let (key, path) = file.named();
                return Self::load(file.clone()).map_err(|error| at.fault_of(&error, key, &format!("{path}: "))).ok();
            }
        }
        None
    }

    /// Volume that triangles in metres enclose, with a grid of this spacing \[m\], or of
    /// [`DistanceGrid::spacing_for`] them. It has no file, so that a scene's text cannot say it.
    ///
    /// # Errors
    /// As [`DistanceGrid::bake`].
    pub fn enclosed(triangles: Triangles, resolution: Option<f64>) -> Result<Self, SceneError> {
        let file = MeshFile { scale: Some(1.0), resolution, ..MeshFile::new("") };
        let content = Arc::new(Content::new(triangles, &file)?);
        Ok(Self::of(file, content))
    }

    /// Volume that a mesh encloses which is in these poses \[m\] at these times \[s\], as a file of
    /// [`MeshFile::frames`]. It has no file, so that a scene's text cannot say it.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub fn deforming(
        times: Vec<f64>,
        poses: &[Vec<DVec3>],
        corners: Vec<[u32; 3]>,
        resolution: Option<f64>,
    ) -> Result<Self, SceneError> {
        let file = MeshFile { scale: Some(1.0), resolution, ..MeshFile::frames("") };
        let poses = poses.iter().map(|pose| pose.iter().map(|x| x.to_array()).collect()).collect();
        let content = Content::of_poses(MovingMesh { times, poses, corners, unit: None }, &file)?;
        Ok(Self::of(file, Arc::new(content)))
    }

    /// The file that the solid is of.
    #[must_use]
    pub fn file(&self) -> &MeshFile {
        &self.file
    }

    /// The triangles of the file, in metres, in its own place.
    #[must_use]
    pub fn triangles(&self) -> &Triangles {
        &self.content.triangles
    }

    /// Distances from the surface, in the file's own place.
    #[must_use]
    pub fn grid(&self) -> &DistanceGrid {
        &self.content.grid
    }

    /// Number of the surface's holes, which are covered.
    #[must_use]
    pub fn holes(&self) -> usize {
        self.content.holes
    }

    /// Part of the surface that covers holes, 0 to 1.
    #[must_use]
    pub fn covered(&self) -> f64 {
        self.content.covered
    }

    /// Rotation from the file's own place to the solid's.
    #[must_use]
    pub fn rotation(&self) -> DQuat {
        self.rotation
    }

    /// Place of the file's origin \[m\].
    #[must_use]
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// Poses of a mesh that deforms.
    #[must_use]
    pub fn frames(&self) -> Option<&Arc<Frames>> {
        self.frames.as_ref()
    }

    /// The poses of a mesh that a caller may let deform, which has this motion: its own, or the one that it rests in.
    ///
    /// # Errors
    /// [`SceneError`] where the grids of two poses would be too large.
    pub fn poses(&self, motion: &Motion) -> Result<Arc<Frames>, SceneError> {
        let at_rest = || Frames::at_rest(self.triangles(), self.origin, motion.clone(), self.grid().spacing);
        self.frames.clone().map_or_else(|| at_rest().map(Arc::new), Ok)
    }

    /// The solid of the same mesh that goes through these poses.
    #[must_use]
    pub fn with_poses(&self, frames: Arc<Frames>) -> Self {
        Self { frames: Some(frames), ..self.clone() }
    }

    /// The solid as it is at a time \[s\], in its own place.
    pub(crate) fn at(&self, time: f64) -> Self {
        let Some(frames) = self.frames() else { return self.clone() };
        let points = frames.points(time);
        let Lattice { origin, spacing, counts } = *frames.lattice();
        let Content { triangles, holes, covered, inradius, .. } = &*self.content;
        let grid = DistanceGrid { origin, spacing, counts, values: frames.distances(&points) };
        let points = points.into_iter().map(|x| x.as_dvec3()).collect();
        let triangles = Triangles { points, normals: Vec::new(), ..triangles.clone() };
        let (holes, covered, inradius) = (*holes, *covered, *inradius);
        let content = Content { triangles, holes, covered, grid, inradius, frames: None };
        Self { content: Arc::new(content), frames: None, ..self.clone() }
    }

    /// Whether both have one grid in memory.
    #[must_use]
    pub fn shares_grid(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.content, &other.content)
    }

    /// Longest side of the box about the triangles, in the file's own axes \[m\].
    #[must_use]
    pub fn size(&self) -> f64 {
        self.triangles().size()
    }

    /// Radius of the largest ball that fits inside \[m\].
    #[must_use]
    pub fn inradius(&self) -> f64 {
        self.content.inradius
    }

    /// Signed distance of `x` from the surface \[m\], and the unit vector along its gradient:
    /// [`DistanceGrid::signed_distance`].
    #[must_use]
    pub fn signed_distance(&self, x: DVec3) -> (f64, DVec3) {
        let (distance, normal) = self.grid().signed_distance(self.rotation.inverse() * (x - self.origin));
        (distance, self.rotation * normal)
    }

    /// How far the grid puts the surface off its triangles \[m\]: the distance that it says there, which a hundredth of
    /// their area exceeds. Triangles with the solid on both sides, as those of eyeballs in a head, do not count.
    #[must_use]
    pub fn grid_error(&self) -> f64 {
        let triangles: Vec<usize> = (0..self.triangles().corners.len()).collect();
        let areas = Areas::new(self, &triangles);
        let off = (0..ERROR_PLACES).filter_map(|k| {
            let part = (f64::from(k) + 0.5) / f64::from(ERROR_PLACES);
            let (triangle, _, x) =
                areas.place([part, (EVENLY[0] * f64::from(k)).fract(), (EVENLY[1] * f64::from(k)).fract()]);
            let [a, b, c] = self.corners(triangle);
            let across = self.grid().spacing * (b - a).cross(c - a).normalize_or_zero();
            let is_outside = [across, -across].into_iter().any(|way| self.signed_distance(x + way).0 > 0.0);
            is_outside.then(|| self.signed_distance(x).0.abs())
        });
        let mut off: Vec<f64> = off.collect();
        off.sort_by(f64::total_cmp);
        off.get(off.len() - off.len().div_ceil(100)).copied().unwrap_or_default()
    }

    /// Places of the three corners of a triangle \[m\], by its index.
    #[must_use]
    pub fn corners(&self, triangle: usize) -> [DVec3; 3] {
        let Triangles { points, corners, .. } = self.triangles();
        corners[triangle].map(|i| self.place(points[i as usize]))
    }

    /// Where a point of the file is \[m\].
    fn place(&self, x: DVec3) -> DVec3 {
        self.origin + self.rotation * x
    }

    /// The solid with each of its points where `place`, which must be rigid, has it.
    pub(crate) fn moved(&self, place: impl Fn(DVec3) -> DVec3) -> Self {
        let (origin, rotation) = (place(self.origin), turned(place, self.origin, self.rotation));
        Self { rotation, origin, ..self.clone() }
    }

    /// Corners of the box about the triangles \[m\].
    pub(crate) fn bounds(&self) -> [DVec3; 2] {
        let corners = (0..self.triangles().corners.len()).flat_map(|i| self.corners(i));
        corners.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
    }
}

impl Content {
    /// The content of a file of poses: the mesh in its first one.
    fn of_poses(mesh: MovingMesh, file: &MeshFile) -> Result<Self, SceneError> {
        let Some(scale) = file.scale.or(mesh.unit) else {
            return Err(SceneError::new(no_unit(None)).with_help("give scale, the metres per unit").at("scale", None));
        };
        let (frames, first) = Frames::new(mesh, scale, file.up, file.resolution)
            .map_err(|error| error.at(if file.resolution.is_some() { "resolution" } else { "frames" }, None))?;
        let spacing = frames.lattice().spacing;
        let in_place = MeshFile { scale: Some(1.0), up: Up::Y, resolution: Some(spacing), ..file.clone() };
        let rest = Self::new(first, &in_place).map_err(|error| match error.key() {
            Some("resolution") if file.resolution.is_some() => error,
            _ => error.at("frames", None),
        })?;
        Ok(Self { frames: Some(Arc::new(frames)), ..rest })
    }

    fn new(triangles: Triangles, file: &MeshFile) -> Result<Self, SceneError> {
        let bounds = triangles.bounds().map(|corners| corners.map(|x| x.to_array()));
        let Some(scale) = file.scale.or(triangles.unit) else {
            return Err(SceneError::new(no_unit(bounds))
                .with_help("give scale, the metres per unit")
                .at("scale", None));
        };
        let triangles = triangles.in_metres(scale, file.up);
        let (surface, holes) = triangles.closed();
        let spacing = file.resolution.unwrap_or_else(|| surface.bounds().map_or(1.0, DistanceGrid::spacing_for));
        let grid = cache::bake(&surface, spacing, MARGIN * spacing);
        let size = surface.size();
        let grid = grid.map_err(|error| match (error.key(), file.resolution) {
            (Some("surface"), _) => error.at(file.named().0, None),
            (Some("spacing"), None) if size > *LIKELY.end() => error.at("scale", None).with_help(format!(
                "the mesh is {}. For one that is so large, give a larger resolution",
                with_scale(size, scale, &LIKELY)
            )),
            // The key that sets the grid's spacing, if the scene has it.
            (_, resolution) => error.at(if resolution.is_some() { "resolution" } else { file.named().0 }, None),
        })?;
        let inradius = grid.inradius();
        let covered = (1.0 - triangles.area() / surface.area()).max(0.0);
        Ok(Self { triangles, holes, covered, grid, inradius, frames: None })
    }
}
