//! The wind as the shaders see it: the table of the mean wind, the waves of the inflow.

use windswept_scene::{CheckedScene, InitialState};
use windswept_shaders::common::inflow::Wave;

/// A time that no run reaches \[s\].
const NEVER: f32 = 1e30;

/// Number of entries of the table of the mean wind, with room for a wind that is set. The last entry repeats the one
/// before at a time that no run reaches.
fn table_len(scene: &CheckedScene) -> usize {
    scene.air.as_ref().map_or(0, |air| air.wind_table().len()).max(2) + 1
}

/// Table of the mean wind: U \[m/s\] and time \[s\] at every change of its course.
pub(crate) fn table(scene: &CheckedScene) -> Vec<[f32; 4]> {
    let entries = scene.air.as_ref().map_or_else(|| vec![(0.0, [0.0; 3])], |air| air.wind_table());
    let rows = entries.iter().map(|(time, u)| [u[0] as f32, u[1] as f32, u[2] as f32, *time as f32]);
    filled(rows.collect(), table_len(scene))
}

/// Table of a wind that is `to` from `time` \[s\] on, the end of a step that started at `before` with the wind `from`
/// \[m/s\].
pub(crate) fn turned(from: [f32; 3], before: f32, to: [f32; 3], time: f32, len: usize) -> Vec<[f32; 4]> {
    let row = |u: [f32; 3], time: f32| [u[0], u[1], u[2], time];
    filled(vec![row(from, before), row(to, time)], len)
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
