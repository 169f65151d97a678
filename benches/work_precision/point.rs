//! A measured point.

use serde::{Deserialize, Serialize};

use crate::timing::Time;

/// One setting, its time and its error: a row of a CSV file, a point of a picture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Point {
    /// Kind of error, with its unit: a panel of the picture.
    pub(crate) error_kind: String,
    /// Series that the point belongs to: a line of the picture.
    pub(crate) series: String,
    /// Setting that varies along the line.
    pub(crate) setting: String,
    /// Time \[ms\] of what the family says.
    pub(crate) ms: f64,
    /// Clock: `gpu timestamps` or `wall`.
    pub(crate) ms_source: String,
    /// Error, in the unit of `error_kind`; not finite where the run ended early.
    pub(crate) error: f64,
    /// Uncertainty of what the point is compared with, in the same unit: smaller errors say nothing. 0 where that is
    /// exact.
    pub(crate) uncertainty: f64,
    /// Whether a scene that leaves the family's keys out has this setting.
    pub(crate) default: bool,
    /// Whether the setting may become the default of `method = "accurate"`.
    pub(crate) candidate: bool,
}

impl Point {
    /// Point of a candidate that is not the default, compared with something exact.
    pub(crate) fn new(error_kind: &str, series: &str, setting: &str, time: &Time, error: f64) -> Self {
        Self {
            error_kind: error_kind.to_owned(),
            series: series.to_owned(),
            setting: setting.to_owned(),
            ms: time.ms,
            ms_source: time.source.to_owned(),
            error,
            uncertainty: 0.0,
            default: false,
            candidate: true,
        }
    }

    /// Whether the point can be drawn.
    pub(crate) fn is_finite(&self) -> bool {
        self.error.is_finite() && self.error > 0.0 && self.ms > 0.0
    }
}

/// The values of a field in the order in which they first appear.
pub(crate) fn distinct<'a>(points: &'a [Point], field: impl Fn(&'a Point) -> &'a str) -> Vec<&'a str> {
    let mut all = Vec::new();
    for value in points.iter().map(field) {
        if !all.contains(&value) {
            all.push(value);
        }
    }
    all
}
