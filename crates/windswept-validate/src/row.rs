//! A measured number beside the one that it should be, and a quantity that is measured over settings.

use std::fmt::Display;

use serde::{Serialize, Serializer, ser::SerializeStruct};

/// A measurement: a claim of `windswept validate`, a setting of a stress, a point of run time against error.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Quantity, in words.
    pub quantity: String,
    /// Line of the picture that the setting is on; empty for a claim.
    pub series: String,
    /// Setting along the line, and what ended the run where something did; empty for a claim.
    pub setting: String,
    /// Place of the setting on the axis of the picture; NaN where there is none.
    pub at: f64,
    /// Expected value, in `unit`.
    pub expected: f64,
    /// Measured value, in `unit`; NaN where nothing could be measured.
    pub measured: f64,
    /// Largest |measured − expected| that passes, or of which the expected value is uncertain, in `unit`.
    pub tolerance: f64,
    /// Unit of the values; empty for a pure number.
    pub unit: &'static str,
    /// Source of the expected value, and the ground of the tolerance.
    pub source: &'static str,
    /// Whether a scene may have the setting.
    pub role: Role,
}

/// Role of a setting among those that compete.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// The setting may become a default.
    Candidate,
    /// A scene that leaves the keys out has this setting.
    Default,
    /// The setting is shown for comparison.
    Aside,
}

impl Role {
    /// All roles, by the words that files have for them.
    pub const ALL: [(&str, Self); 3] =
        [("candidate", Self::Candidate), ("default", Self::Default), ("aside", Self::Aside)];
}

impl Row {
    /// Whether the measured value is within the tolerance; NaN is not.
    #[must_use]
    pub fn passes(&self) -> bool {
        (self.measured - self.expected).abs() <= self.tolerance
    }

    /// A claim about a number without a unit; see [`Self::in_unit`].
    #[must_use]
    pub fn new(
        quantity: impl Into<String>,
        expected: f64,
        measured: f64,
        tolerance: f64,
        source: &'static str,
    ) -> Self {
        let (quantity, at, role) = (quantity.into(), f64::NAN, Role::Candidate);
        let (series, setting) = Default::default();
        Self { quantity, series, setting, at, expected, measured, tolerance, unit: "", source, role }
    }

    /// The row with a unit.
    #[must_use]
    pub fn in_unit(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }

    /// A check that could not be done.
    pub(crate) fn failed(check: &str, error: &impl Display) -> Self {
        Self::new(format!("{check}: {error}"), f64::NAN, f64::NAN, 0.0, "the check could not be done")
    }

    /// Value in parts of the tolerance, or as it is where nothing bounds it; infinite where there is no value.
    fn strain(&self) -> f64 {
        let bound = if self.tolerance.is_finite() { self.tolerance } else { 1.0 };
        match self.measured / bound {
            strain if !strain.is_nan() => strain,
            _ if self.passes() => 0.0,
            _ => f64::INFINITY,
        }
    }
}

/// The claim as JSON: quantity, numbers, unit, source, and `passed`.
impl Serialize for Row {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut row = serializer.serialize_struct("Row", 7)?;
        row.serialize_field("quantity", &self.quantity)?;
        row.serialize_field("expected", &self.expected)?;
        row.serialize_field("measured", &self.measured)?;
        row.serialize_field("tolerance", &self.tolerance)?;
        row.serialize_field("unit", self.unit)?;
        row.serialize_field("source", self.source)?;
        row.serialize_field("passed", &self.passes())?;
        row.end()
    }
}

/// A quantity over settings: a part of a table, a panel of a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Sweep {
    /// Quantity, in words.
    pub quantity: String,
    /// Unit of its values; empty for a pure number, or where the quantity says it.
    pub unit: &'static str,
    /// Label of the axis that the rows are drawn over; `None`: no picture.
    pub axis: Option<&'static str>,
    /// Measurements, in the order of the settings; at most `bound` is expected unless a row says otherwise.
    pub rows: Vec<Row>,
    bound: f64,
}

impl Sweep {
    /// A sweep of values that must be at most `bound`, in `unit`.
    #[must_use]
    pub fn new(quantity: impl Into<String>, bound: f64, unit: &'static str) -> Self {
        Self { quantity: quantity.into(), unit, axis: None, rows: Vec::new(), bound }
    }

    /// The sweep with an axis, by its label.
    #[must_use]
    pub fn over(self, axis: &'static str) -> Self {
        Self { axis: Some(axis), ..self }
    }

    /// Adds a value at a place on the axis.
    pub fn add(&mut self, series: impl Into<String>, setting: impl Into<String>, at: f64, measured: f64) -> &mut Row {
        let row = Row::new(&self.quantity, 0.0, measured, self.bound, "a bound").in_unit(self.unit);
        self.rows.push(Row { series: series.into(), setting: setting.into(), at, ..row });
        let last = self.rows.len() - 1;
        &mut self.rows[last]
    }

    /// The row that is nearest to its bound, or farthest beyond it.
    #[must_use]
    pub fn worst(&self) -> Option<&Row> {
        self.rows.iter().reduce(|a, b| if b.strain() > a.strain() { b } else { a })
    }

    /// Rows that do not pass.
    pub fn failing(&self) -> impl Iterator<Item = &Row> + Clone {
        self.rows.iter().filter(|row| !row.passes())
    }

    /// Series, in the order in which they first appear.
    #[must_use]
    pub fn series(sweeps: &[Self]) -> Vec<&str> {
        let mut all = Vec::new();
        for row in sweeps.iter().flat_map(|sweep| &sweep.rows) {
            if !all.contains(&row.series.as_str()) {
                all.push(&row.series);
            }
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::Row;

    /// A difference of the tolerance passes, a larger one does not, and NaN never does.
    #[test]
    fn a_row_passes_within_its_tolerance() {
        let row = |measured: f64| Row::new("", 1.0, measured, 0.5, "");
        assert!(row(1.5).passes() && row(0.5).passes());
        assert!(!row(1.6).passes() && !row(f64::NAN).passes() && !row(f64::INFINITY).passes());
        assert!(!Row::new("", f64::NAN, 1.0, 0.5, "").passes());
        assert!(!Row::failed("reference", &"the device was lost").passes());
    }
}
