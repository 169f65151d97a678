//! Checks that `windswept validate` leaves out for their time: short steps and vortices of three dimensions, a tuft in
//! air's own sums, the force on strands that stand still in boxes so large that the flow around them has room, a porous
//! strip across a channel, a bundle of strands, a mat that lies for ten seconds, and hair that comes to rest on bodies.

use windswept_validate::LONG_CHECKS;

use crate::support;

/// One ignored test per check, and a reason that says how long it takes; none is left out.
macro_rules! checks {
    ($($test:ident: $name:literal, $reason:literal),+ $(,)?) => {
        $(
            #[test]
            #[ignore = $reason]
            fn $test() {
                let check = LONG_CHECKS.iter().find(|check| check.name == $name).unwrap();
                let rows = check.rows(&support::gpu());
                for row in &rows {
                    println!("{}: {} {}, expected {} within {}", row.quantity, row.measured, row.unit, row.expected, row.tolerance);
                }
                let failing: Vec<_> = rows.iter().filter(|row| !row.passes()).map(|row| &row.quantity).collect();
                assert!(!rows.is_empty() && failing.is_empty(), "{failing:?}");
            }
        )+

        #[test]
        fn every_long_check_has_its_test() {
            let names: Vec<_> = LONG_CHECKS.iter().map(|check| check.name).collect();
            assert_eq!(names, [$($name),+]);
        }
    };
}

checks! {
    pressure_has_a_limit: "pressure-limits", "long: 200 s of CPU time",
    vortices_decay_as_on_a_grid: "taylor-green-3d", "long: 10 min of CPU time",
    tufts_have_a_limit: "tuft", "long: 10 min of CPU time",
    lone_strands_feel_the_law: "fixed-wide", "long: 280 s of CPU time",
    porous_strips_slow_a_channel: "strip", "long: 11 min of CPU time",
    strips_have_a_limit_as_the_step_falls: "strip-halved", "long: 6 min of CPU time",
    bundles_shelter_their_fibres: "bundle", "long: 910 s of CPU time",
    large_mats_sleep: "mat-for-long", "long: 50 s of CPU time",
    hair_comes_to_rest_on_bodies: "contact-rests", "long: 40 s of CPU time",
    wind_passes_bodies: "bodies-in-wind", "long: 15 min of CPU time",
}
