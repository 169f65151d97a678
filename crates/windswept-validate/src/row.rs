//! A claim with its number.

use std::fmt::Display;

use serde::{Serialize, Serializer, ser::SerializeStruct};

/// A claim: what was expected, what came out.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Quantity that was tested, in words.
    pub test: String,
    /// Expected value, in `unit`.
    pub expected: f64,
    /// Measured value, in `unit`; NaN where nothing could be measured.
    pub measured: f64,
    /// Largest |measured − expected| that passes, in `unit`.
    pub tolerance: f64,
    /// Unit of the values; empty for a pure number.
    pub unit: &'static str,
    /// Source of the expected value, and the ground of the tolerance.
    pub source: &'static str,
}

impl Row {
    /// Whether the measured value is within the tolerance; NaN is not.
    #[must_use]
    pub fn passes(&self) -> bool {
        (self.measured - self.expected).abs() <= self.tolerance
    }

    /// A row of a number without a unit; see [`Self::in_unit`].
    pub(crate) fn new(
        test: impl Into<String>,
        expected: f64,
        measured: f64,
        tolerance: f64,
        source: &'static str,
    ) -> Self {
        Self { test: test.into(), expected, measured, tolerance, unit: "", source }
    }

    pub(crate) fn in_unit(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }

    /// A check that could not be done.
    pub(crate) fn failed(check: &str, error: &impl Display) -> Self {
        Self::new(format!("{check}: {error}"), f64::NAN, f64::NAN, 0.0, "the check could not be done")
    }
}

/// The row as JSON: its fields, and `passed`.
impl Serialize for Row {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut row = serializer.serialize_struct("Row", 7)?;
        row.serialize_field("test", &self.test)?;
        row.serialize_field("expected", &self.expected)?;
        row.serialize_field("measured", &self.measured)?;
        row.serialize_field("tolerance", &self.tolerance)?;
        row.serialize_field("unit", self.unit)?;
        row.serialize_field("source", self.source)?;
        row.serialize_field("passed", &self.passes())?;
        row.end()
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
