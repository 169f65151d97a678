//! Air to measure on, in a periodic cube, with the paper's particles.

use glam::DVec3;
use windswept_validate::internals::Cloud;

/// The simple cubic lattice, particles in the middle of their cells \[sides of a cell\].
const CENTRED: &[[f64; 3]] = &[[0.5 - 0.125; 3]];

/// A simple cubic lattice of `n` particles a side, one per V, at rest.
pub(crate) fn lattice(n: usize) -> Cloud {
    Cloud::lattice([n; 3], CENTRED)
}

/// The air with each particle moved by a field.
pub(crate) fn moved(mut air: Cloud, shift: impl Fn(DVec3) -> DVec3) -> Cloud {
    for x in &mut air.positions {
        let at = DVec3::from_array(*x);
        *x = (at + shift(at)).rem_euclid(air.size).to_array();
    }
    air
}

/// Root mean square of some values; NaN of none.
pub(crate) fn rms(values: impl IntoIterator<Item = f64>) -> f64 {
    let (sum, n) = values.into_iter().fold((0.0, 0.0), |(sum, n), x| (sum + x * x, n + 1.0));
    f64::sqrt(sum / n)
}
