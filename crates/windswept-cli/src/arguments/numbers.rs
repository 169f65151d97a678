//! Numbers that can be typed, each with the error that says what is expected.

use std::fmt::Display;
use std::num::NonZeroU64;
use std::str::FromStr;

/// A whole number of at least so many.
fn at_least<T: FromStr + PartialOrd + Display>(least: T, word: &str) -> Result<T, String> {
    let number = word.parse().ok().filter(|number| *number >= least);
    number.ok_or_else(|| format!("expected a whole number of at least {least}"))
}

pub(super) fn whole(word: &str) -> Result<u64, String> {
    at_least(0, word)
}

pub(super) fn count(word: &str) -> Result<u32, String> {
    at_least(1, word)
}

pub(super) fn every<T: TryFrom<NonZeroU64>>(word: &str) -> Result<T, String> {
    let number = at_least(1, word)?;
    let fits = NonZeroU64::new(number).and_then(|number| T::try_from(number).ok());
    fits.ok_or_else(|| format!("{number} is too large"))
}

pub(super) fn seconds(word: &str) -> Result<f64, String> {
    let number = word.parse().ok().filter(|time: &f64| time.is_finite());
    number.ok_or_else(|| "expected a time in seconds".to_owned())
}

pub(super) fn moment(word: &str) -> Result<f64, String> {
    seconds(word).map_err(|_| "expected times in seconds, e.g. 0,0.5,1".to_owned())
}

pub(super) fn positive(word: &str) -> Result<f64, String> {
    let number = word.parse().ok().filter(|x: &f64| x.is_finite() && *x > 0.0);
    number.ok_or_else(|| "expected a number greater than 0".to_owned())
}

#[cfg(feature = "spectrum")]
pub(super) fn scale(word: &str) -> Result<f64, String> {
    let expected = || "expected lengths in metres above 0, e.g. 0.006,0.018".to_owned();
    word.parse().ok().filter(|scale: &f64| scale.is_finite() && *scale > 0.0).ok_or_else(expected)
}
