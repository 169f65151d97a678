//! How far hair may get, and the box of air that is cut to it: `air.margin`.

use glam::DVec3;

use crate::{
    error::SceneError,
    limits::MIN_BOX_SIDE,
    motion::Motion,
    scene::{Bounds, CheckedAir, SceneValues, check_size},
    strands::{End, Strands},
};

/// Poses of a moving root that are looked at between two of its keyframes.
const POSES: u32 = 16;

/// The part of the box of air within `air.margin` of where hair may get, and on the sides that wind enters through also
/// the fringe: all of it without `air.margin`, without hair, and with strands whose roots are free.
///
/// A strand may get anywhere within its length of its root, wherever its keyframes carry that.
///
/// # Errors
/// [`SceneError`] where no hair can get into the box, and where what is left holds more particles than fit.
pub(crate) fn cut(scene: &SceneValues, air: &CheckedAir, bounds: Bounds, hair: &Strands) -> Result<Bounds, SceneError> {
    let [low, high] = of_hair(scene, hair);
    let Some(margin) = air.margin.filter(|_| low.is_finite() && high.is_finite()) else { return Ok(bounds) };
    let [min, max] = [bounds.min, bounds.max].map(DVec3::from_array);
    if high.cmplt(min).any() || low.cmpgt(max).any() {
        return Err(
            SceneError::new("no hair can get into air.box: expected some within its reach").at("air.margin", None)
        );
    }
    let entered =
        |sign: f64| DVec3::from_array([0, 1, 2].map(|axis| if air.blows(axis, sign) { air.fringe } else { 0.0 }));
    let from = (low - margin - entered(1.0)).clamp(min, max);
    let to = (high + margin + entered(-1.0)).clamp(min, max);
    // A box must hold a few kernels.
    let short = |from: DVec3, to: DVec3| (MIN_BOX_SIDE * air.kernel_radius - (to - from)).max(DVec3::ZERO);
    let from = (from - short(from, to)).max(min);
    let to = (to + short(from, to)).min(max);
    let cut = Bounds { min: from.to_array(), max: to.to_array() };
    check_size(&cut, air.particle_volume(), air.kernel_radius)
        .map_err(|(key, words)| SceneError::new(words).at(format!("air.{key}"), None))?;
    Ok(cut)
}

/// Corners of the box that hair may get into \[m\]: everywhere with strands whose roots are free, and nowhere without
/// hair, where the lower corner is above the upper one.
pub(crate) fn of_hair(scene: &SceneValues, hair: &Strands) -> [DVec3; 2] {
    if (0..hair.len()).any(|s| hair.ends(s).root == End::Free) {
        return [DVec3::NEG_INFINITY, DVec3::INFINITY];
    }
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for (s, root) in hair.roots().enumerate() {
        let length: f64 = hair.rest_length[hair.segments(s)].iter().sum();
        for place in places(scene, hair, s, root) {
            low = low.min(place - length);
            high = high.max(place + length);
        }
    }
    [low, high]
}

/// Where a root that is at `root` at the start gets \[m\].
fn places(scene: &SceneValues, hair: &Strands, s: usize, root: DVec3) -> Vec<DVec3> {
    let Some(group) = hair.group(s, scene) else { return vec![root] };
    let (motion, center) = (&scene.in_frame(&group.motion), group.center());
    let drawn = motion.at(0.0).written(center, root);
    times(motion).into_iter().map(|time| motion.place(center, drawn, time)).collect()
}

/// Times that tell where a motion gets: its keyframes, and some between them \[s\].
fn times(motion: &Motion) -> Vec<f64> {
    let steps = |pair: &[f64]| {
        let (from, to) = (pair[0], pair[1]);
        (1..=POSES).map(move |k| from + (to - from) * f64::from(k) / f64::from(POSES)).collect::<Vec<_>>()
    };
    let marks: Vec<f64> = std::iter::once(0.0).chain(motion.keyframes.iter().map(|keyframe| keyframe.time)).collect();
    std::iter::once(0.0).chain(marks.windows(2).flat_map(steps)).collect()
}
