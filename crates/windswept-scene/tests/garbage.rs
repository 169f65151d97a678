//! Whatever a file or a `--set` holds: a scene or an error, never a panic, and never a stack that ends.

use crate::common::{self, QUICK};
use proptest::prelude::*;
use windswept_scene::{InitialState, Scene};

/// Stacks of 2 MiB end before this.
const DEEP: usize = 100_000;

/// The error of a scene that must not parse, and its text is no novel.
fn refused(text: &str, sets: &[String]) -> String {
    let shown = Scene::parse_with("deep.toml", text, sets).unwrap_err().to_string();
    let named: String = sets.iter().map(|set| format!("--set {set}")).collect();
    assert!(shown.len() < named.len() + 400, "{} bytes", shown.len());
    shown
}

#[test]
fn deep_nesting_is_an_error() {
    for text in [
        format!("title = {}", "[".repeat(DEEP)),
        format!("title = {}{}", "[".repeat(DEEP), "]".repeat(DEEP)),
        format!("title = {}", "{a=".repeat(DEEP)),
        format!("time{} = 1", ".a".repeat(DEEP)),
        format!("[time{}]", ".a".repeat(DEEP)),
        format!("[[time{}]]", ".a".repeat(DEEP)),
    ] {
        assert!(refused(&text, &[]).contains("not TOML"));
    }
    assert!(refused(QUICK, &[format!("time{}=1", ".a".repeat(DEEP))]).contains("leads nowhere"));
    assert!(refused(QUICK, &[format!("time={}", "[".repeat(DEEP))]).contains("not a TOML value"));
    assert!(refused(&format!("title = [{}]", "1,".repeat(DEEP)), &[]).contains("found [1, 1"));
    assert!(refused(&format!("{} = 1", "a".repeat(DEEP)), &[]).contains("unknown key"));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1000, ..ProptestConfig::default() })]

    #[test]
    fn any_text(text in "\\PC{0,200}|[\\[\\]{}=.,\"'#\n a-z0-9-]{0,200}") {
        if let Err(error) = common::parse(&text) {
            prop_assert!(error.span().is_none_or(|span| span.end <= text.len() + 1), "{error}");
            prop_assert!(!error.to_string().is_empty());
        }
    }

    #[test]
    fn any_assignment(set in "(time|hair|air|rods|fluid)?[a-z._0-9\"]{0,20}=.{0,12}") {
        let _ = common::parse_with("quick.toml", QUICK, &[set]).map_err(|error| error.to_string());
    }

    /// Any number for any key that takes one: refused, or a state that f32 can hold.
    #[test]
    fn any_number(
        key in prop::sample::select(vec![
            "hair.length", "hair.radius", "hair.density", "hair.point_mass", "hair.fibres_per_strand",
            "hair.youngs_modulus", "hair.roots.radius", "air.rest_density", "air.spacing", "air.kernel_radius",
            "air.fringe", "air.ramp", "time.step", "time.duration", "time.frame_rate", "hair.curl.pitch",
        ]),
        sign in prop::sample::select(vec!["", "-"]),
        exponent in -40..40_i32,
    ) {
        let curl = "hair.curl={radius=0.01,pitch=0.03}".to_owned();
        // No air: up to 100 million particles are allowed, and take a while.
        let sets = [curl, "interaction.model=none".to_owned(), format!("{key}={sign}1e{exponent}")];
        if let Ok(scene) = common::parse_with("quick.toml", QUICK, &sets)
            && let Ok(state) = InitialState::new(&scene)
        {
            let hair = &state.hair;
            prop_assert!(hair.positions.iter().all(|x| x.as_vec3().is_finite()));
            prop_assert!(hair.orientations.iter().all(|q| (q.length() - 1.0).abs() < 1e-9));
            prop_assert!(hair.inverse_mass.iter().all(|w| (*w as f32).is_finite()));
            prop_assert!(hair.bend_compliance.iter().all(|c| c.as_vec3().is_finite()));
        }
    }
}
