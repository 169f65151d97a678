//! The wind as the shaders see it: the table of the mean wind, the waves of the inflow.

use windswept_scene::{CheckedScene, FrameEntry, InitialState};
use windswept_shaders::common::{frame::Entry, inflow::Wave};

use crate::upload::vectors::vec3;

/// A time that no run reaches \[s\].
const NEVER: f32 = 1e30;

/// Number of entries of the table of the mean wind, with room for a wind that is set and for a body that is moved. The
/// last entry repeats the one before at a time that no run reaches.
fn table_len(scene: &CheckedScene) -> usize {
    let written = scene.scene().air.as_ref().map_or(0, |air| air.gust.len() + 2);
    let now = scene.air.as_ref().map_or(0, |air| air.wind_table().len());
    // A body that a caller moves has three keyframes: three entries each, and two for the start.
    let moved = if scene.followed().is_some() { written + FRAME_ENTRIES } else { 0 };
    now.max(moved).max(2) + 1
}

/// Entries of the frame of a body that a caller moves: two for the start, three for each of three keyframes.
const FRAME_ENTRIES: usize = 2 + 3 * 3;

/// Table of the frame of `air.follows`, filled up with its last entry; empty without one.
pub(crate) fn frame_table(scene: &CheckedScene) -> Vec<Entry> {
    let entry = |entry: &FrameEntry| Entry {
        place: vec3(entry.place),
        time: entry.time as f32,
        velocity: vec3(entry.velocity),
        ..Entry::default()
    };
    let mut table: Vec<Entry> = scene.frame_table().iter().map(entry).collect();
    let Some(last) = table.last().copied() else { return table };
    let first = table.len();
    table.extend((first..FRAME_ENTRIES).map(|k| Entry { time: NEVER * (1 + k - first) as f32, ..last }));
    table
}

/// Table of the mean wind: U \[m/s\] and time \[s\] at every change of its course.
pub(crate) fn table(scene: &CheckedScene) -> Vec<[f32; 4]> {
    let entries = scene.air.as_ref().map_or_else(|| vec![(0.0, [0.0; 3])], |air| air.wind_table());
    let rows = entries.iter().map(|(time, u)| [u[0] as f32, u[1] as f32, u[2] as f32, *time as f32]);
    filled(rows.collect(), table_len(scene))
}

/// Table of a wind that is now `from` \[m/s\] at `before` \[s\], and that of the scene from `time` on, the end of the
/// step that starts there.
pub(crate) fn turned(scene: &CheckedScene, from: [f32; 3], before: f32, time: f64, len: usize) -> Vec<[f32; 4]> {
    let row = |u: [f64; 3], time: f64| [u[0] as f32, u[1] as f32, u[2] as f32, time as f32];
    let mut rows = vec![[from[0], from[1], from[2], before]];
    if let Some(air) = &scene.air {
        rows.push(row(air.wind_at(time), time));
        // An entry that rounding puts at the end of the step is that entry.
        let later = air.wind_table().into_iter().filter(|(at, _)| *at as f32 > time as f32);
        rows.extend(later.map(|(time, u)| row(u, time)));
    }
    filled(rows, len)
}

/// The table filled up to the length of the buffer: the last wind holds.
fn filled(mut table: Vec<[f32; 4]>, len: usize) -> Vec<[f32; 4]> {
    let [x, y, z, _] = table.last().copied().unwrap_or_default();
    let first = table.len();
    table.extend((first..len).map(|k| [x, y, z, NEVER * (1 + k - first) as f32]));
    table
}

/// The waves of `air.inflow`; none without an inflow.
pub(crate) fn waves(scene: &CheckedScene, initial: &InitialState) -> Vec<Wave> {
    let waves = scene.air.as_ref().map_or_else(Vec::new, |air| air.inflow_waves(initial.air.size));
    let wave = |wave: &windswept_scene::InflowWave| {
        let (k, a) = (wave.number.as_vec3(), wave.amplitude.as_vec3());
        Wave { number: k.extend(wave.phase as f32).to_array(), amplitude: a.extend(0.0).to_array() }
    };
    waves.iter().map(wave).collect()
}
