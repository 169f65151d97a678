//! Every check of `windswept validate` on the software adapter, and wrong shaders that make its rows fail.
#![allow(clippy::unwrap_used, missing_docs)]

mod support;

use windswept::{Gpu, internals::with_sources};
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

/// A pass, what its text has, what stands there instead, and the check that looks at it.
type Wrong = (&'static Pass, &'static str, &'static str, &'static str);

/// A wrong constant in a shader makes at least one row of the check that looks at it fail.
fn turn_rows_red(cases: &[Wrong]) {
    for &(pass, right, wrong, check) in cases {
        assert!(pass.source.contains(right), "{} has no {right:?}:\n{}", pass.name, pass.source);
        let gpu = with_sources(&support::gpu(), [(pass.name, pass.source.replace(right, wrong))]);
        let rows = rows(check, &gpu);
        println!("{} with {wrong}: {:?}", pass.name, failing(&rows));
        assert!(!failing(&rows).is_empty(), "{} with {wrong} passes {check}", pass.name);
    }
}

#[test]
fn wrong_constants_of_wind_turn_rows_red() {
    turn_rows_red(&[
        (&rods::DRAG, "FORM: f32 = 10.0", "FORM: f32 = 10.1", "drag"),
        (&rods::DRAG, "FRICTION: f32 = 5.4", "FRICTION: f32 = 5.41", "drag"),
        (&rods::REACT, "params.air_inverse_mass * own.w", "1.01 * params.air_inverse_mass * own.w", "exchange"),
        (&forcing::FRINGE, "RELAXATION: f32 = 10.0", "RELAXATION: f32 = 10.1", "wind"),
        (&forcing::MEAN_WIND, "status.step + 1u", "status.step + 2u", "wind"),
        (&forcing::FIELD_STRENGTHS, "status.step + 1u", "status.step + 2u", "force-fields"),
        (
            &forcing::DRIVE_AIR,
            "-force_field_velocity.rate * params.step",
            "-1.01 * force_field_velocity.rate * params.step",
            "force-fields",
        ),
        (&forcing::DRIVE_AIR, "smoothstep(0.5", "smoothstep(0.4", "force-fields"),
        (
            &rods::SAMPLE_FIELDS,
            "field_velocity_at(air.position).wind",
            "1.01 * field_velocity_at(air.position).wind",
            "force-fields",
        ),
        (&forcing::PUSH_AIR, "params.step * pushed", "1.01 * params.step * pushed", "set-force"),
        (&rods::PUSH_HAIR, "/ w * pushed[p].xyz", "/ w * 1.01 * pushed[p].xyz", "set-force"),
        (&rods::EXCLUDE_PUSH, "params.step * rod_points", "0.99 * params.step * rod_points", "set-force"),
    ]);
}

#[test]
#[ignore = "long: 36 s of CPU time"]
fn wrong_constants_of_strands_turn_rows_red() {
    turn_rows_red(&[
        (&forcing::ROOTS, "part * key.displacement", "1.001 * part * key.displacement", "wind"),
        (&rods::SOLVE, "l * axes[2] + now.strain", "0.99 * l * axes[2] + now.strain", "reference-rods"),
        (&rods::SOLVE, "momentum.xyz / momentum.w", "vec3f(1e-6)", "momentum"),
        (&rods::DRAG_IMPULSE, "params.step * (point.force", "1.01 * params.step * (point.force", "momentum"),
        (&rods::GAUSS_SEIDEL, "w = 0.25", "w = 0.252", "reference-rods"),
        (&rods::PREDICT, "params.step * (2.0 / 3.0)", "params.step * 0.667", "reference-rods"),
        (&rods::SOLVE, "mu * before.lag", "1.01 * mu * before.lag", "contact"),
        (&contact::AIR, "CLEARANCE: f32 = 0.4", "CLEARANCE: f32 = 0.401", "contact"),
        (&forcing::WALLS, "30.0 / params", "15.0 / params", "bodies-in-air"),
    ]);
}

#[test]
fn wrong_constants_of_air_turn_rows_red() {
    turn_rows_red(&[
        (&fluid::FRICTION, "min(own.friction, other.more.y)", "0.5 * own.friction", "friction"),
        (&fluid::DENSITY, "315.0", "314.0", "lattices"),
        (&fluid::CORRECT, "45.0", "30.0", "density"),
        (&viscosity::XSPH, "4.0 * mass", "4.2 * mass", "shear-wave"),
        (&viscosity::XSPH, "params.viscosity_eddies *", "0.8 * params.viscosity_eddies *", "shear-wave"),
        (&forcing::PREDICT, "params.step *", "1.001 * params.step *", "reference-step"),
        (&turbulence::VORTICITY, "45.0", "45.1", "rotation"),
        (&turbulence::BAND, "3.0 ", "3.1 ", "reference"),
        (&turbulence::DEPOSIT, "t.y - 1.0", "t.y - 1.001", "reference"),
        (&turbulence::SMOOTH_X, "spread(value, gauss)", "1.001 * spread(value, gauss)", "reference"),
        (&turbulence::SMOOTH_Y, "spread(value, gauss)", "1.001 * spread(value, gauss)", "reference"),
        (&turbulence::SMOOTH_Z, "value.xyz, curve", "value.xyz, 1.001 * curve", "reference"),
        (&turbulence::GATHER, "0.11, 0.09", "0.11, 0.0901", "reference"),
        (&turbulence::CONFINE, "part * part", "1.01 * part * part", "confinement"),
        (&turbulence::CONFINE, "2.0 * rate", "2.02 * rate", "confinement"),
        (&turbulence::CONFINE, "left * left", "1.01 * left * left", "confinement"),
        (&turbulence::CONFINE, "LARGEST: f32 = 0.5", "LARGEST: f32 = 0.505", "confinement"),
        (&turbulence::CONFINE, "rate * speed", "1.02 * rate * speed", "confinement"),
    ]);
}
