//! Bodies that hair and air stay out of: `[[body]]`.
//!
//! Everything about a body that depends on its shape stands here, for the CPU, and in `shaders/common/body.wgsl`, for
//! the GPU. Everybody else asks a [`Shape`] for its signed distance, its bounds or its skin.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DVec3};

use crate::{
    declare::{InvalidValue, Keys, table, words},
    error::SceneError,
    keys::{
        Fallback::{Derived, Value},
        Key,
        Kind::{Choice, Length, NonNegative, Path, Positive, Table, Tables, Text, Vector},
    },
    limits::{MAX_BLOCKED, MAX_GRID_VALUES},
    motion::Motion,
    reader::Reader,
    scene::{Bounds, Scene, Up},
    solid::{MeshFile, Solid},
    triangles::Triangles,
    write::Writer,
};

/// Samples along each side of the box, to see how much of it is blocked.
const SAMPLES: u32 = 24;
/// Depth below a surface that is rounding \[radii of the largest ball that fits inside\].
const ROUNDING: f64 = 1e-3;
/// Depth below the surface of a mesh that its grid may make of a point on it, next to an edge \[spacings\].
const GRID_ERROR: f64 = 0.25;

table! {
    /// One `[[body]]`.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Body {
        /// Name of the body, for dotted keys and errors.
        name: String = Text, "", Value("body".to_owned());
        /// Shape of the body where it is written, before it moves.
        shape as "": Shape = Table, "", Derived("");
        /// Coulomb's coefficient of friction of hair on the body.
        friction: f64 = NonNegative, "", Value(0.3);
        /// Keyframes of the body, about its centre, or about the origin of its mesh file.
        motion: Motion = Tables, "", Derived("it rests");
    }
}

/// Shape of a body \[m\]: a solid that is given by points, so that it moves when they do.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// All points within `radius` of a point.
    Sphere {
        /// Centre of the sphere.
        center: [f64; 3],
        /// Radius of the solid.
        radius: f64,
    },
    /// All points within `radius` of a line.
    Capsule {
        /// Start of the line.
        start: [f64; 3],
        /// End of the line.
        end: [f64; 3],
        /// Radius of the solid.
        radius: f64,
    },
    /// All points that the triangles of a file enclose.
    Mesh(Solid),
}

words! {
    /// `body.shape`.
    pub(crate) enum ShapeName {
        /// [`Shape::Sphere`]
        Sphere = "sphere",
        /// [`Shape::Capsule`]
        Capsule = "capsule",
        /// [`Shape::Mesh`]
        Mesh = "mesh",
    }
}

table! {
    /// The keys that spell a [`Shape`].
    pub(crate) struct SpelledShape {
        /// Shape of the body: with center and radius, with start, end and radius, or with file.
        shape: ShapeName = Choice(ShapeName::WORDS), "", Value(ShapeName::Sphere);
        /// Centre of the sphere.
        center: Option<[f64; 3]> = Vector, "m", Derived("needed with shape sphere");
        /// Start of the capsule's axis.
        start: Option<[f64; 3]> = Vector, "m", Derived("needed with shape capsule");
        /// End of the capsule's axis.
        end: Option<[f64; 3]> = Vector, "m", Derived("needed with shape capsule");
        /// Radius of the sphere, or about the capsule's axis.
        radius: Option<f64> = Length, "m", Derived("needed with shape sphere or capsule");
        /// Mesh file whose triangles enclose the body (.obj, .ply, .glb).
        file: Option<String> = Path, "", Derived("needed with shape mesh");
        /// Metres per unit of the file: 0.01 for centimetres.
        scale: Option<f64> = Positive, "m", Derived("needed with shape mesh, unless the file says its unit");
        /// Axis of the file that points up, or the axes of the file that become x, y and z; xzy, yxz and zyx mirror.
        up: Option<Up> = Choice(Up::WORDS), "", Derived("y");
        /// Spacing of the grid of distances from the mesh.
        resolution: Option<f64> = Length, "m", Derived("0.002, or less: 128 cells along its longest side");
    }
}

impl SpelledShape {
    /// No key but the shape.
    fn new(shape: ShapeName) -> Self {
        let (center, start, end, radius) = (None, None, None, None);
        Self { shape, center, start, end, radius, file: None, scale: None, up: None, resolution: None }
    }
}

/// The spheres about both ends and all between them, for the GPU; a sphere has its ends in one point, and so has a
/// mesh, which is no round shape: its surface is that of its grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Round {
    /// Ends of the axis \[m\].
    pub ends: [DVec3; 2],
    /// Radius about the axis \[m\].
    pub radius: f64,
}

impl Shape {
    /// The shape as `shaders/common/body.wgsl` knows it.
    #[must_use]
    pub fn round(&self) -> Round {
        match *self {
            Self::Sphere { center, radius } => Round { ends: [DVec3::from_array(center); 2], radius },
            Self::Capsule { start, end, radius } => Round { ends: [start, end].map(DVec3::from_array), radius },
            Self::Mesh(ref solid) => Round { ends: [solid.origin(); 2], radius: 0.0 },
        }
    }

    /// The solid of a mesh; `None` for other shapes.
    #[must_use]
    pub fn solid(&self) -> Option<&Solid> {
        match self {
            Self::Mesh(solid) => Some(solid),
            Self::Sphere { .. } | Self::Capsule { .. } => None,
        }
    }

    /// The shape with each of its points where `place` has it: `place` must be rigid.
    #[must_use]
    pub fn moved(&self, place: impl Fn(DVec3) -> DVec3) -> Self {
        let moved = |x: [f64; 3]| place(DVec3::from_array(x)).to_array();
        match *self {
            Self::Sphere { center, radius } => Self::Sphere { center: moved(center), radius },
            Self::Capsule { start, end, radius } => Self::Capsule { start: moved(start), end: moved(end), radius },
            Self::Mesh(ref solid) => Self::Mesh(solid.moved(place)),
        }
    }

    /// The point that the body turns about \[m\]: its middle, or the origin of its file.
    #[must_use]
    pub fn center(&self) -> DVec3 {
        let [start, end] = self.round().ends;
        0.5 * (start + end)
    }

    /// Signed distance of `x` from the surface \[m\], negative inside, and its gradient: the outward normal of the
    /// surface where that is nearest to `x`.
    #[must_use]
    pub fn signed_distance(&self, x: DVec3) -> (f64, DVec3) {
        if let Self::Mesh(solid) = self {
            return solid.signed_distance(x);
        }
        let Round { ends: [start, end], radius } = self.round();
        let axis = end - start;
        let length = axis.length();
        let along = if length > 0.0 { (x - start).dot(axis / length).clamp(0.0, length) / length } else { 0.0 };
        let gap = x - (start + along * axis);
        // On the axis any way across it leads out.
        (gap.length() - radius, gap.normalize_or(axis.any_orthonormal_vector()))
    }

    /// Radius of the largest ball that fits into the body \[m\]: how thin it is.
    #[must_use]
    pub fn inradius(&self) -> f64 {
        self.solid().map_or_else(|| self.round().radius, Solid::inradius)
    }

    /// Depth up to which a point that is meant to be on the surface may be below it \[m\].
    pub(crate) fn slack(&self) -> f64 {
        ROUNDING * self.inradius() + self.solid().map_or(0.0, |solid| GRID_ERROR * solid.grid().spacing)
    }

    /// Corners of the box about the body \[m\].
    #[must_use]
    pub fn bounds(&self) -> [DVec3; 2] {
        if let Self::Mesh(solid) = self {
            return solid.bounds();
        }
        let Round { ends: [start, end], radius } = self.round();
        [start.min(end) - radius, start.max(end) + radius]
    }

    /// Points of the surface \[m\] and the outward normals there: of a mesh the three corners of each triangle, else a
    /// grid of `rows` from pole to pole, an even number, and `sides` + 1 points around, of which the last is the first.
    #[must_use]
    pub fn skin(&self, rows: u32, sides: u32) -> Vec<(DVec3, DVec3)> {
        if let Self::Mesh(solid) = self {
            let corners = (0..solid.triangles().corners.len()).flat_map(|i| solid.corners(i));
            return corners.map(|x| (x, solid.signed_distance(x).1)).collect();
        }
        let Round { ends, radius } = self.round();
        let axis = (ends[1] - ends[0]).normalize_or(DVec3::Y);
        let across = axis.any_orthonormal_vector();
        let basis = DMat3::from_cols(across, axis.cross(across), axis);
        let points = (0..rows).flat_map(|i| (0..=sides).map(move |k| (i, k)));
        let point = |(i, k)| {
            // Two half spheres; the side is between their equators.
            let far = i >= rows / 2;
            let latitude = PI * (f64::from(i - u32::from(far)) / f64::from(rows - 2) - 0.5);
            let around = TAU * f64::from(k) / f64::from(sides);
            let normal = DVec3::new(latitude.cos() * around.cos(), latitude.cos() * around.sin(), latitude.sin());
            let normal = basis * normal;
            (ends[usize::from(far)] + radius * normal, normal)
        };
        points.map(point).collect()
    }

    /// The surface as triangles between the points of [`Self::skin`], counter-clockwise as seen from outside; those of
    /// a mesh are as its file has them.
    #[must_use]
    pub fn surface(&self, rows: u32, sides: u32) -> Triangles {
        let points: Vec<DVec3> = self.skin(rows, sides).into_iter().map(|(x, _)| x).collect();
        let corners = if self.solid().is_some() {
            (0..points.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect()
        } else {
            let squares = (0..rows - 1).flat_map(|i| (0..sides).map(move |k| i * (sides + 1) + k));
            squares.flat_map(|a| [[a, a + 1, a + sides + 1], [a + 1, a + sides + 2, a + sides + 1]]).collect()
        };
        Triangles { points, corners, unit: Some(1.0), ..Triangles::default() }
    }

    fn spelled(&self) -> SpelledShape {
        match *self {
            Self::Sphere { center, radius } => {
                SpelledShape { center: Some(center), radius: Some(radius), ..SpelledShape::new(ShapeName::Sphere) }
            }
            Self::Capsule { start, end, radius } => SpelledShape {
                start: Some(start),
                end: Some(end),
                radius: Some(radius),
                ..SpelledShape::new(ShapeName::Capsule)
            },
            Self::Mesh(ref solid) => {
                let MeshFile { file, scale, up, resolution } = solid.file().clone();
                let (file, up) = (Some(file), Some(up));
                SpelledShape { file, scale, up, resolution, ..SpelledShape::new(ShapeName::Mesh) }
            }
        }
    }
}

impl Body {
    /// The body's shape where it is at `time` \[s\].
    #[must_use]
    pub fn at(&self, time: f64) -> Shape {
        let center = self.shape.center();
        self.shape.moved(|x| self.motion.place(center, x, time))
    }
}

impl Keys for Shape {
    fn list(path: &str, all: &mut Vec<Key>) {
        SpelledShape::list(path, all);
    }

    fn read(reader: &Reader<'_>) -> Result<Self, SceneError> {
        const KEYS: [&str; 8] = ["center", "start", "end", "radius", "file", "scale", "up", "resolution"];
        let spelled = SpelledShape::read(reader)?;
        let word = spelled.shape.word();
        let (own, has): (&[&str], _) = match spelled.shape {
            ShapeName::Sphere => (&["center", "radius"], "center"),
            ShapeName::Capsule => (&["start", "end", "radius"], "start and end"),
            ShapeName::Mesh => (&["file", "scale", "up", "resolution"], "file"),
        };
        if let Some(other) = KEYS.iter().find(|key| reader.has(key) && !own.contains(key)) {
            return Err(reader.fault(other, format!("expected no {other} with shape \"{word}\", which has {has}")));
        }
        let missing = |name: &str| reader.fault(name, format!("is missing: shape \"{word}\" has {has}"));
        let point = |name: &str, point: Option<[f64; 3]>| point.ok_or_else(|| missing(name));
        let radius = || {
            let words = || format!("is missing: expected {}", Length.expected());
            spelled.radius.ok_or_else(|| reader.fault("radius", words()))
        };
        match spelled.shape {
            ShapeName::Sphere => {
                let radius = radius()?;
                Ok(Self::Sphere { center: point("center", spelled.center)?, radius })
            }
            ShapeName::Capsule => {
                let radius = radius()?;
                let (start, end) = (point("start", spelled.start)?, point("end", spelled.end)?);
                if DVec3::from_array(start).distance(DVec3::from_array(end)) < 1e-6 * radius {
                    let words = "is the same point as start; expected another, or shape \"sphere\"";
                    return Err(reader.fault("end", words));
                }
                Ok(Self::Capsule { start, end, radius })
            }
            ShapeName::Mesh => {
                let SpelledShape { file, scale, up, resolution, .. } = spelled;
                let file = file.ok_or_else(|| missing("file"))?;
                let said = MeshFile { file: file.clone(), scale, up: up.unwrap_or_default(), resolution };
                let read = Solid::load_beside(said, reader.folder());
                read.map(Self::Mesh).map_err(|error| {
                    let fault = reader.fault(error.key().unwrap_or("file"), format!("{file}: {}", error.message()));
                    error.help().into_iter().fold(fault, |fault, help| fault.with_help(help))
                })
            }
        }
    }

    fn write(&self, writer: &mut Writer) {
        self.spelled().write(writer);
    }

    fn invalid_value(&self) -> Option<InvalidValue> {
        self.spelled().invalid_value()
    }
}

impl Scene {
    /// The solids of the meshes, one for each grid of distances that is in memory: bodies of one file share it.
    #[must_use]
    pub fn solids(&self) -> Vec<&Solid> {
        let mut all: Vec<&Solid> = Vec::new();
        for solid in self.bodies.iter().filter_map(|body| body.shape.solid()) {
            if !all.iter().any(|other| other.shares_grid(solid)) {
                all.push(solid);
            }
        }
        all
    }

    /// The grids of all meshes must fit into one buffer, and the wind must get past the bodies.
    pub(crate) fn check_bodies(&self, reader: &Reader<'_>) -> Result<(), SceneError> {
        let nodes: usize = self.solids().iter().map(|solid| solid.grid().values.len()).sum();
        if nodes > MAX_GRID_VALUES {
            let most = |body: &Body| body.shape.solid().map_or(0, |solid| solid.grid().values.len());
            let largest = (0..self.bodies.len()).max_by_key(|&i| most(&self.bodies[i])).unwrap_or_default();
            let words = format!(
                "the grids of all meshes have {nodes} nodes together; expected at most {MAX_GRID_VALUES}, with a larger resolution"
            );
            return Err(reader.fault(&format!("body.{largest}.resolution"), words));
        }
        let Some((air, bounds)) = self.filled() else { return Ok(()) };
        let bodies: Vec<Shape> = self.bodies.iter().map(|body| body.at(0.0)).collect();
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate().filter(|&(axis, _)| air.wind[axis] != 0.0) {
            let part = blocked(&bodies, &bounds, axis);
            if part > MAX_BLOCKED {
                let words =
                    format!("bodies block {:.0} % of air.box across {name}; expected room for the wind", 100.0 * part);
                return Err(reader.fault("body", words));
            }
        }
        Ok(())
    }
}

/// Whether `x` is inside any of the bodies.
pub(crate) fn inside(bodies: &[Shape], x: DVec3) -> bool {
    bodies.iter().any(|body| body.signed_distance(x).0 < 0.0)
}

/// The part of the box's cross-section that bodies stand in, seen along an axis.
pub(crate) fn blocked(bodies: &[Shape], bounds: &Bounds, axis: usize) -> f64 {
    let [min, max] = [bounds.min, bounds.max].map(DVec3::from_array);
    let seat = |k: u32| (f64::from(k) + 0.5) / f64::from(SAMPLES);
    let at = |along: u32, i: u32, j: u32| {
        let mut part = DVec3::splat(seat(along));
        part[(axis + 1) % 3] = seat(i);
        part[(axis + 2) % 3] = seat(j);
        min + part * (max - min)
    };
    let columns = (0..SAMPLES).flat_map(|i| (0..SAMPLES).map(move |j| (i, j)));
    let stopped = columns.filter(|&(i, j)| (0..SAMPLES).any(|along| inside(bodies, at(along, i, j)))).count();
    stopped as f64 / f64::from(SAMPLES * SAMPLES)
}
