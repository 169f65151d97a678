//! Bodies that hair and air stay out of: `[[body]]`.
//!
//! This file for the CPU, and `shaders/common/body.wgsl` for the GPU, have the code that depends on a body's shape.
//! Other modules ask a [`CheckedShape`] for its signed distance, its bounds or its skin.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DVec3};

use crate::{
    declare::{table, variants},
    faults::At,
    keys::{
        Fallback::Required,
        Fallback::{Derived, Value},
        Kind::{Length, NonNegative, Table, Tables, Text, Vector},
    },
    limits::{MAX_BLOCKED, MAX_GRID_VALUES},
    motion::{Motion, Pose},
    scene::{Bounds, Scene, SceneValues},
    solid::{MeshFile, Solid},
    triangles::Triangles,
};

/// Samples along each side of the box, to see how much of it is blocked.
const SAMPLES: u32 = 24;
/// Coulomb's coefficient of friction of hair on a body, where a scene says none.
const FRICTION: f64 = 0.3;
/// Depth below a surface that is rounding \[radii of the largest ball that fits inside\].
const ROUNDING: f64 = 1e-3;
/// Depth below the surface of a mesh that its grid may make of a point on it, next to an edge \[spacings\].
const GRID_ERROR: f64 = 0.25;

table! {
    /// One `[[body]]`.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Body => CheckedBody, checked by Body::check {
        /// Name of the body, for dotted keys and errors.
        name: String = Text, "", Value("body".to_owned());
        /// Shape of the body where it is written, before it moves.
        shape as "": Shape as CheckedShape = Table, "", Derived("");
        /// Coulomb's coefficient of friction of hair on the body.
        friction: f64 = NonNegative, "", Value(FRICTION);
        /// Keyframes of the body, about its centre, or about the origin of its mesh file.
        motion: Motion = Tables, "", Derived("it rests");
    }
}

variants! {
    /// Shape of a body \[m\]: a solid that is given by points, so that it moves when they do.
    #[derive(Debug, Clone, PartialEq)]
    pub enum Shape => CheckedShape by "shape" = Value("sphere"),
        "Shape of the body: with center and radius, with start, end and radius, or with file."
    {
        /// All points within `radius` of a point.
        Sphere(Sphere) = "sphere",
        /// All points within `radius` of a line.
        Capsule(Capsule) = "capsule",
        /// All points that the triangles of a file enclose.
        Mesh(MeshFile as Solid) = "mesh",
    }
}

table! {
    /// All points within `radius` of a point.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Sphere {
        /// Centre of the sphere.
        center: [f64; 3] = Vector, "m", Required;
        /// Radius of the sphere, or about the capsule's axis.
        radius: f64 = Length, "m", Required;
    }
}

table! {
    /// All points within `radius` of a line.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Capsule, checked by Capsule::check {
        /// Start of the capsule's axis.
        start: [f64; 3] = Vector, "m", Required;
        /// End of the capsule's axis.
        end: [f64; 3] = Vector, "m", Required;
        /// Radius of the sphere, or about the capsule's axis.
        radius: f64 = Length, "m", Required;
    }
}

impl Capsule {
    fn check(&self, at: &At<'_>) {
        if DVec3::from_array(self.start).distance(DVec3::from_array(self.end)) < 1e-6 * self.radius {
            at.fault("end", "is the same point as start; expected another, or shape \"sphere\"");
        }
    }
}

impl Body {
    /// A ball named `body` \[m\], at rest.
    #[must_use]
    pub fn sphere(center: [f64; 3], radius: f64) -> Self {
        Self::of(Shape::sphere(center, radius))
    }

    /// All points within `radius` of the line from `start` to `end` \[m\], named `body`, at rest.
    #[must_use]
    pub fn capsule(start: [f64; 3], end: [f64; 3], radius: f64) -> Self {
        Self::of(Shape::capsule(start, end, radius))
    }

    /// The solid of a mesh file, named `body`, at rest; relative paths start from the current directory.
    #[must_use]
    pub fn mesh(file: impl Into<String>) -> Self {
        Self::of(Shape::Mesh(MeshFile::new(file)))
    }

    /// The solid that triangles of the caller's own enclose, named `body`, at rest.
    #[must_use]
    pub fn solid(solid: Solid) -> Self {
        Self::of(solid.into())
    }

    /// A mesh that deforms goes by its own poses.
    fn check(&self, checked: &mut CheckedBody, _: &Scene, at: &At<'_>) {
        let Some(frames) = checked.shape.solid().and_then(Solid::frames) else { return };
        if !self.motion.keyframes.is_empty() {
            at.fault("motion", "expected none beside frames, which say where the mesh is");
        }
        checked.motion = frames.motion().clone();
    }

    /// The body with this name.
    #[must_use]
    pub fn named(self, name: impl Into<String>) -> Self {
        Self { name: name.into(), ..self }
    }

    fn of(shape: Shape) -> Self {
        Self { name: "body".to_owned(), shape, friction: FRICTION, motion: Motion::default() }
    }
}

impl Shape {
    /// All points within `radius` of `center` \[m\].
    #[must_use]
    pub const fn sphere(center: [f64; 3], radius: f64) -> Self {
        Self::Sphere(Sphere { center, radius })
    }

    /// All points within `radius` of the line from `start` to `end` \[m\].
    #[must_use]
    pub const fn capsule(start: [f64; 3], end: [f64; 3], radius: f64) -> Self {
        Self::Capsule(Capsule { start, end, radius })
    }
}

impl From<CheckedShape> for Shape {
    fn from(shape: CheckedShape) -> Self {
        match shape {
            CheckedShape::Sphere(sphere) => Self::Sphere(sphere),
            CheckedShape::Capsule(capsule) => Self::Capsule(capsule),
            CheckedShape::Mesh(solid) => solid.into(),
        }
    }
}

impl From<Solid> for Shape {
    fn from(solid: Solid) -> Self {
        Self::Mesh(MeshFile { solid: Some(solid), ..MeshFile::new("") })
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

impl CheckedShape {
    /// All points within `radius` of `center` \[m\].
    #[must_use]
    pub const fn sphere(center: [f64; 3], radius: f64) -> Self {
        Self::Sphere(Sphere { center, radius })
    }

    /// All points within `radius` of the line from `start` to `end` \[m\].
    #[must_use]
    pub const fn capsule(start: [f64; 3], end: [f64; 3], radius: f64) -> Self {
        Self::Capsule(Capsule { start, end, radius })
    }

    /// The shape as `shaders/common/body.wgsl` knows it.
    #[must_use]
    pub fn round(&self) -> Round {
        match *self {
            Self::Sphere(Sphere { center, radius }) => Round { ends: [DVec3::from_array(center); 2], radius },
            Self::Capsule(Capsule { start, end, radius }) => {
                Round { ends: [start, end].map(DVec3::from_array), radius }
            }
            Self::Mesh(ref solid) => Round { ends: [solid.origin(); 2], radius: 0.0 },
        }
    }

    /// The solid of a mesh; `None` for other shapes.
    #[must_use]
    pub fn solid(&self) -> Option<&Solid> {
        match self {
            Self::Mesh(solid) => Some(solid),
            Self::Sphere(_) | Self::Capsule(_) => None,
        }
    }

    /// The shape with each of its points where `place` has it: `place` must be rigid.
    #[must_use]
    pub fn moved(&self, place: impl Fn(DVec3) -> DVec3) -> Self {
        let moved = |x: [f64; 3]| place(DVec3::from_array(x)).to_array();
        match *self {
            Self::Sphere(Sphere { center, radius }) => Self::Sphere(Sphere { center: moved(center), radius }),
            Self::Capsule(Capsule { start, end, radius }) => {
                Self::Capsule(Capsule { start: moved(start), end: moved(end), radius })
            }
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
}

impl CheckedBody {
    /// The body's shape where it is at `time` \[s\].
    #[must_use]
    pub fn at(&self, time: f64) -> CheckedShape {
        self.placed(&self.motion.at(time), time)
    }

    /// The body's shape in this pose at `time` \[s\], by which a mesh deforms.
    #[must_use]
    pub fn placed(&self, pose: &Pose, time: f64) -> CheckedShape {
        let center = self.shape.center();
        let place = |x| pose.place(center, x);
        match &self.shape {
            CheckedShape::Mesh(solid) => CheckedShape::Mesh(solid.at(time).moved(place)),
            round => round.moved(place),
        }
    }
}

impl SceneValues {
    /// The solids of the meshes that keep their shape, one for each grid of distances that is in memory: bodies of one
    /// file share it.
    #[must_use]
    pub fn solids(&self) -> Vec<&Solid> {
        let mut all: Vec<&Solid> = Vec::new();
        for solid in self.bodies.iter().filter_map(|body| body.shape.solid()).filter(|solid| solid.frames().is_none()) {
            if !all.iter().any(|other| other.shares_grid(solid)) {
                all.push(solid);
            }
        }
        all
    }

    /// Values that the grids of all meshes have: a mesh that deforms has those of two poses.
    #[must_use]
    pub fn grid_values(&self) -> usize {
        let rigid: usize = self.solids().iter().map(|solid| solid.grid().values.len()).sum();
        rigid
            + self
                .bodies
                .iter()
                .filter_map(|body| body.shape.solid()?.frames())
                .map(|frames| frames.values())
                .sum::<usize>()
    }

    /// The grids of all meshes must fit into one buffer, poses must be a step apart, and the wind must get past the
    /// bodies.
    pub(crate) fn check_bodies(&self, at: &At<'_>) {
        let step = self.time.step / f64::from(self.time.substeps);
        for (i, body) in self.bodies.iter().enumerate() {
            let Some(frames) = body.shape.solid().and_then(Solid::frames) else { continue };
            let times = frames.motion().keyframes.windows(2).map(|pair| pair[1].time - pair[0].time);
            if let Some((k, apart)) = times.enumerate().find(|(_, apart)| *apart < (1.0 - ROUNDING) * step) {
                let words =
                    format!("pose {} is {apart} s after the one before: expected at least a step, {step} s", k + 1);
                at.fault(&format!("body.{i}.frames"), words);
            }
        }
        let nodes = self.grid_values();
        if nodes > MAX_GRID_VALUES {
            let most = |body: &CheckedBody| {
                let own = |solid: &Solid| solid.frames().map_or(solid.grid().values.len(), |frames| frames.values());
                body.shape.solid().map_or(0, own)
            };
            let largest = (0..self.bodies.len()).max_by_key(|&i| most(&self.bodies[i])).unwrap_or_default();
            let words = format!(
                "the grids of all meshes have {nodes} nodes together; expected at most {MAX_GRID_VALUES}, with a larger resolution"
            );
            at.fault(&format!("body.{largest}.resolution"), words);
        }
        let Some((air, bounds)) = self.filled() else { return };
        let bodies: Vec<CheckedShape> = self.bodies.iter().map(|body| body.at(0.0)).collect();
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate().filter(|&(axis, _)| air.wind[axis] != 0.0) {
            let part = blocked(&bodies, &bounds, axis);
            if part > MAX_BLOCKED {
                let words =
                    format!("bodies block {:.0} % of air.box across {name}; expected room for the wind", 100.0 * part);
                at.fault("body", words);
            }
        }
    }
}

/// Whether `x` is inside any of the bodies.
pub(crate) fn inside(bodies: &[CheckedShape], x: DVec3) -> bool {
    bodies.iter().any(|body| body.signed_distance(x).0 < 0.0)
}

/// The part of the box's cross-section that bodies stand in, seen along an axis.
pub(crate) fn blocked(bodies: &[CheckedShape], bounds: &Bounds, axis: usize) -> f64 {
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
