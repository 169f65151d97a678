//! `hair.roots`: the surface that the roots of a group of strands lie on.

use crate::{
    declare::{table, variants},
    keys::{
        Fallback::{Derived, Required, Value},
        Kind::{Direction, Length, Text, Vector},
    },
};

/// Direction in which strands start, where a scene says none.
const DOWN: [f64; 3] = [0.0, -1.0, 0.0];

variants! {
    /// Surface that the strands of a group are rooted on.
    #[derive(Debug, Clone, PartialEq)]
    pub enum Roots by "shape" = Value("disc"),
        "Shape that roots are drawn on; mesh is the surface of a body, where strands start along its normals."
    {
        /// A flat disc.
        Disc(Patch) = "disc",
        /// The half sphere that faces a direction; strands start along its normals.
        Cap(Cap) = "sphere_cap",
        /// A line of half length `radius`, horizontal where it can be.
        Line(Patch) = "line",
        /// Triangles of a body.
        Mesh(Scalp) = "mesh",
    }
}

table! {
    /// A disc or a line that roots are drawn on.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Patch {
        /// Centre of the shape.
        center: [f64; 3] = Vector, "m", Required;
        /// Radius of the disc or cap; half length of the line.
        radius: f64 = Length, "m", Required;
        /// Direction in which strands start, a unit vector; a cap faces it.
        direction: [f64; 3] = Direction, "", Value(DOWN);
        /// Normal of the disc or of the line, a unit vector: strands lean where it is not the direction.
        normal: Option<[f64; 3]> = Direction, "", Derived("direction");
    }
}

table! {
    /// A half sphere that roots are drawn on.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Cap {
        /// Centre of the shape.
        center: [f64; 3] = Vector, "m", Required;
        /// Radius of the disc or cap; half length of the line.
        radius: f64 = Length, "m", Required;
        /// Direction in which strands start, a unit vector; a cap faces it.
        direction: [f64; 3] = Direction, "", Value(DOWN);
    }
}

table! {
    /// Triangles of a body that roots are scattered on; strands start along the normals.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Scalp {
        /// Name of the body with shape mesh that roots are on.
        body: String = Text, "", Required;
        /// Name of the group, object or material of the body's file that roots are on.
        group: Option<String> = Text, "", Derived("all triangles of the body");
    }
}

/// Kind of a shape that roots are drawn on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RootShape {
    /// A flat disc.
    Disc,
    /// A half sphere.
    Cap,
    /// A line.
    Line,
}

/// A shape that roots are drawn on, by numbers that all such shapes have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RootPatch {
    /// Kind of the shape.
    pub shape: RootShape,
    /// Centre of the shape \[m\].
    pub center: [f64; 3],
    /// Radius of the disc or cap; half length of the line \[m\].
    pub radius: f64,
    /// Direction in which strands start, a unit vector; a cap faces it.
    pub direction: [f64; 3],
    /// Normal of the disc or of the line, a unit vector; of a cap its direction.
    pub normal: [f64; 3],
}

impl Roots {
    /// The shape that roots are drawn on; `None` for triangles of a body.
    #[must_use]
    pub fn patch(&self) -> Option<RootPatch> {
        let (shape, Patch { center, radius, direction, normal }) = match *self {
            Self::Disc(patch) => (RootShape::Disc, patch),
            Self::Line(patch) => (RootShape::Line, patch),
            Self::Cap(Cap { center, radius, direction }) => {
                (RootShape::Cap, Patch { center, radius, direction, normal: None })
            }
            Self::Mesh(_) => return None,
        };
        Some(RootPatch { shape, center, radius, direction, normal: normal.unwrap_or(direction) })
    }

    /// A disc \[m\], from which strands hang down.
    #[must_use]
    pub fn disc(center: [f64; 3], radius: f64) -> Self {
        Self::Disc(Patch { center, radius, direction: DOWN, normal: None })
    }

    /// A line of half length `radius` \[m\], from which strands hang down.
    #[must_use]
    pub fn line(center: [f64; 3], radius: f64) -> Self {
        Self::Line(Patch { center, radius, direction: DOWN, normal: None })
    }

    /// A half sphere \[m\] that faces down.
    #[must_use]
    pub fn cap(center: [f64; 3], radius: f64) -> Self {
        Self::Cap(Cap { center, radius, direction: DOWN })
    }

    /// The whole surface of the body of this name, whose shape is a mesh.
    #[must_use]
    pub fn on(body: impl Into<String>) -> Self {
        Self::Mesh(Scalp { body: body.into(), group: None })
    }

    /// The shape with strands that start in this direction, of any length but 0. On a mesh they start along its
    /// normals.
    #[must_use]
    pub fn toward(mut self, direction: [f64; 3]) -> Self {
        match &mut self {
            Self::Disc(patch) | Self::Line(patch) => patch.direction = direction,
            Self::Cap(cap) => cap.direction = direction,
            Self::Mesh(_) => {}
        }
        self
    }
}
