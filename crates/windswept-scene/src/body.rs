//! Bodies that hair and air stay out of: `[[body]]`.

use glam::DVec3;

use crate::{
    error::SceneError,
    motion::Motion,
    reader::Reader,
    scene::{Bounds, Scene},
};

/// Every hair point and every air particle looks at every body, twice.
const MOST_BODIES: usize = 1024;
/// Part of the box's cross-section that bodies may block: what is left lets air through.
const MOST_BLOCKED: f64 = 0.9;
/// Along each side of the box, to see how much of it is blocked.
const SAMPLES: u32 = 24;

/// One `[[body]]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Name, for dotted keys and errors.
    pub name: String,
    /// What it is before it moves.
    pub shape: Shape,
    /// Coulomb's coefficient of hair on it.
    pub friction: f64,
    /// How it moves, about its centre: of the sphere, or the middle of the capsule's axis.
    pub motion: Motion,
}

/// `body.shape`, with its own keys \[m\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// All points within `radius` of a point.
    Sphere {
        /// That point.
        center: [f64; 3],
        /// Its radius.
        radius: f64,
    },
    /// All points within `radius` of a line.
    Capsule {
        /// Where the line starts.
        start: [f64; 3],
        /// Where it ends.
        end: [f64; 3],
        /// Its radius.
        radius: f64,
    },
}

/// A body as it stands at some time: a sphere is a capsule without length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Capsule {
    /// Ends of the axis \[m\].
    pub ends: [DVec3; 2],
    /// \[m\]
    pub radius: f64,
}

impl Shape {
    /// As a scene file spells it.
    #[must_use]
    pub fn word(&self) -> &'static str {
        match self {
            Self::Sphere { .. } => "sphere",
            Self::Capsule { .. } => "capsule",
        }
    }

    /// As it is written, unmoved.
    #[must_use]
    pub fn capsule(&self) -> Capsule {
        match *self {
            Self::Sphere { center, radius } => Capsule { ends: [DVec3::from_array(center); 2], radius },
            Self::Capsule { start, end, radius } => Capsule { ends: [start, end].map(DVec3::from_array), radius },
        }
    }
}

impl Body {
    /// Where it is at `time` \[s\].
    #[must_use]
    pub fn at(&self, time: f64) -> Capsule {
        let Capsule { ends, radius } = self.shape.capsule();
        let center = 0.5 * (ends[0] + ends[1]);
        Capsule { ends: ends.map(|end| self.motion.place(center, end, time)), radius }
    }
}

impl Capsule {
    /// Distance of `x` from its surface \[m\]; negative inside.
    #[must_use]
    pub fn distance(&self, x: DVec3) -> f64 {
        let [start, end] = self.ends;
        let axis = end - start;
        let length = axis.length();
        let along = if length > 0.0 { (x - start).dot(axis / length).clamp(0.0, length) / length } else { 0.0 };
        x.distance(start + along * axis) - self.radius
    }

    /// Corners of the box about it \[m\].
    #[must_use]
    pub fn bounds(&self) -> [DVec3; 2] {
        let [start, end] = self.ends;
        [start.min(end) - self.radius, start.max(end) + self.radius]
    }
}

impl Reader<'_> {
    pub(crate) fn bodies(&self) -> Result<Vec<Body>, SceneError> {
        let mut all: Vec<Body> = Vec::new();
        for i in 0..self.tables("body") {
            let body = self.body(&format!("body.{i}"))?;
            if let Some(other) = all.iter().find(|other| other.name == body.name) {
                return Err(self.fault(
                    &format!("body.{i}.name"),
                    format!("expected a name of its own for each [[body]], found \"{}\" a second time", other.name),
                ));
            }
            all.push(body);
        }
        if all.len() > MOST_BODIES {
            return Err(self.fault("body", format!("expected at most {MOST_BODIES} bodies, found {}", all.len())));
        }
        Ok(all)
    }

    fn body(&self, table: &str) -> Result<Body, SceneError> {
        let at = |name: &str| format!("{table}.{name}");
        Ok(Body {
            name: self.text(&at("name"))?,
            shape: self.shape(table)?,
            friction: self.number(&at("friction"))?,
            motion: self.motion(&at("motion"))?,
        })
    }

    fn shape(&self, table: &str) -> Result<Shape, SceneError> {
        let at = |name: &str| format!("{table}.{name}");
        let word = self.text(&at("shape"))?;
        let sphere = word == "sphere";
        let (own, others): (&[&str], &[&str]) =
            if sphere { (&["center"], &["start", "end"]) } else { (&["start", "end"], &["center"]) };
        if let Some(other) = others.iter().find(|name| self.has(&at(name))) {
            let words = format!("expected no {other} with shape \"{word}\", which has {}", own.join(" and "));
            return Err(self.fault(&at(other), words));
        }
        let point = |name: &str| match self.has(&at(name)) {
            true => self.vector(&at(name)),
            false => Err(self.fault(&at(name), format!("is missing: shape \"{word}\" has {}", own.join(" and ")))),
        };
        let radius = self.number(&at("radius"))?;
        if sphere {
            return Ok(Shape::Sphere { center: point("center")?, radius });
        }
        let (start, end) = (point("start")?, point("end")?);
        if DVec3::from_array(start).distance(DVec3::from_array(end)) < 1e-6 * radius {
            return Err(self.fault(&at("end"), "is the same point as start; expected another, or shape \"sphere\""));
        }
        Ok(Shape::Capsule { start, end, radius })
    }

    /// The wind must get past the bodies.
    pub(crate) fn check_bodies(&self, scene: &Scene) -> Result<(), SceneError> {
        let Some((air, bounds)) = scene.filled() else { return Ok(()) };
        let bodies: Vec<Capsule> = scene.bodies.iter().map(|body| body.at(0.0)).collect();
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate().filter(|&(axis, _)| air.wind[axis] != 0.0) {
            let part = blocked(&bodies, &bounds, axis);
            if part > MOST_BLOCKED {
                let words =
                    format!("bodies block {:.0} % of air.box across {name}; expected room for the wind", 100.0 * part);
                return Err(self.fault("body", words));
            }
        }
        Ok(())
    }
}

/// The part of the box's cross-section that bodies stand in, seen along an axis.
pub(crate) fn blocked(bodies: &[Capsule], bounds: &Bounds, axis: usize) -> f64 {
    let [min, max] = [bounds.min, bounds.max].map(DVec3::from_array);
    let seat = |k: u32| (f64::from(k) + 0.5) / f64::from(SAMPLES);
    let at = |along: u32, i: u32, j: u32| {
        let mut part = DVec3::splat(seat(along));
        part[(axis + 1) % 3] = seat(i);
        part[(axis + 2) % 3] = seat(j);
        min + part * (max - min)
    };
    let inside = |x: DVec3| bodies.iter().any(|body| body.distance(x) < 0.0);
    let columns = (0..SAMPLES).flat_map(|i| (0..SAMPLES).map(move |j| (i, j)));
    let stopped = columns.filter(|&(i, j)| (0..SAMPLES).any(|along| inside(at(along, i, j)))).count();
    stopped as f64 / f64::from(SAMPLES * SAMPLES)
}
