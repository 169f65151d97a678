//! Rigid motions by keyframes: `[[hair.motion]]` and `[[body.motion]]`.

use std::f64::consts::PI;

use glam::{DQuat, DVec3};

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
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Motion {
    /// Keyframes: their times rise, and from each to the next is less than half a turn.
    pub keyframes: Vec<Keyframe>,
}

table! {
    /// One of `[[hair.motion]]` or `[[body.motion]]`.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Keyframe {
        /// Time of the keyframe; each is later than the one before.
        time: f64 = NonNegative, "s", Required;
        /// Translation T from the position that the scene gives; tips of strands that are held stay.
        translation: [f64; 3] = Vector, "m", Value([0.0; 3]);
        /// Rotation vector of R, axis times angle, about the thing's centre.
        rotation: [f64; 3] = Vector, "rad", Value([0.0; 3]);
    }
}

impl Keyframe {
    /// The thing in its own place at `time` \[s\].
    #[must_use]
    pub fn new(time: f64) -> Self {
        Self { time, translation: [0.0; 3], rotation: [0.0; 3] }
    }

    /// Translation T \[m\] and rotation R.
    #[must_use]
    pub fn pose(&self) -> (DVec3, DQuat) {
        (DVec3::from_array(self.translation), DQuat::from_scaled_axis(DVec3::from_array(self.rotation)))
    }
}

impl Motion {
    /// Translation T \[m\] and rotation R at `time` \[s\].
    #[must_use]
    pub fn at(&self, time: f64) -> (DVec3, DQuat) {
        let next = self.keyframes.partition_point(|keyframe| keyframe.time <= time);
        let before = next.checked_sub(1).and_then(|last| self.keyframes.get(last));
        match (before, self.keyframes.get(next)) {
            (Some(before), Some(after)) => {
                let part = (time - before.time) / (after.time - before.time);
                let ((from, turned), (to, turning)) = (before.pose(), after.pose());
                (from.lerp(to, part), turned.slerp(turning, part))
            }
            (Some(only), None) | (None, Some(only)) => only.pose(),
            (None, None) => (DVec3::ZERO, DQuat::IDENTITY),
        }
    }

    /// Position of `point`, of a thing with this centre, at `time` \[s\], in m.
    #[must_use]
    pub fn place(&self, center: DVec3, point: DVec3, time: f64) -> DVec3 {
        let (translation, rotation) = self.at(time);
        center + rotation * (point - center) + translation
    }
}

impl<const N: usize> From<[Keyframe; N]> for Motion {
    fn from(keyframes: [Keyframe; N]) -> Self {
        Self { keyframes: keyframes.into() }
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
        Vec::<Keyframe>::read(row.of_parts(), reader).map(|keyframes| Self { keyframes })
    }

    fn find(&self, name: &'static str, kind: Kind, at: &At<'_>) {
        self.keyframes.find(name, kind, at);
    }

    /// Times must rise, and turns must be less than half a turn.
    fn check(&self, name: &'static str, _: Kind, _: &Scene, at: &At<'_>) -> Option<Self> {
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
        Some(self.clone())
    }
}
