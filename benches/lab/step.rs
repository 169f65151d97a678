//! Times of the stages of a step: `cargo xtask bench step [SCENE…] [--steps N]`.
//!
//! Prints a line per scene and stage, `SCENE STAGE MS` with tabs between, the time of a step on the adapter's own
//! clock; and for each scene a line `wall`, the median time of a step on the host's clock, and a line `particles`.
//! `cargo xtask bench --compare` runs two builds of this program by turns.

use std::collections::BTreeMap;

use windswept::Simulation;
use windswept_scene::Scene;

use crate::{
    Lab, Result, asked,
    timing::{Timed, scene},
};

/// A ball among the hair, so that stage `contact` has something to do.
const BALL: &str = "body=[{name='ball',center=[0.07,0.06,0.035],radius=0.01}]";
const ALONE: &str = "interaction.model=none";

/// Scenes by name, with file and keys.
const SCENES: [(&str, &str, &[&str]); 16] = [
    // All of a step, small enough to stay in a CPU's cache.
    ("quick", "quick.toml", &["time.substeps=1"]),
    // The density constraint, the direct filter and Gauss-Seidel.
    ("published", "quick.toml", &["method=published", "time.substeps=1"]),
    // As many rods as the paper has.
    ("rods", "fig2b.toml", &[ALONE]),
    // The paper's scene at a size that no cache holds.
    ("fig2b small", "small/fig2b.toml", &["time.substeps=1"]),
    // The paper's size, at one substep as the peer's step.
    ("fig2b", "fig2b.toml", &["time.substeps=1"]),
    // Hair that the mean wind drags, and eddies three times as large.
    ("fig2a", "fig2a.toml", &["time.substeps=1"]),
    ("fig3c", "fig3c.toml", &["time.substeps=1"]),
    // Over particles: the scene that a newcomer runs, and a box of eight times the volume with as much hair in
    // proportion, each with a body.
    ("60 x 11 in 11 550 air", "quick.toml", &[BALL]),
    ("480 x 11 in 92 000 air", "quick.toml", &[BALL, "air.box.max=[0.32,0.24,0.14]", "hair.strands=480"]),
    // Over strands and points, as the work of the rods grows: one workgroup, and one of strands eight times as long; as
    // many strands as fill a GPU.
    ("64 x 11", "quick.toml", &[ALONE, "hair.strands=64"]),
    ("64 x 88", "quick.toml", &[ALONE, "hair.strands=64", "hair.points=88", "time.substeps=8"]),
    ("10 000 x 13", "quick.toml", &[ALONE, "hair.strands=10000", "hair.points=13"]),
    // Over scales of eddies: the filter's grid is coarser for larger ones by as much as its smoothing reaches farther;
    // both at once have a grid each.
    ("6 mm", "quick.toml", &["turbulence.scale=0.006"]),
    ("18 mm", "quick.toml", &["turbulence={bands=[{scale=0.018,strength=3,intensity=0.3}]}"]),
    (
        "6 and 18 mm",
        "quick.toml",
        &["turbulence={bands=[{scale=0.006,strength=3,intensity=0.3},{scale=0.018,strength=3,intensity=0.3}]}"],
    ),
    // The box has ten times the volume of fig2b's.
    ("2 million particles", "fig2b.toml", &["time.substeps=1", "air.box.max=[1.0,0.4,0.575]"]),
];
/// Numbers of strands, of 25 points each, in scenes where the time of a step grows with hair: in air that drags it
/// only, and in some million particles; from a disc, and from a head of life size on which it has settled.
const STRANDS: [&str; 3] = ["10 000", "50 000", "100 000"];
const IN_AIR: [(&str, &str, &[&str]); 4] = [
    ("drag", "fig2b.toml", &["time.substeps=1", "interaction.model=drag"]),
    ("drag, head", "looks.toml", &["time.settle=0.3"]),
    (
        "two-way",
        "fig2b.toml",
        &["time.substeps=1", "hair.roots.center=[0.15,0.2,0.2]", "hair.roots.radius=0.12", "air.box.max=[0.6,0.4,0.4]"],
    ),
    (
        "two-way, head",
        "looks.toml",
        &[
            "time.settle=0.3",
            "interaction.model=two-way",
            "air.spacing=0.006",
            "air.box={min=[-0.3,-0.35,-0.4],max=[0.3,0.25,0.2]}",
        ],
    ),
];
/// Scenes that run by default: between them they have every stage but contact, and are short.
const USUAL: [&str; 4] = ["quick", "published", "rods", "fig2b small"];

#[derive(clap::Args, Default)]
pub(crate) struct Arguments {
    /// Scenes to run [default: quick, published, rods, fig2b small]
    names: Vec<String>,
    /// Steps of each scene that are timed pass by pass, and as many that are timed as a whole
    #[arg(long, default_value_t = 4)]
    steps: u64,
}

/// A scene that is timed.
#[derive(Clone)]
pub(crate) struct Setting {
    pub(crate) name: String,
    file: &'static str,
    keys: Vec<String>,
}

impl Setting {
    /// A simulation of it that has gone its first steps.
    pub(crate) fn timed(&self, lab: &Lab) -> Result<(Scene, Timed)> {
        let scene = scene(self.file, &self.keys)?;
        Ok((scene.clone(), Timed::new(Simulation::new(&lab.gpu, &scene)?)?))
    }
}

/// The scene of a file with some keys changed.
fn setting(name: &str, file: &'static str, keys: &[&str]) -> Setting {
    Setting { name: name.to_owned(), file, keys: keys.iter().map(|key| (*key).to_owned()).collect() }
}

/// The scenes over numbers of strands.
pub(crate) fn of_strands() -> Vec<Setting> {
    let of = |strands: &str| {
        let count = format!("hair.strands={}", strands.replace(' ', ""));
        IN_AIR.map(|(air, file, keys)| {
            setting(&format!("{strands} x 25, {air}"), file, &[keys, &[&count, "hair.points=25"]].concat())
        })
    };
    STRANDS.iter().flat_map(|strands| of(strands)).collect()
}

/// The scenes of these names; all where there is none.
pub(crate) fn scenes(names: &[String]) -> Result<Vec<Setting>> {
    let all = [SCENES.iter().map(|(name, file, keys)| setting(name, file, keys)).collect(), of_strands()].concat();
    Ok(asked(&all, |scene| &scene.name, names)?.into_iter().cloned().collect())
}

pub(crate) fn run(lab: &Lab, Arguments { names, steps }: &Arguments) -> Result<()> {
    let usual: Vec<String> = lab.some(&USUAL).iter().map(|name| (*name).to_owned()).collect();
    let steps = lab.rounds(*steps);
    for setting in scenes(if names.is_empty() { &usual } else { names })? {
        let (name, (_, mut timed)) = (&setting.name, setting.timed(lab)?);
        let mut stages: BTreeMap<String, f64> = BTreeMap::new();
        for row in timed.steps(steps)? {
            *stages.entry(row.stage).or_default() += row.ms;
        }
        for (stage, ms) in &stages {
            println!("{name}\t{stage}\t{ms:.4}");
        }
        println!("{name}\twall\t{:.4}", timed.walls(steps)?[steps as usize / 2]);
        println!("{name}\tparticles\t{}", timed.simulation.engine().sizes().particles);
    }
    Ok(())
}
