//! What `windswept validate` leaves out for its time: the exchange of hair and air at a quarter of the step, and a porous strip.

#![allow(clippy::unwrap_used, missing_docs)]

mod support;

use windswept_validate::LONG_CHECKS;

#[test]
#[ignore = "long: a porous strip in a channel of air, many minutes of CPU time"]
fn hair_and_air_exchange_what_porous_bodies_do() {
    let mut failing = Vec::new();
    for check in LONG_CHECKS {
        for row in check.rows(&support::gpu()) {
            println!("{}: {} {}, expected {} within {}", row.test, row.measured, row.unit, row.expected, row.tolerance);
            if !row.passes() {
                failing.push(row.test);
            }
        }
    }
    assert!(failing.is_empty(), "{failing:?}");
}
