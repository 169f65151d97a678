//! Units that files may be in, where the scale that is given may be that of another one.

use std::ops::RangeInclusive;

/// Metres per unit.
const UNITS: [(f64, &str); 5] =
    [(1.0, "metres"), (0.1, "decimetres"), (0.0254, "inches"), (0.01, "centimetres"), (0.001, "millimetres")];

/// Message with the size of a thing that is `size` \[m\] with this scale, and its sizes with the units with which it
/// is as large as is likely \[m\].
pub(crate) fn with_scale(size: f64, scale: f64, likely: &RangeInclusive<f64>) -> String {
    let others = UNITS.iter().map(|(other, unit)| (other, unit, size * other / scale));
    let others = others.filter(|(.., size)| likely.contains(size));
    let others: Vec<_> = others.map(|(other, unit, size)| format!("{size:.3} m with {other}, of {unit}")).collect();
    let or = if others.is_empty() { String::new() } else { format!("; it would be {}", others.join(", ")) };
    let size = if size < 0.001 { format!("{size:.1e}") } else { format!("{size:.3}") };
    format!("{size} m with a scale of {scale}{or}")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Units are named with which the size is likely, and no others.
    #[test]
    fn likely_units_are_named() {
        let likely = 0.05..=2.0;
        let said =
            "26.000 m with a scale of 1; it would be 0.660 m with 0.0254, of inches, 0.260 m with 0.01, of centimetres";
        assert_eq!(with_scale(26.0, 1.0, &likely), said);
        assert_eq!(
            with_scale(2.5e-4, 1e-3, &likely),
            "2.5e-4 m with a scale of 0.001; it would be 0.250 m with 1, of metres"
        );
        assert_eq!(with_scale(1e6, 1.0, &likely), "1000000.000 m with a scale of 1");
    }
}
