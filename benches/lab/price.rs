//! Cost of turbulence: `cargo xtask bench price [--small] [--rounds N]`.
//!
//! Two bounds, on one adapter in one run: a step of fig3c (s = 18 mm) takes at most 1.05 times as long as one of fig2b
//! (6 mm), and all of turbulence at 6 mm at most 0.35 of its time by the direct sum cut at 3 s. Writes `price.csv`,
//! and fails where one is passed.

use std::time::Instant;

use windswept::PassReport;
use windswept_scene::{InitialState, Scene};
use windswept_validate::Sweep;

use crate::{Lab, Result, provenance, results, timing};

#[derive(clap::Args, Default)]
pub(crate) struct Arguments {
    /// The copies in examples/scenes/small instead of the paper's size
    #[arg(long)]
    small: bool,
    /// Turns in which a step of each scene is timed
    #[arg(long, default_value_t = 4)]
    rounds: u32,
}

const DIRECT: [&str; 2] = ["turbulence.filter=\"direct\"", "turbulence.cutoff=3.0"];
/// Scenes by name, with file and keys.
const SCENES: [(&str, &str, &[&str]); 3] = [
    ("fig2b, s = 6 mm", "fig2b.toml", &["time.substeps=1"]),
    ("fig3c, s = 18 mm", "fig3c.toml", &["time.substeps=1"]),
    ("fig2b, direct sum cut at 3 s", "fig2b.toml", &["time.substeps=1", DIRECT[0], DIRECT[1]]),
];

pub(crate) fn run(lab: &Lab, Arguments { small, rounds }: &Arguments) -> Result<()> {
    let started = Instant::now();
    let folder = if *small || lab.quick { "small/" } else { "" };
    let of = |(_, file, keys): &(_, &str, &[&str])| -> Result<(Scene, InitialState)> {
        let keys: Vec<String> = keys.iter().map(|key| (*key).to_owned()).collect();
        let scene = timing::scene(&format!("{folder}{file}"), &keys)?;
        let initial = InitialState::new(&scene)?;
        Ok((scene, initial))
    };
    let scenes = SCENES.iter().map(of).collect::<Result<Vec<_>>>()?;
    let times = timing::by_turns(&lab.gpu, &scenes, lab.rounds(*rounds))?;
    // Of turbulence are its stage, and the sort into the grid's cells.
    let is_turbulence = |row: &&PassReport| row.band.is_some() || row.stage == "turbulence";
    let sum = |rows: &mut dyn Iterator<Item = &PassReport>| rows.map(|row| row.ms).sum::<f64>();
    let [steps, turbulence] = [
        times.iter().map(|passes| sum(&mut passes.iter())).collect::<Vec<_>>(),
        times.iter().map(|passes| sum(&mut passes.iter().filter(is_turbulence))).collect(),
    ];
    let mut of_step = Sweep::new("step", f64::INFINITY, "ms");
    let mut of_turbulence = Sweep::new("turbulence", f64::INFINITY, "ms");
    for (k, (name, ..)) in SCENES.iter().enumerate() {
        of_step.add(*name, "", f64::NAN, steps[k]);
        of_turbulence.add(*name, "", f64::NAN, turbulence[k]);
    }
    // Both scenes have the same passes except for turbulence; those count as in the first scene, so that noise in them
    // is not taken for turbulence.
    let coarse = (steps[0] - turbulence[0] + turbulence[1]) / steps[0];
    let bounds = [
        ("step at 18 mm over step at 6 mm", 1.05, coarse),
        ("turbulence at 6 mm over that by the direct sum cut at 3 s", 0.35, turbulence[0] / turbulence[2]),
    ];
    let ratios = bounds.map(|(words, bound, ratio)| {
        let mut sweep = Sweep::new(words, bound, "");
        sweep.add("", "", f64::NAN, ratio);
        sweep
    });
    let holds = ratios.iter().all(|sweep| sweep.failing().count() == 0);
    let all: Vec<Sweep> = [of_step, of_turbulence].into_iter().chain(ratios).collect();
    for row in all.iter().flat_map(|sweep| &sweep.rows) {
        println!("{} {}: {}, at most {}", row.quantity, row.series, results::measured(row), results::bound(row));
    }
    if lab.quick {
        return Ok(());
    }
    let mut head = vec![format!("What turbulence costs (cargo xtask bench price), scenes in examples/scenes/{folder}")];
    head.extend(provenance::lines(&lab.gpu, started.elapsed().as_secs_f64()));
    head.push(format!("ms: of each pass the least of {rounds} timed steps, by turns"));
    let name = if *small { "price_small.csv" } else { "price.csv" };
    results::write(&lab.out.join(name), &head, &all)?;
    if holds { Ok(()) } else { Err("turbulence costs too much".into()) }
}
