//! `hair.stiffness`: strands that are stiffer in one part than in another.

use windswept_reference::{Parameters, State, step::step};
use windswept_scene::{InitialState, Scene};

const LENGTH: f64 = 0.15;
/// γ = ρAgL³/EI: so small that a cantilever bends little.
const GAMMA: f64 = 0.05;

/// Drop of the tip of a level strand at rest under its weight \[lengths\], with this `hair.stiffness`.
fn drop(stiffness: &str) -> f64 {
    let radius: f64 = 4e-5;
    let youngs_modulus = 1320.0 * 9.81 * LENGTH.powi(3) / (0.25 * GAMMA * radius * radius);
    let text = format!(
        "interaction.model = \"none\"
        rods = {{ sleep = false }}
        time = {{ step = 1e-3, duration = 2 }}
        [hair]
        strands = 1
        points = 41
        length = {LENGTH}
        radius = {radius:e}
        youngs_modulus = {youngs_modulus:e}
        {stiffness}
        roots = {{ shape = \"disc\", center = [0, 0, 0], radius = 0.01, direction = [1, 0, 0] }}"
    );
    let scene = Scene::parse(&text).unwrap().check().unwrap();
    let initial = InitialState::new(&scene).unwrap();
    let p = Parameters::new(&scene, &initial);
    let mut state = State::new(&initial, p.step);
    for _ in 0..2000 {
        step(&mut state, &p).unwrap();
        state.velocity.iter_mut().chain(&mut state.angular_velocity).for_each(|v| *v *= 1.0 - 40.0 * p.step);
    }
    (state.position[0] - state.position[40]).y / LENGTH
}

/// Drop of the tip of a cantilever by Euler-Bernoulli \[lengths\]: ∫ (L - x) M / EI dx, of M = ρAg (L - x)²/2.
fn exact(factor: impl Fn(f64) -> f64) -> f64 {
    let parts = 100_000;
    let part = |k: i32| (f64::from(k) + 0.5) / f64::from(parts);
    (0..parts).map(|k| (1.0 - part(k)).powi(3) / factor(part(k))).sum::<f64>() / f64::from(parts) * 0.5 * GAMMA
}

#[test]
fn a_cantilever_of_two_stiffnesses_bends_as_beam_theory_says() {
    let even = drop("");
    assert!((exact(|_| 1.0) / (GAMMA / 8.0) - 1.0).abs() < 1e-6);
    // From four times as stiff to as stiff between joint 20 and joint 21.
    let halves = (drop("stiffness = [[0.505, 4], [0.52, 1]]"), exact(|x| if x < 0.5125 { 4.0 } else { 1.0 }));
    let sloping = (drop("stiffness = [[0, 4], [0.3, 1]]"), exact(|x| 4.0 - 10.0 * x.min(0.3)));
    for (name, (found, expected)) in [("even", (even, GAMMA / 8.0)), ("halves", halves), ("sloping", sloping)] {
        let off = (found / expected - 1.0).abs();
        println!("{name}: {found:.6} L, {expected:.6} L: {off:.1e} off");
        assert!(off < 3e-3, "{name}: {found} L, expected {expected} L");
    }
    assert!(halves.0 < 0.4 * even && sloping.0 < 0.6 * even, "{halves:?} {sloping:?}");
}
