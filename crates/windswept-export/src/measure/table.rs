//! A measurement as a table for people.

use std::fmt;

use super::Measurement;

impl fmt::Display for Measurement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { strands, frames, from_s, to_s, axis: [x, y, z], .. } = self;
        let largest = format!(
            "mean; largest {:.1} (strand {}, t = {:.3} s)",
            self.turning_largest_degrees, self.turning_strand, self.turning_time_s
        );
        let across = format!("rms of the tips, across ({x:.2}, {y:.2}, {z:.2})");
        writeln!(f, "{strands} strands, {frames} frames from {from_s:.3} to {to_s:.3} s")?;
        let rows: [(&str, Option<f64>, &str, &str); 13] = [
            ("swing", Some(1e3 * self.swing_m), "mm", &across),
            ("  of the bundle", Some(1e3 * self.swing_bundle_m), "mm", "of the mean of all tips"),
            ("  of strands", Some(1e3 * self.swing_strands_m), "mm", "relative to the mean of all tips"),
            ("frequency", self.frequency_hz, "Hz", "at the peak of the swing's spectrum"),
            ("wavelength", self.wavelength_m.map(|length| 1e3 * length), "mm", "of the undulation along strands"),
            ("turning angle", Some(self.turning_mean_degrees), "degrees", &largest),
            ("turns", Some(self.turns), "", "of a curl"),
            ("gathering", self.gathering, "", "distance to nearest strands at 0.8 of the length / at the roots"),
            ("coherence", self.coherence, "", "correlation of neighbouring tips' velocities"),
            ("lean", Some(self.lean_degrees), "degrees", "from the direction of gravity"),
            ("stretch", Some(self.stretch), "", "largest |l/l0 - 1| of a segment"),
            ("spectrum from", self.spectrum_frequency_hz.first().copied(), "Hz", "and in steps of that"),
            ("  to", self.spectrum_frequency_hz.last().copied(), "Hz", "--json has it"),
        ];
        let lines = rows.map(|(name, value, unit, what)| {
            let value = value.map_or_else(|| "-".to_owned(), shown);
            format!("{name:<16}{value:>10} {unit:<8} {what}")
        });
        f.write_str(&lines.join("\n"))
    }
}

/// A number with four digits.
fn shown(number: f64) -> String {
    match number.abs() {
        0.0 => "0".to_owned(),
        size if size < 1e-3 => format!("{number:.3e}"),
        size if size < 1.0 => format!("{number:.4}"),
        _ => format!("{number:.3}"),
    }
}
