//! A cut of `cargo xtask bench stress` on the software adapter: one or two settings of each stress.

use windswept_validate::stress::{Extent, STRESSES};

use crate::support;

fn assert_holds(name: &str) {
    let stress = STRESSES.iter().find(|stress| stress.name == name).unwrap_or_else(|| panic!("no stress {name}"));
    let sweeps = stress.sweeps(&support::gpu(), Extent::Cut);
    assert!(sweeps.iter().all(|sweep| !sweep.rows.is_empty()), "{name} measures nothing");
    for (sweep, worst) in sweeps.iter().zip(sweeps.iter().filter_map(|sweep| sweep.worst())) {
        println!("{}: {} {} of at most {}", sweep.quantity, worst.measured, worst.unit, worst.tolerance);
    }
    let failing: Vec<_> = sweeps.iter().flat_map(|sweep| sweep.failing()).collect();
    assert!(failing.is_empty(), "{failing:?}");
}

/// One test per stress; none is left out, and those that take long are ignored.
macro_rules! stresses {
    ($($(#[$meta:meta])? $test:ident: $name:literal),+ $(,)?) => {
        $(
            #[test]
            $(#[$meta])?
            fn $test() {
                assert_holds($name);
            }
        )+

        #[test]
        fn every_stress_has_its_test() {
            let names: Vec<_> = STRESSES.iter().map(|stress| stress.name).collect();
            assert_eq!(names, [$($name),+]);
        }
    };
}

stresses! {
    hair_rests_in_one_place_at_any_step: "steps",
    stiff_and_limp_strands_hang_as_chains_do: "stiffness",
    masses_may_be_far_apart: "masses",
    faulty_strands_are_refused_or_heal: "faulty strands",
    an_invalid_value_resets_its_strand: "invalid values",
    crowded_air_spreads: "crowded air",
    winds_may_change_at_once: "winds",
    roots_may_be_flung: "driven roots",
    bodies_may_be_fast: "bodies",
    dials_may_be_turned_too_far: "dials",
    sizes_may_be_absurd: "sizes",
    #[ignore = "long: 9000 steps, 30 s of CPU time"]
    long_runs_stay_as_they_are: "long run",
    #[ignore = "long: 9000 steps of two models, 35 s of CPU time"]
    other_long_runs_stay_as_they_are: "long runs of the other models",
    bits_are_the_same: "bits",
}
