//! Bodies that hair and air stay out of: `[[body]]`.
//!
//! This file and those of its shapes, `round_box.rs` and `solid.rs`, for the CPU, and `shaders/common/body.wgsl` for
//! the GPU, have the code that depends on a body's shape. Other modules ask a [`CheckedShape`] for its signed distance,
//! its bounds or its skin.

use glam::{DMat3, DQuat, DVec3};

use crate::{
    declare::{table, variants},
    faults::At,
    keys::{
        Fallback::Required,
        Fallback::{Derived, Value},
        Kind::{Direction, Length, NonNegative, Table, Tables, Text, Vector},
    },
    limits::{MAX_BLOCKED, MAX_GRID_VALUES},
    motion::{Motion, Pose},
    round_box::RoundBox,
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
        "Shape of the body: with center and radius, with start, end and radius, with center and size, with point and normal, or with file."
    {
        /// All points within `radius` of a point.
        Sphere(Sphere) = "sphere",
        /// All points within `radius` of a line.
        Capsule(Capsule) = "capsule",
        /// All points of a box with sharp edges.
        Cuboid(Cuboid) = "box",
        /// All points behind a plane.
        Plane(Plane) = "plane",
        /// All points that the triangles of a file enclose.
        Mesh(MeshFile as Solid) = "mesh",
    }
}

table! {
    /// All points within `radius` of a point.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Sphere {
        /// Centre of the sphere or of the box.
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

table! {
    /// All points of a box with sharp edges.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Cuboid, checked by Cuboid::check {
        /// Centre of the sphere or of the box.
        center: [f64; 3] = Vector, "m", Required;
        /// Sides of the box along its own axes.
        size: [f64; 3] = Vector, "m", Required;
        /// Rotation vector of the box about its centre, axis times angle.
        rotation: [f64; 3] = Vector, "rad", Value([0.0; 3]);
    }
}

table! {
    /// All points behind a plane.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Plane {
        /// A point of the plane, about which it turns, and about which a square of 2 m of it is drawn.
        point: [f64; 3] = Vector, "m", Required;
        /// Normal of the plane, away from the body.
        normal: [f64; 3] = Direction, "", Required;
    }
}

impl Cuboid {
    fn check(&self, at: &At<'_>) {
        if self.size.iter().any(|side| *side <= 0.0) {
            at.fault("size", format!("is {:?}; expected three lengths in metres greater than 0", self.size));
        }
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

    /// A box with sharp edges about a centre, with these sides along the axes \[m\], named `body`, at rest.
    #[must_use]
    pub fn cuboid(center: [f64; 3], size: [f64; 3]) -> Self {
        Self::of(Shape::Cuboid(Cuboid { center, size, rotation: [0.0; 3] }))
    }

    /// All points behind the plane through a point \[m\], away from its normal, of any length but 0, named `body`, at
    /// rest.
    #[must_use]
    pub fn plane(point: [f64; 3], normal: [f64; 3]) -> Self {
        Self::of(Shape::Plane(Plane { point, normal }))
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
            CheckedShape::Cuboid(cuboid) => Self::Cuboid(cuboid),
            CheckedShape::Plane(plane) => Self::Plane(plane),
            CheckedShape::Mesh(solid) => solid.into(),
        }
    }
}

impl From<Solid> for Shape {
    fn from(solid: Solid) -> Self {
        Self::Mesh(MeshFile { solid: Some(solid), ..MeshFile::new("") })
    }
}

/// What distances of a shape come from.
#[derive(Debug, Clone, Copy)]
pub enum Form<'a> {
    /// A closed form.
    Round(RoundBox),
    /// A grid.
    Mesh(&'a Solid),
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
    pub fn form(&self) -> Form<'_> {
        let at = DVec3::from_array;
        Form::Round(match *self {
            Self::Sphere(Sphere { center, radius }) => RoundBox::sphere(at(center), radius),
            Self::Capsule(Capsule { start, end, radius }) => RoundBox::capsule(at(start), at(end), radius),
            Self::Cuboid(Cuboid { center, size, rotation }) => {
                RoundBox::cuboid(at(center), DQuat::from_scaled_axis(at(rotation)), at(size))
            }
            Self::Plane(Plane { point, normal }) => RoundBox::plane(at(point), at(normal)),
            Self::Mesh(ref solid) => return Form::Mesh(solid),
        })
    }

    /// The solid of a mesh; `None` for other shapes.
    #[must_use]
    pub fn solid(&self) -> Option<&Solid> {
        if let Self::Mesh(solid) = self { Some(solid) } else { None }
    }

    /// The shape with each of its points where `place` has it: `place` must be rigid.
    #[must_use]
    pub fn moved(&self, place: impl Fn(DVec3) -> DVec3) -> Self {
        let at = DVec3::from_array;
        let moved = |x: [f64; 3]| place(at(x)).to_array();
        match *self {
            Self::Sphere(Sphere { center, radius }) => Self::Sphere(Sphere { center: moved(center), radius }),
            Self::Capsule(Capsule { start, end, radius }) => {
                Self::Capsule(Capsule { start: moved(start), end: moved(end), radius })
            }
            Self::Cuboid(Cuboid { center, size, rotation }) => {
                let turn = turned(&place, at(center), DQuat::from_scaled_axis(at(rotation)));
                Self::Cuboid(Cuboid { center: moved(center), size, rotation: turn.to_scaled_axis().to_array() })
            }
            Self::Plane(Plane { point, normal }) => {
                let normal = (place(at(point) + at(normal)) - place(at(point))).normalize().to_array();
                Self::Plane(Plane { point: moved(point), normal })
            }
            Self::Mesh(ref solid) => Self::Mesh(solid.moved(place)),
        }
    }

    /// The point that the body turns about \[m\]: its middle, a plane's point, or the origin of its file.
    #[must_use]
    pub fn center(&self) -> DVec3 {
        match self.form() {
            Form::Round(round) => round.center,
            Form::Mesh(solid) => solid.origin(),
        }
    }

    /// Signed distance of `x` from the surface \[m\], negative inside, and its gradient: the outward normal of the
    /// surface where that is nearest to `x`.
    #[must_use]
    pub fn signed_distance(&self, x: DVec3) -> (f64, DVec3) {
        match self.form() {
            Form::Round(round) => round.signed_distance(x),
            Form::Mesh(solid) => solid.signed_distance(x),
        }
    }

    /// Radius of the largest ball that fits into the body \[m\]: how thin it is. A plane counts as a head, 0.1 m.
    #[must_use]
    pub fn inradius(&self) -> f64 {
        match self.form() {
            Form::Round(round) => round.inradius(),
            Form::Mesh(solid) => solid.inradius(),
        }
    }

    /// Depth up to which a point that is meant to be on the surface may be below it \[m\].
    pub(crate) fn slack(&self) -> f64 {
        ROUNDING * self.inradius() + self.solid().map_or(0.0, |solid| GRID_ERROR * solid.grid().spacing)
    }

    /// Corners of the box about the body \[m\]; a plane, which has no end, has its point twice.
    #[must_use]
    pub fn bounds(&self) -> [DVec3; 2] {
        match self.form() {
            Form::Round(round) => round.bounds(),
            Form::Mesh(solid) => solid.bounds(),
        }
    }

    /// Points of the surface \[m\] and the outward normals there: of a mesh the three corners of each triangle, of a
    /// box the four of each side, of a plane those of a square of 2 m, else a grid of `rows` from pole to pole, an even
    /// number, and `sides` + 1 points around, of which the last is the first.
    #[must_use]
    pub fn skin(&self, rows: u32, sides: u32) -> Vec<(DVec3, DVec3)> {
        match self.form() {
            Form::Round(round) => round.skin(rows, sides).0,
            Form::Mesh(solid) => {
                let corners = (0..solid.triangles().corners.len()).flat_map(|i| solid.corners(i));
                corners.map(|x| (x, solid.signed_distance(x).1)).collect()
            }
        }
    }

    /// The surface as triangles between the points of [`Self::skin`], counter-clockwise as seen from outside; those of
    /// a mesh are as its file has them.
    #[must_use]
    pub fn surface(&self, rows: u32, sides: u32) -> Triangles {
        let (skin, corners) = match self.form() {
            Form::Round(round) => round.skin(rows, sides),
            Form::Mesh(solid) => {
                let triangles = solid.triangles().corners.len() as u32;
                (self.skin(rows, sides), (0..triangles).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect())
            }
        };
        let points = skin.into_iter().map(|(x, _)| x).collect();
        Triangles { points, corners, unit: Some(1.0), ..Triangles::default() }
    }
}

/// The rotation of a thing that stood at `center`, turned by `rotation`, and that `place`, which must be rigid, has
/// moved.
pub(crate) fn turned(place: impl Fn(DVec3) -> DVec3, center: DVec3, rotation: DQuat) -> DQuat {
    let origin = place(center);
    let axes = DVec3::AXES.map(|axis| place(center + rotation * axis) - origin);
    DQuat::from_mat3(&DMat3::from_cols(axes[0], axes[1], axes[2])).normalize()
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
