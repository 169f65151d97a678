//! How something moves as a whole: `[[hair.motion]]` and `[[body.motion]]`.

use std::f64::consts::PI;

use glam::{DQuat, DVec3};

use crate::{error::SceneError, reader::Reader};

/// A rigid motion about the thing's own centre c: x(t) = c + R(t) (x − c) + T(t).
///
/// Between two keyframes T is linear and R turns steadily about one axis (slerp); before the first and after the last
/// they hold. Without keyframes the thing rests.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Motion {
    /// Times rise, and from each to the next is less than half a turn.
    pub keyframes: Vec<Keyframe>,
}

/// One of `[[hair.motion]]` or `[[body.motion]]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Keyframe {
    /// \[s\]
    pub time: f64,
    /// T \[m\].
    pub translation: [f64; 3],
    /// Rotation vector of R \[rad\]: the axis times the angle.
    pub rotation: [f64; 3],
}

impl Keyframe {
    /// T \[m\] and R.
    #[must_use]
    pub fn pose(&self) -> (DVec3, DQuat) {
        (DVec3::from_array(self.translation), DQuat::from_scaled_axis(DVec3::from_array(self.rotation)))
    }
}

impl Motion {
    /// T \[m\] and R at `time` \[s\].
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

    /// Where `point` of a thing with this centre is at `time` \[s\], in m.
    #[must_use]
    pub fn place(&self, center: DVec3, point: DVec3, time: f64) -> DVec3 {
        let (translation, rotation) = self.at(time);
        center + rotation * (point - center) + translation
    }
}

impl Reader<'_> {
    /// The keyframes of `table`, in the order of their times.
    pub(crate) fn motion(&self, table: &str) -> Result<Motion, SceneError> {
        let mut motion = Motion::default();
        for i in 0..self.tables(table) {
            let at = |name: &str| format!("{table}.{i}.{name}");
            let keyframe = Keyframe {
                time: self.number(&at("time"))?,
                translation: self.vector(&at("translation"))?,
                rotation: self.vector(&at("rotation"))?,
            };
            if let Some(before) = motion.keyframes.last() {
                if keyframe.time <= before.time {
                    let words = format!(
                        "expected a time after that of the keyframe before, {} s; found {}",
                        before.time, keyframe.time
                    );
                    return Err(self.fault(&at("time"), words));
                }
                // The way is the shorter one: rotation vectors that differ by less than half a turn leave no doubt.
                let turn = DVec3::from_array(keyframe.rotation).distance(DVec3::from_array(before.rotation));
                if turn >= PI {
                    let words = format!(
                        "differs from the keyframe before by {turn:.4} rad; expected less than half a turn, {PI:.5} rad: a spin \
                         needs keyframes between"
                    );
                    return Err(self.fault(&at("rotation"), words));
                }
            }
            motion.keyframes.push(keyframe);
        }
        Ok(motion)
    }
}
