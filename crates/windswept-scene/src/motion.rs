//! Rigid motions by keyframes: `[[hair.motion]]` and `[[body.motion]]`.

use std::f64::consts::PI;

use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

use crate::{
    declare::{Field, Row, Written, table},
    faults::At,
    keys::{
        Fallback::{Required, Value},
        Key, Kind,
        Kind::{NonNegative, Vector},
    },
    reader::Reader,
    scene::Scene,
    write::Writer,
};

/// A rigid motion about the thing's own centre c: x(t) = c + R(t) (x − c) + T(t).
///
/// Between two keyframes T is linear and R turns steadily about one axis (slerp); before the first and after the last
/// they hold. Without keyframes the thing rests.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Motion {
    /// Keyframes: their times rise, and from each to the next is less than half a turn.
    pub keyframes: Vec<Keyframe>,
    /// The centre, where it is that of another thing, as of roots that move with a body \[m\]; a checked scene has it.
    #[serde(skip)]
    pub center: Option<DVec3>,
}

table! {
    /// One of `[[hair.motion]]` or `[[body.motion]]`.
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
    pub struct Keyframe {
        /// Time of the keyframe; each is later than the one before.
        time: f64 = NonNegative, "s", Required;
        /// Translation T from the position that the scene gives; tips of strands that are held stay.
        translation: [f64; 3] = Vector, "m", Value([0.0; 3]);
        /// Rotation vector of R, axis times angle, about the thing's centre.
        rotation: [f64; 3] = Vector, "rad", Value([0.0; 3]);
    }
}

/// A pose of a thing with a centre c: it is at x = c + R (x₀ − c) + T, where x₀ is its place without a motion.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Pose {
    /// Translation T \[m\].
    pub translation: DVec3,
    /// Rotation R.
    pub rotation: DQuat,
}

impl Pose {
    /// Position \[m\] of `point`, of a thing with this centre.
    #[must_use]
    pub fn place(&self, center: DVec3, point: DVec3) -> DVec3 {
        center + self.rotation * (point - center) + self.translation
    }

    /// Position \[m\] without the pose of a point that is at `place` in it, of a thing with this centre.
    #[must_use]
    pub fn written(&self, center: DVec3, place: DVec3) -> DVec3 {
        center + self.rotation.conjugate() * (place - center - self.translation)
    }
}

impl Keyframe {
    /// The thing in its own place at `time` \[s\].
    #[must_use]
    pub fn new(time: f64) -> Self {
        Self { time, translation: [0.0; 3], rotation: [0.0; 3] }
    }

    /// The thing in a pose at `time` \[s\].
    #[must_use]
    pub fn posed(time: f64, pose: Pose) -> Self {
        let rotation = pose.rotation.to_scaled_axis().to_array();
        Self { time, translation: pose.translation.to_array(), rotation }
    }

    /// The pose at the keyframe.
    #[must_use]
    pub fn pose(&self) -> Pose {
        let rotation = DQuat::from_scaled_axis(DVec3::from_array(self.rotation));
        Pose { translation: DVec3::from_array(self.translation), rotation }
    }
}

impl Motion {
    /// The pose at `time` \[s\].
    #[must_use]
    pub fn at(&self, time: f64) -> Pose {
        let (before, part) = self.phase(time);
        match self.keyframes.get(before..) {
            Some([from, to, ..]) if part > 0.0 => {
                let (from, to) = (from.pose(), to.pose());
                let translation = from.translation.lerp(to.translation, part);
                Pose { translation, rotation: from.rotation.slerp(to.rotation, part) }
            }
            Some([only, ..]) => only.pose(),
            _ => Pose::default(),
        }
    }

    /// Index of the keyframe before `time` \[s\], or of the first, and the part of the way to the next.
    pub(crate) fn phase(&self, time: f64) -> (usize, f64) {
        phase(&self.keyframes, |keyframe| keyframe.time, time)
    }

    /// Position of `point`, of a thing with this centre, at `time` \[s\], in m.
    #[must_use]
    pub fn place(&self, center: DVec3, point: DVec3, time: f64) -> DVec3 {
        self.at(time).place(center, point)
    }
}

/// Of rows whose places rise, the index of the last that is not beyond `x`, or of the first, and the part of the way to
/// the next; 0 before the first and after the last.
pub(crate) fn phase<T>(rows: &[T], place: impl Fn(&T) -> f64, x: f64) -> (usize, f64) {
    let Some(before) = rows.partition_point(|row| place(row) <= x).checked_sub(1) else { return (0, 0.0) };
    let own = place(&rows[before]);
    (before, rows.get(before + 1).map_or(0.0, |next| (x - own) / (place(next) - own)))
}

impl<const N: usize> From<[Keyframe; N]> for Motion {
    fn from(keyframes: [Keyframe; N]) -> Self {
        Self::from(Vec::from(keyframes))
    }
}

impl From<Vec<Keyframe>> for Motion {
    fn from(keyframes: Vec<Keyframe>) -> Self {
        Self { keyframes, center: None }
    }
}

impl Written for Motion {
    fn write(&self, name: &'static str, writer: &mut Writer) {
        self.keyframes.write(name, writer);
    }
}

/// A motion is spelled as the list of its keyframes.
impl Field for Motion {
    type Checked = Self;

    fn list(row: Row<Self>, path: &str, all: &mut Vec<Key>) {
        Vec::<Keyframe>::list(row.of_parts(), path, all);
    }

    fn read(row: Row<Self>, reader: &Reader<'_>) -> Option<Self> {
        Vec::<Keyframe>::read(row.of_parts(), reader).map(Self::from)
    }

    /// Times must rise, and turns must be less than half a turn.
    fn check(&self, name: &'static str, kind: Kind, scene: &Scene, at: &At<'_>) -> Option<Self> {
        let keyframes = self.keyframes.check(name, kind, scene, at)?;
        at.rising(name, self.keyframes.iter().map(|keyframe| keyframe.time));
        let turn =
            |pair: &[Keyframe]| DVec3::from_array(pair[1].rotation).distance(DVec3::from_array(pair[0].rotation));
        // The way is the shorter one: rotation vectors that differ by less than half a turn leave no doubt.
        if let Some((i, turn)) = self.keyframes.windows(2).map(turn).enumerate().find(|(_, turn)| *turn >= PI) {
            let words = format!(
                "differs from the keyframe before by {turn:.4} rad; expected less than half a turn, {PI:.5} rad: a spin \
                 needs keyframes between"
            );
            at.fault(&format!("{name}.{}.rotation", i + 1), words);
        }
        Some(keyframes.into())
    }
}
