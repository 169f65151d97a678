//! Bodies that hair and air stay out of: `[[body]]`.
//!
//! Everything about a body that depends on its shape stands here, for the CPU, and in `shaders/common/body.wgsl`, for the GPU.
//! Everybody else asks a [`Shape`] for its signed distance, its bounds or its skin.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DVec3};

use crate::{
    declare::{Keys, Misfit, table, words},
    error::SceneError,
    keys::{
        Fallback::{Absent, Needed, Value},
        Key,
        Kind::{Choice, Length, NonNegative, Table, Tables, Text, Vector},
    },
    limits::MOST_BLOCKED,
    motion::Motion,
    reader::Reader,
    scene::{Bounds, Scene},
    write::Writer,
};

/// Samples along each side of the box, to see how much of it is blocked.
const SAMPLES: u32 = 24;

table! {
    /// One `[[body]]`.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Body {
        /// Name of the body, for dotted keys and errors.
        name: String = Text, "", Value("body".to_owned());
        /// Shape of the body where it is written, before it moves.
        shape as "": Shape = Table, "", Absent("");
        /// Coulomb's coefficient of friction of hair on the body.
        friction: f64 = NonNegative, "", Value(0.3);
        /// Keyframes of the body, about its centre.
        motion: Motion = Tables, "", Absent("it rests");
    }
}

/// Shape of a body \[m\]: a solid that is given by points, so that it moves when they do.
#[derive(Debug, Clone, Copy, PartialEq)]
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
}

words! {
    /// `body.shape`.
    pub(crate) enum ShapeName {
        /// [`Shape::Sphere`]
        Sphere = "sphere",
        /// [`Shape::Capsule`]
        Capsule = "capsule",
    }
}

table! {
    /// The keys that spell a [`Shape`].
    pub(crate) struct SpelledShape {
        /// Shape of the body: with center, or with start and end.
        shape: ShapeName = Choice(ShapeName::WORDS), "", Value(ShapeName::Sphere);
        /// Centre of the sphere.
        center: Option<[f64; 3]> = Vector, "m", Absent("needed with shape sphere");
        /// Start of the capsule's axis.
        start: Option<[f64; 3]> = Vector, "m", Absent("needed with shape capsule");
        /// End of the capsule's axis.
        end: Option<[f64; 3]> = Vector, "m", Absent("needed with shape capsule");
        /// Radius of the sphere, or about the capsule's axis.
        radius: f64 = Length, "m", Needed;
    }
}

/// The spheres about both ends and all between them, for the GPU; a sphere has its ends in one point.
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
        }
    }

    /// The shape with each of its points where `place` has it: `place` must be rigid.
    #[must_use]
    pub fn moved(&self, place: impl Fn(DVec3) -> DVec3) -> Self {
        let moved = |x: [f64; 3]| place(DVec3::from_array(x)).to_array();
        match *self {
            Self::Sphere { center, radius } => Self::Sphere { center: moved(center), radius },
            Self::Capsule { start, end, radius } => Self::Capsule { start: moved(start), end: moved(end), radius },
        }
    }

    /// The point that the body turns about \[m\].
    #[must_use]
    pub fn center(&self) -> DVec3 {
        let [start, end] = self.round().ends;
        0.5 * (start + end)
    }

    /// Signed distance of `x` from the surface \[m\], negative inside, and its gradient: the outward normal of the surface
    /// where that is nearest to `x`.
    #[must_use]
    pub fn signed_distance(&self, x: DVec3) -> (f64, DVec3) {
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
        self.round().radius
    }

    /// Corners of the box about the body \[m\].
    #[must_use]
    pub fn bounds(&self) -> [DVec3; 2] {
        let Round { ends: [start, end], radius } = self.round();
        [start.min(end) - radius, start.max(end) + radius]
    }

    /// Points of the surface \[m\] and the outward normals there: a grid of `rows` from pole to pole, an even number, and
    /// `sides` + 1 points around, of which the last is the first.
    pub fn skin(&self, rows: u32, sides: u32) -> impl Iterator<Item = (DVec3, DVec3)> + use<> {
        let Round { ends, radius } = self.round();
        let axis = (ends[1] - ends[0]).normalize_or(DVec3::Y);
        let across = axis.any_orthonormal_vector();
        let basis = DMat3::from_cols(across, axis.cross(across), axis);
        (0..rows).flat_map(move |i| {
            (0..=sides).map(move |k| {
                // Two half spheres; the side is between their equators.
                let far = i >= rows / 2;
                let latitude = PI * (f64::from(i - u32::from(far)) / f64::from(rows - 2) - 0.5);
                let around = TAU * f64::from(k) / f64::from(sides);
                let normal = DVec3::new(latitude.cos() * around.cos(), latitude.cos() * around.sin(), latitude.sin());
                let normal = basis * normal;
                (ends[usize::from(far)] + radius * normal, normal)
            })
        })
    }

    fn spelled(&self) -> SpelledShape {
        match *self {
            Self::Sphere { center, radius } => {
                SpelledShape { shape: ShapeName::Sphere, center: Some(center), start: None, end: None, radius }
            }
            Self::Capsule { start, end, radius } => {
                SpelledShape { shape: ShapeName::Capsule, center: None, start: Some(start), end: Some(end), radius }
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
        let SpelledShape { shape, center, start, end, radius } = SpelledShape::read(reader)?;
        let (word, own): (_, &[&str]) = match shape {
            ShapeName::Sphere => (shape.word(), &["center"]),
            ShapeName::Capsule => (shape.word(), &["start", "end"]),
        };
        let has = own.join(" and ");
        if let Some(other) = ["center", "start", "end"].iter().find(|key| reader.has(key) && !own.contains(key)) {
            return Err(reader.fault(other, format!("expected no {other} with shape \"{word}\", which has {has}")));
        }
        let point = |name: &str, point: Option<[f64; 3]>| {
            point.ok_or_else(|| reader.fault(name, format!("is missing: shape \"{word}\" has {has}")))
        };
        match shape {
            ShapeName::Sphere => Ok(Self::Sphere { center: point("center", center)?, radius }),
            ShapeName::Capsule => {
                let (start, end) = (point("start", start)?, point("end", end)?);
                if DVec3::from_array(start).distance(DVec3::from_array(end)) < 1e-6 * radius {
                    let words = "is the same point as start; expected another, or shape \"sphere\"";
                    return Err(reader.fault("end", words));
                }
                Ok(Self::Capsule { start, end, radius })
            }
        }
    }

    fn write(&self, writer: &mut Writer) {
        self.spelled().write(writer);
    }

    fn misfit(&self) -> Option<Misfit> {
        self.spelled().misfit()
    }
}

impl Scene {
    /// The wind must get past the bodies.
    pub(crate) fn check_bodies(&self, reader: &Reader<'_>) -> Result<(), SceneError> {
        let Some((air, bounds)) = self.filled() else { return Ok(()) };
        let bodies: Vec<Shape> = self.bodies.iter().map(|body| body.at(0.0)).collect();
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate().filter(|&(axis, _)| air.wind[axis] != 0.0) {
            let part = blocked(&bodies, &bounds, axis);
            if part > MOST_BLOCKED {
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
