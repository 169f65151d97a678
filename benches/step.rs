//! How long the stages of a step take, and the whole step: `cargo bench --bench step [-- FILTER]`.
//!
//! A group per stage, and one for the whole step; in each a line per size, over what the stage's work grows with. Times
//! are the adapter's own timestamps around the passes. `cargo test --bench step` runs each line once, those of large
//! scenes left out. Scenes draw with the fixed seed of their file.
#![allow(clippy::unwrap_used)] // a bench that cannot run ends

use std::{cell::RefCell, collections::BTreeMap, env, time::Duration};

use criterion::{BenchmarkId, Criterion, Throughput};
use windswept::{AdapterChoice, Gpu};

#[path = "timed/mod.rs"]
mod timed;
use timed::{Timed, scene};

/// A size, with the reason why it is one.
struct Size {
    name: &'static str,
    file: &'static str,
    keys: &'static [&'static str],
    /// Whether a step of it takes so long that `cargo test` leaves it out.
    large: bool,
}

/// A ball among the hair, so that stage `contact` has something to do.
const BALL: &str = "body=[{name='ball',center=[0.07,0.06,0.035],radius=0.01}]";
const ALONE: &str = "interaction.model=none";

/// Everything runs, over numbers of particles.
const PARTICLES: &[Size] = &[
    // The scene that a newcomer runs; what it works on stays in a CPU's cache.
    Size { name: "60 x 11 in 11 550 air", file: "quick.toml", keys: &[BALL], large: false },
    // The next size up: a box of eight times the volume, with as much hair in proportion.
    Size {
        name: "480 x 11 in 92 000 air",
        file: "quick.toml",
        keys: &[BALL, "air.box.max=[0.32,0.24,0.14]", "hair.strands=480"],
        large: true,
    },
    // The paper's size, without a body.
    Size { name: "550 x 35 in 203 000 air (fig2b)", file: "fig2b.toml", keys: &[], large: true },
];

/// Hair alone, over strands and points: the rods' passes are one invocation per strand, as long as its points.
const STRANDS: &[Size] = &[
    // One workgroup.
    Size { name: "64 x 11", file: "quick.toml", keys: &[ALONE, "hair.strands=64"], large: false },
    // One workgroup of strands that are eight times as long.
    Size {
        name: "64 x 88",
        file: "quick.toml",
        keys: &[ALONE, "hair.strands=64", "hair.points=88", "time.substeps=8"],
        large: false,
    },
    // The paper's.
    Size { name: "550 x 35", file: "fig2b.toml", keys: &[ALONE], large: false },
    // As many strands as fill a GPU.
    Size {
        name: "10 000 x 13",
        file: "quick.toml",
        keys: &[ALONE, "hair.strands=10000", "hair.points=13"],
        large: true,
    },
];

/// Eddies over scales: the filter's grid is coarser for larger ones by as much as its smoothing reaches farther.
const SCALES: &[Size] = &[
    // The smallest eddies of the paper's figures; its largest; and both at once, on a grid each.
    Size { name: "6 mm", file: "quick.toml", keys: &["turbulence.scale=0.006"], large: false },
    Size {
        name: "18 mm",
        file: "quick.toml",
        keys: &["turbulence={bands=[{scale=0.018,strength=3,intensity=0.3}]}"],
        large: false,
    },
    Size {
        name: "6 and 18 mm",
        file: "quick.toml",
        keys: &["turbulence={bands=[{scale=0.006,strength=3,intensity=0.3},{scale=0.018,strength=3,intensity=0.3}]}"],
        large: false,
    },
];

/// Sizes that each stage's work grows with.
const GROUPS: [(&str, &[Size]); 10] = [
    ("forcing", PARTICLES),
    ("neighbours", PARTICLES),
    ("fluid", PARTICLES),
    ("rods", STRANDS),
    ("contact", PARTICLES),
    ("velocity", PARTICLES),
    ("turbulence", SCALES),
    ("viscosity", PARTICLES),
    ("commit", PARTICLES),
    (WHOLE, PARTICLES),
];

const WHOLE: &str = "whole step";

fn main() {
    let gpu = Gpu::new(&AdapterChoice::from_flag(None)).unwrap();
    println!("adapter: {}", gpu.info());
    // `cargo bench` passes it, `cargo test` does not.
    let measures = env::args().any(|word| word == "--bench");
    let mut criterion = Criterion::default().configure_from_args();
    let simulations = RefCell::new(BTreeMap::new());
    for (stage, sizes) in GROUPS {
        let mut group = criterion.benchmark_group(stage);
        // A step of the paper's size takes a second on a software adapter.
        group.sample_size(10).warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(3));
        for size in sizes.iter().filter(|size| measures || !size.large) {
            // A scene without a body has nothing under stage `contact`.
            if stage == "contact" && !size.keys.contains(&BALL) {
                continue;
            }
            let scene = scene(size.file, size.keys).unwrap();
            let particles = windswept_scene::InitialState::new(&scene).unwrap();
            let elements = particles.hair.positions.len() + particles.air.positions.len();
            group.throughput(Throughput::Elements(elements as u64));
            group.bench_function(BenchmarkId::from_parameter(size.name), |bencher| {
                bencher.iter_custom(|n| {
                    let mut simulations = simulations.borrow_mut();
                    // One at a time: the largest takes most of the memory of a small GPU.
                    if !simulations.contains_key(size.name) {
                        simulations.clear();
                        simulations.insert(size.name, Timed::new(&gpu, &scene).unwrap());
                    }
                    let rows = simulations.get_mut(size.name).unwrap().steps(n).unwrap();
                    let asked = rows.iter().filter(|row| stage == WHOLE || row.stage == stage);
                    Duration::from_secs_f64(asked.map(|row| row.ms).sum::<f64>() * 1e-3)
                });
            });
        }
        group.finish();
    }
    criterion.final_summary();
}
