//! The frames of a window of time.

use std::ops::Range;

use super::MeasureOptions;

/// The fewest frames that are measured.
const FEWEST: usize = 8;
/// Times that differ by less are the same [s].
const SAME: f64 = 1e-9;

/// Indices of the frames at these times [s], rising, that are in the window; or what is wrong with it.
pub(super) fn window(times: &[f64], options: &MeasureOptions) -> Result<Range<usize>, String> {
    let (Some(&first), Some(&last)) = (times.first(), times.last()) else { return Err("has no frame".to_owned()) };
    let from = options.from.unwrap_or(if last < 2.0 * MeasureOptions::START { first } else { MeasureOptions::START });
    let to = options.to.unwrap_or(last);
    if !(from.is_finite() && to.is_finite() && from < to) {
        return Err(format!("expected a window that ends after it starts, found one from {from} to {to} s"));
    }
    let range = times.partition_point(|time| *time < from - SAME)..times.partition_point(|time| *time <= to + SAME);
    if range.len() < FEWEST {
        let has = format!("has {} frames from {from} to {to} s, expected at least {FEWEST}", range.len());
        return Err(format!("{has}; its frames are from {first:.3} to {last:.3} s"));
    }
    Ok(range)
}

/// Mean time from one of these frames to the next [s]; or which frame is not where even times would have it.
pub(super) fn interval(times: &[f64]) -> Result<f64, String> {
    let (first, last) = (times[0], times[times.len() - 1]);
    let interval = (last - first) / (times.len() - 1) as f64;
    let is_off = |time: f64, even: f64| (time - even).abs() > 0.5 * interval + SAME;
    let off = (1..times.len())
        .find(|&k| is_off(times[k], first + k as f64 * interval) || is_off(times[k], times[k - 1] + interval));
    match off {
        Some(k) => Err(format!(
            "expected frames at even times, {interval:.6} s apart; found one at {:.6} s behind one at {:.6} s",
            times[k],
            times[k - 1]
        )),
        None => Ok(interval),
    }
}
