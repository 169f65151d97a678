//! `hair.roots`: what the strands of a group are rooted on.

use crate::{
    declare::{InvalidValue, Keys, table, words},
    error::SceneError,
    keys::{
        Fallback::{Derived, Value},
        Key,
        Kind::{Choice, Direction, Length, Text, Vector},
    },
    reader::Reader,
    write::Writer,
};

/// Direction in which strands start, where a scene says none.
const DOWN: [f64; 3] = [0.0, -1.0, 0.0];

/// Surface that the strands of a group are rooted on.
#[derive(Debug, Clone, PartialEq)]
pub enum Roots {
    /// A disc, a cap or a line.
    Patch(Patch),
    /// Triangles of a body.
    Mesh(Scalp),
}

/// A shape that roots are drawn on.
#[derive(Debug, Clone, PartialEq)]
pub struct Patch {
    /// Kind of the shape.
    pub shape: RootShape,
    /// Centre of the shape \[m\].
    pub center: [f64; 3],
    /// Radius of the disc or cap; half length of the line \[m\].
    pub radius: f64,
    /// Direction in which strands start, a unit vector; a cap faces it.
    pub direction: [f64; 3],
    /// Normal of the disc or of the line, a unit vector: strands lean where it is not the direction.
    pub normal: [f64; 3],
}

/// Triangles of a body that roots are scattered on; strands start along the normals.
#[derive(Debug, Clone, PartialEq)]
pub struct Scalp {
    /// Name of the body.
    pub body: String,
    /// Name of the group, object or material of the triangles; none for all of the body.
    pub group: Option<String>,
}

/// Kind of a shape that roots are drawn on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RootShape {
    /// A flat disc.
    Disc,
    /// The half sphere of `radius` facing `direction`; strands start along its normals.
    SphereCap,
    /// A line of half length `radius`, horizontal where it can be.
    Line,
}

words! {
    /// `hair.roots.shape`.
    pub(crate) enum RootsName {
        /// [`RootShape::Disc`]
        Disc = "disc",
        /// [`RootShape::SphereCap`]
        SphereCap = "sphere_cap",
        /// [`RootShape::Line`]
        Line = "line",
        /// [`Roots::Mesh`]
        Mesh = "mesh",
    }
}

table! {
    /// The keys that spell [`Roots`].
    pub(crate) struct SpelledRoots {
        /// Shape that roots are drawn on; mesh is the surface of a body, where strands start along its normals.
        shape: RootsName = Choice(RootsName::WORDS), "", Value(RootsName::Disc);
        /// Centre of the shape.
        center: Option<[f64; 3]> = Vector, "m", Derived("needed, but for shape mesh");
        /// Radius of the disc or cap; half length of the line.
        radius: Option<f64> = Length, "m", Derived("needed, but for shape mesh");
        /// Direction in which strands start, a unit vector; a cap faces it.
        direction: Option<[f64; 3]> = Direction, "", Value(Some(DOWN));
        /// Normal of the disc or of the line, a unit vector: strands lean where it is not the direction.
        normal: Option<[f64; 3]> = Direction, "", Derived("direction");
        /// Name of the body with shape mesh that roots are on.
        body: Option<String> = Text, "", Derived("needed with shape mesh");
        /// Name of the group, object or material of the body's file that roots are on.
        group: Option<String> = Text, "", Derived("all triangles of the body");
    }
}

impl Roots {
    fn spelled(&self) -> SpelledRoots {
        match self.clone() {
            Self::Patch(Patch { shape, center, radius, direction, normal }) => SpelledRoots {
                shape: match shape {
                    RootShape::Disc => RootsName::Disc,
                    RootShape::SphereCap => RootsName::SphereCap,
                    RootShape::Line => RootsName::Line,
                },
                center: Some(center),
                radius: Some(radius),
                direction: Some(direction),
                normal: Some(normal),
                body: None,
                group: None,
            },
            Self::Mesh(Scalp { body, group }) => SpelledRoots {
                shape: RootsName::Mesh,
                center: None,
                radius: None,
                direction: None,
                normal: None,
                body: Some(body),
                group,
            },
        }
    }
}

impl Keys for Roots {
    fn list(path: &str, all: &mut Vec<Key>) {
        SpelledRoots::list(path, all);
    }

    fn read(reader: &Reader<'_>) -> Result<Self, SceneError> {
        let SpelledRoots { shape, center, radius, direction, normal, body, group } = SpelledRoots::read(reader)?;
        let (word, other, has): (_, &[&str], _) = match shape {
            RootsName::Mesh => (shape.word(), &["center", "radius", "direction", "normal"], "body"),
            _ => (shape.word(), &["body", "group"], "center and radius"),
        };
        if let Some(key) = other.iter().find(|key| reader.has(key)) {
            return Err(reader.fault(key, format!("expected no {key} with shape \"{word}\", which has {has}")));
        }
        let missing = |name: &str, expected: String| reader.fault(name, format!("is missing: expected {expected}"));
        let shape = match shape {
            RootsName::Mesh => {
                let body = body.ok_or_else(|| missing("body", "the name of a body with shape \"mesh\"".to_owned()))?;
                return Ok(Self::Mesh(Scalp { body, group }));
            }
            RootsName::Disc => RootShape::Disc,
            RootsName::SphereCap => RootShape::SphereCap,
            RootsName::Line => RootShape::Line,
        };
        let center = center.ok_or_else(|| missing("center", Vector.expected_in("m")))?;
        let radius = radius.ok_or_else(|| missing("radius", Length.expected()))?;
        let direction = direction.unwrap_or(DOWN);
        let normal = normal.unwrap_or(direction);
        if shape == RootShape::SphereCap && normal != direction {
            let words = "expected no normal with shape \"sphere_cap\", which faces direction";
            return Err(reader.fault("normal", words));
        }
        Ok(Self::Patch(Patch { shape, center, radius, direction, normal }))
    }

    fn write(&self, writer: &mut Writer) {
        self.spelled().write(writer);
    }

    fn invalid_value(&self) -> Option<InvalidValue> {
        self.spelled().invalid_value()
    }
}
