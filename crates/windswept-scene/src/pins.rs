//! Points of strands that are held at a body or tied together: `[[hair.pin]]`.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

use crate::{
    body::CheckedBody,
    declare::table,
    error::SceneError,
    faults::At,
    keys::{
        Fallback::{Derived, Required},
        Kind::{Direction, Fraction, Length, Positive, Table, Text, Vector},
    },
    motion::Pose,
    scene::{Hair, SceneValues, Solver, rounded, unknown},
    strands::Strands,
    warnings::Warning,
};

/// Length of a strand from its root to its ring, over that of the shortest way around the body.
const SLACK: f64 = 1.1;
/// Spans of the way around a body, and rounds in which it is pulled tight.
const SPANS: usize = 16;
const ROUNDS: usize = 60;

table! {
    /// One of `[[hair.pin]]`: a place that each strand of the group is held at.
    #[derive(Debug, Clone, PartialEq, Default)]
    pub struct Pin, checked by Pin::check {
        /// Length of the strand from its root to the pin; the nearest point of the strand is held.
        at: Option<f64> = Positive, "m", Derived("that to the ring around the body");
        /// Part of the strand's length from its root to the pin, in place of at.
        fraction: Option<f64> = Fraction, "", Derived("at says it");
        /// Name of the body that the pin goes with.
        body: Option<String> = Text, "", Derived("that of the hair, else none: it rests");
        /// Hair tie that gathers the strands while hair settles (`time.settle`).
        ring: Option<Ring> = Table, "", Derived("strands are held where they start");
    }
}

table! {
    /// `hair.pin.ring`: a disc that strands go through, evenly spread.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Ring {
        /// Centre of the ring, where the body is written.
        center: [f64; 3] = Vector, "m", Required;
        /// Radius of the bundle of strands.
        radius: f64 = Length, "m", Required;
        /// Normal of the ring, a unit vector.
        normal: Option<[f64; 3]> = Direction, "", Derived("away from the mean of the roots");
    }
}

impl Pin {
    fn check(&self, at: &At<'_>) {
        match (self.at, self.fraction, &self.ring) {
            (Some(_), Some(_), _) => at.fault("fraction", "expected none beside at: they say the same"),
            (None, None, None) => at.fault("at", "is missing: expected a length, or fraction, or ring"),
            _ => {}
        }
    }
}

/// A point of hair that the scene holds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Pinned {
    /// Index of the point.
    pub point: u32,
    /// Index of the body that it goes with; `None` where it rests.
    pub body: Option<u32>,
    /// Place of the pin where the body is written \[m\].
    pub place: DVec3,
}

impl Pinned {
    /// Place of the pin when the run starts \[m\].
    #[must_use]
    pub fn at_start(&self, scene: &SceneValues) -> DVec3 {
        let body = self.body.and_then(|body| scene.bodies.get(body as usize));
        body.map_or(self.place, |body| body.motion.place(body.shape.center(), self.place, 0.0))
    }
}

/// Points that the pins of all groups hold, with strands where the scene's motions have them at the start.
pub(crate) fn pinned(
    scene: &SceneValues,
    hair: &Strands,
    warnings: &mut Vec<Warning>,
) -> Result<Vec<Pinned>, SceneError> {
    let mut all = Vec::new();
    for (group, own) in scene.hair.iter().enumerate() {
        for (index, pin) in own.pins.iter().enumerate() {
            let strands: Vec<usize> = (0..hair.len()).filter(|&s| hair.group[s] as usize == group).collect();
            let holder = Holder::new(scene, own, pin, hair, &strands);
            let mut warn =
                |text: String| warnings.push(Warning::new("pin", &format!("{}.pin", scene.called(group)), text));
            if let (Some(ring), Some((_, body, _))) = (&pin.ring, &holder.body) {
                let depth = -body.shape.signed_distance(DVec3::from_array(ring.center)).0;
                if depth > 0.0 {
                    warn(format!("the ring's centre is {} m inside body \"{}\"", rounded(depth), body.name));
                }
            }
            let (mut short, mut lacks) = (0, 0.0_f64);
            let (mut longest, mut least) = (0.0_f64, f64::INFINITY);
            for (k, &s) in strands.iter().enumerate() {
                match holder.hold(hair, s, k) {
                    Ok(held) => all.extend(held),
                    Err(Short { at, length }) => {
                        (short, lacks) = (short + 1, lacks.max(at - length));
                        (longest, least) = (longest.max(length), least.min(at));
                    }
                }
            }
            let of = strands.len();
            if short > 0 && short == of {
                let (longest, least) = (rounded(longest), rounded(least));
                let text = format!(
                    "no strand is long enough: the longest has {longest} m, and the way to the pin is {least} m at least; \
                     lengths and places are in metres"
                );
                return Err(SceneError::new(text).at(format!("{}.pin.{index}", scene.called(group)), None));
            }
            if short > 0 {
                warn(format!("{short} of {of} strands are too short to be held: they lack up to {} m", rounded(lacks)));
            }
        }
    }
    // Of two pins of a point the last counts.
    all.sort_by_key(|pinned| pinned.point);
    all.dedup_by(|later, first| {
        let same = later.point == first.point;
        if same {
            *first = *later;
        }
        same
    });
    Ok(all)
}

/// A strand that ends before the place of its pin.
struct Short {
    /// Way from the root to the pin \[m\].
    at: f64,
    /// Length of the strand \[m\].
    length: f64,
}

/// A pin of a group of strands, with what it holds them at.
struct Holder<'a> {
    pin: &'a Pin,
    /// The body that it goes with, its index and its pose when the run starts.
    body: Option<(u32, &'a CheckedBody, Pose)>,
    /// Seats of the strands in the ring \[m\]; empty without a ring.
    seats: Vec<DVec3>,
}

impl<'a> Holder<'a> {
    fn new(scene: &'a SceneValues, own: &Hair, pin: &'a Pin, hair: &Strands, strands: &[usize]) -> Self {
        let name = pin.body.as_deref().or(own.body());
        let index = scene.bodies.iter().position(|body| Some(body.name.as_str()) == name);
        let body = index.map(|i| (i as u32, &scene.bodies[i], scene.bodies[i].motion.at(0.0)));
        let mut holder = Self { pin, body, seats: Vec::new() };
        if let Some(ring) = &pin.ring {
            let roots: Vec<DVec3> =
                strands.iter().map(|&s| holder.written(hair.positions[hair.points(s).start])).collect();
            holder.seats = ring.seats(&roots);
        }
        holder
    }

    /// The place that a point at `x` in the world has where the body is written \[m\].
    fn written(&self, x: DVec3) -> DVec3 {
        self.body.as_ref().map_or(x, |(_, body, pose)| pose.written(body.shape.center(), x))
    }

    /// The point of strand `s`, the `k`th of the group, if it is not held in any case.
    fn hold(&self, hair: &Strands, s: usize, k: usize) -> Result<Option<Pinned>, Short> {
        let lengths = &hair.rest_length[hair.segments(s)];
        let root = hair.points(s).start;
        let whole: f64 = lengths.iter().sum();
        let seat = self.seats.get(k).copied();
        let way = || SLACK * self.way(self.written(hair.positions[root]), seat.unwrap_or_default());
        let at = self.pin.fraction.map(|part| part * whole).or(self.pin.at).unwrap_or_else(way);
        let mut along = 0.0;
        let ends = lengths.iter().map(|length| {
            along += length;
            along
        });
        let ends: Vec<f64> = ends.collect();
        let Some(next) = ends.iter().position(|end| *end >= at * (1.0 - 1e-9)) else {
            return Err(Short { at, length: whole });
        };
        // A tie needs all of the way; another pin is at the point that is nearest, but at no root.
        let before = if next > 0 && seat.is_none() { ends[next - 1] } else { f64::NEG_INFINITY };
        let point = root + if at - before < ends[next] - at { next } else { next + 1 };
        let place = seat.unwrap_or_else(|| self.written(hair.positions[point]));
        let body = self.body.as_ref().map(|(index, ..)| *index);
        Ok((hair.inverse_mass[point] > 0.0).then_some(Pinned { point: point as u32, body, place }))
    }

    /// Length of the shortest way from a root to a seat around the body \[m\].
    fn way(&self, root: DVec3, seat: DVec3) -> f64 {
        let Some((_, body, _)) = &self.body else { return root.distance(seat) };
        let mut way: Vec<DVec3> =
            (0..=SPANS).map(|k| around(body.shape.center(), root, seat, k as f64 / SPANS as f64)).collect();
        for _ in 0..ROUNDS {
            for k in 1..SPANS {
                let middle = 0.5 * (way[k - 1] + way[k + 1]);
                let (distance, normal) = body.shape.signed_distance(middle);
                way[k] = middle - distance.min(0.0) * normal;
            }
        }
        way.windows(2).map(|ends| ends[0].distance(ends[1])).sum()
    }
}

impl Ring {
    /// A seat for each root: as far round the ring as the root is, and spread evenly over the disc by how far out the
    /// root is \[m\].
    fn seats(&self, roots: &[DVec3]) -> Vec<DVec3> {
        let center = DVec3::from_array(self.center);
        let mean = roots.iter().sum::<DVec3>() / roots.len().max(1) as f64;
        let away = || (center - mean).normalize_or(DVec3::NEG_Y);
        let normal = self.normal.map_or_else(away, DVec3::from_array);
        let across = normal.any_orthonormal_vector();
        let up = normal.cross(across);
        let flat: Vec<DVec3> = roots.iter().map(|x| (*x - mean).reject_from_normalized(normal)).collect();
        let mut order: Vec<usize> = (0..roots.len()).collect();
        order.sort_by(|&a, &b| flat[a].length().total_cmp(&flat[b].length()));
        let mut seats = vec![center; roots.len()];
        for (rank, &i) in order.iter().enumerate() {
            let radius = self.radius * ((rank as f64 + 0.5) / roots.len() as f64).sqrt();
            // Roots in one place have no direction.
            let angle = TAU * 0.381_966 * rank as f64;
            let direction = flat[i].try_normalize().unwrap_or_else(|| angle.cos() * across + angle.sin() * up);
            seats[i] = center + radius * direction;
        }
        seats
    }
}

/// The place a part of the way, 0 to 1, from `from` to `to` about a center \[m\]: direction and distance from the
/// center go evenly.
#[must_use]
pub fn around(center: DVec3, from: DVec3, to: DVec3, part: f64) -> DVec3 {
    let (a, b) = (from - center, to - center);
    let (Some(start), Some(end)) = (a.try_normalize(), b.try_normalize()) else { return from.lerp(to, part) };
    let turn = DQuat::IDENTITY.slerp(DQuat::from_rotation_arc(start, end), part);
    center + (a.length() + part * (b.length() - a.length())) * (turn * start)
}

impl SceneValues {
    /// Pins must have bodies that there are, a solver that knows them, and time to gather strands in.
    pub(crate) fn check_pins(&self, at: &At<'_>) {
        for (i, hair) in self.hair.iter().enumerate() {
            for (k, pin) in hair.pins.iter().enumerate() {
                let path = format!("hair.{i}.pin.{k}");
                if let Some(name) = pin.body.as_deref()
                    && !self.bodies.iter().any(|body| body.name == name)
                {
                    let names: Vec<&str> = self.bodies.iter().map(|body| &*body.name).collect();
                    at.fault(&format!("{path}.body"), unknown("the name of a body of the scene", name, &names));
                }
                if self.rods.solver == Solver::GaussSeidel {
                    at.fault(&path, "rods.solver is \"gauss-seidel\", which knows no pins: expected \"direct\"");
                }
                if pin.ring.is_some() && self.time.settle == 0.0 {
                    let words =
                        "time.settle is 0: expected time in which strands are gathered, such as time.settle = 1";
                    at.fault(&format!("{path}.ring"), words);
                }
            }
        }
    }
}
