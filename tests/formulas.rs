//! Every check of `windswept validate` on the software adapter, and wrong shaders that make its rows fail.
#![allow(clippy::unwrap_used, missing_docs)]

mod support;

use support::fault;
use windswept::Gpu;
use windswept_shaders::{Pass, contact, fluid, forcing, rods, turbulence, viscosity};
use windswept_validate::{CHECKS, Row};

fn rows(name: &str, gpu: &Gpu) -> Vec<Row> {
    let check = CHECKS.iter().find(|check| check.name == name).unwrap_or_else(|| panic!("no check {name}"));
    let rows = check.rows(gpu);
    assert!(!rows.is_empty(), "{name} measures nothing");
    for row in &rows {
        let off = row.measured - row.expected;
        println!(
            "{}: {} {}, expected {}, off by {off:+.1e} of {:.1e}",
            row.quantity, row.measured, row.unit, row.expected, row.tolerance
        );
    }
    rows
}

fn failing(rows: &[Row]) -> Vec<&str> {
    rows.iter().filter(|row| !row.passes()).map(|row| row.quantity.as_str()).collect()
}

/// One test per check; none is left out, and those that take long are ignored.
macro_rules! checks {
    ($($(#[$meta:meta])? $test:ident: $name:literal),+ $(,)?) => {
        $(
            #[test]
            $(#[$meta])?
            fn $test() {
                let rows = rows($name, &support::gpu());
                assert!(failing(&rows).is_empty(), "{:?}", failing(&rows));
            }
        )+

        #[test]
        fn every_check_has_its_test() {
            let names: Vec<_> = CHECKS.iter().map(|check| check.name).collect();
            assert_eq!(names, [$($name),+]);
        }
    };
}

checks! {
    kernels_are_normalised: "kernels",
    lattices_have_their_density: "lattices",
    wind_enters_and_roots_move: "wind",
    strands_fall_and_drift_as_drag_says: "drag",
    fields_blow_as_they_say: "force-fields",
    what_is_pushed_falls: "set-force",
    density_error_falls_as_jacobi_should: "density",
    curled_strands_keep_their_shape: "rods-rest",
    strands_hang_like_elastica_and_helix: "rods-static",
    beams_vibrate_at_their_frequency: "rods-beam",
    loose_strands_fall: "rods-fall",
    bodies_keep_hair_and_air_out: "contact",
    rotations_have_twice_their_rate: "rotation",
    translations_change_nothing: "translation",
    cut_filters_leak: "filter-leak",
    the_filter_has_the_hats_gain: "filter-gain",
    confinement_has_its_gain: "confinement",
    vortices_last_and_feed_their_band: "vortex",
    shear_waves_decay_as_xsph_says: "shear-wave",
    taylor_green_vortices_decay: "taylor-green",
    pressure_keeps_what_an_ideal_fluid_keeps: "pressure",
    #[ignore = "long: 20 s of CPU time; tests/bodies.rs has air that flows around a ball"]
    air_knows_bodies: "bodies-in-air",
    momentum_is_kept: "momentum",
    what_air_loses_hair_receives: "coupled",
    hair_stands_where_physics_says: "hair-in-wind",
    hair_stands_right_in_air_that_it_slows: "hair-two-way",
    bent_hair_sheds_drag_and_limp_hair_is_straight: "hair-limits",
    hair_and_air_exchange_momentum: "exchange",
    strands_rub_as_coulomb_says: "friction",
    mats_sleep: "mat",
    passes_are_those_of_the_reference: "reference",
    rods_are_those_of_the_reference: "reference-rods",
    steps_are_those_of_the_reference: "reference-step",
}

/// A pass, a value of it by number, the factor on it where it is a float (`fault::plant`), the check that looks at it.
type Wrong = (&'static Pass, usize, f32, &'static str);

/// A value of a shader that is wrong by a little makes at least one row of the check that looks at it fail.
fn turn_rows_red(cases: &[Wrong]) {
    for &(pass, value, factor, check) in cases {
        let gpu = fault::plant(&support::gpu(), pass, value, factor);
        let rows = rows(check, &gpu);
        println!("{}: {:?}", pass.name, failing(&rows));
        assert!(!failing(&rows).is_empty(), "{} passes {check} with another value {value}", pass.name);
    }
}

#[test]
fn wrong_values_of_wind_turn_rows_red() {
    turn_rows_red(&[
        (&rods::DRAG, 0, 1.01, "drag"),                       // FORM
        (&rods::DRAG, 1, 1.002, "drag"),                      // FRICTION
        (&rods::REACT, 19, 1.01, "exchange"),                 // inverse mass of air
        (&forcing::FRINGE, 55, 1.01, "wind"),                 // RELAXATION
        (&forcing::MEAN_WIND, 16, 1.0, "wind"),               // 1 of the next step
        (&forcing::FIELD_STRENGTHS, 39, 1.0, "force-fields"), // 1 of the next step
        (&forcing::DRIVE_AIR, 20, 1.01, "force-fields"),      // rate of the uptake
        (&forcing::DRIVE_AIR, 36, 0.8, "force-fields"),       // where a field begins to fade
        (&rods::SAMPLE_FIELDS, 22, 1.01, "force-fields"),     // velocity of the fields
        (&forcing::PUSH_AIR, 9, 1.01, "set-force"),           // step
        (&rods::PUSH_HAIR, 12, 1.01, "set-force"),            // weight times acceleration
        (&rods::EXCLUDE_PUSH, 13, 0.99, "set-force"),         // step
    ]);
}

#[test]
#[ignore = "long: 36 s of CPU time"]
fn wrong_values_of_strands_turn_rows_red() {
    turn_rows_red(&[
        (&forcing::ROOTS, 182, 1.001, "wind"),      // part of the way between keyframes
        (&rods::SOLVE, 85, 0.99, "reference-rods"), // length of a segment along its axis
        (&rods::SOLVE, 391, 0.9, "momentum"),       // velocity of a loose strand's centre
        (&rods::DRAG_IMPULSE, 5, 1.01, "momentum"), // step
        (&rods::GAUSS_SEIDEL, 14, 1.01, "reference-rods"), // 1/4
        (&rods::PREDICT, 385, 1.0005, "reference-rods"), // 2/3 of BDF2
        (&rods::SOLVE, 1766, 1.01, "contact"),      // largest friction of a contact
        (&contact::AIR, 105, 1.0025, "contact"),    // CLEARANCE
        (&forcing::WALLS, 440, 0.5, "bodies-in-air"), // slope of the kernel
    ]);
}

#[test]
#[ignore = "long: 10 s of CPU time"]
fn wrong_values_of_air_turn_rows_red() {
    turn_rows_red(&[
        (&fluid::FRICTION, 39, 0.5, "friction"),          // coefficient of a strand
        (&fluid::DENSITY, 314, 0.997, "lattices"),        // 315 of the kernel
        (&fluid::CORRECT, 324, 0.67, "density"),          // 45 of the kernel's slope
        (&viscosity::XSPH, 39, 1.05, "shear-wave"),       // 4
        (&viscosity::XSPH, 221, 0.8, "shear-wave"),       // viscosity of unresolved eddies
        (&forcing::PREDICT, 14, 1.001, "reference-step"), // step
        (&turbulence::VORTICITY, 262, 1.002, "rotation"), // 45 of the kernel's slope
        (&turbulence::BAND, 25, 1.03, "reference"),       // 3 of the Mexican hat
        (&turbulence::DEPOSIT, 253, 1.001, "reference"),  // node beside a particle
        (&turbulence::SMOOTH_X, 8, 1.001, "reference"),   // a node's part of the Gaussian
        (&turbulence::SMOOTH_Y, 9, 1.001, "reference"),   // a node's part of the Gaussian
        (&turbulence::SMOOTH_Z, 14, 1.001, "reference"),  // a node's part of its curvature
        (&turbulence::GATHER, 108, 1.001, "reference"),   // weight of a B-spline
        (&turbulence::CONFINE, 75, 1.01, "confinement"),  // energy over its limit
        (&turbulence::CONFINE, 58, 1.01, "confinement"),  // 2 of the growth
        (&turbulence::CONFINE, 82, 1.01, "confinement"),  // square of what is left
        (&turbulence::CONFINE, 1, 1.01, "confinement"),   // LARGEST
        (&turbulence::CONFINE, 49, 1.02, "confinement"),  // gain of the published law
    ]);
}
