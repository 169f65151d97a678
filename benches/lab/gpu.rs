//! Times of the passes on a GPU: `cargo xtask bench gpu [--bandwidth GB/S] [--operations TFLOP/S]`.
//!
//! Checks the adapter first (`windswept validate`, all of it), then times the paper's scenes and one of two million
//! particles, each at one substep, and sets each pass beside the least time in which its arrays could cross the memory,
//! and beside that in which its operations could be done. Writes `gpu-ADAPTER.json`.

use std::{fs, time::Instant};

use serde_json::{Value, json};
use windswept::{
    Gpu, PlanRow, Simulation,
    gpu::wgpu::CommandEncoderDescriptor,
    internals::clusters::{Cluster, Seen},
};
use windswept_shaders::common::lanes::LANES;
use windswept_validate::{CHECKS, Row};

use crate::{
    Lab, Result, provenance,
    step::{self, Setting},
};

/// Scenes of `bench step` that are timed beside those of [`step::of_strands`], and that of a quick run.
const SCENES: [&str; 3] = ["fig2b", "fig3c", "2 million particles"];
const SMALL: [&str; 1] = ["quick"];
/// Goals for a step on an H100 or H200 \[ms\].
const GOALS: [(&str, f64); 5] = [
    ("fig2b", 1.0),
    ("2 million particles", 5.5),
    ("10 000 x 25, drag", 1.0),
    ("50 000 x 25, drag", 4.0),
    ("10 000 x 25, two-way, head", 8.0),
];
/// Frames of a second that are shown at true speed.
const FRAME_RATE: f64 = 60.0;

#[derive(clap::Args, Default)]
pub(crate) struct Arguments {
    /// Peak bandwidth of the adapter's memory, as its maker states it [GB/s]; without it no pass is set beside it
    #[arg(long, value_name = "GB/S")]
    bandwidth: Option<f64>,
    /// Peak rate of operations on f32 of the adapter, as its maker states it [TFLOP/s]; without it no pass is set
    /// beside it
    #[arg(long, value_name = "TFLOP/S")]
    operations: Option<f64>,
    /// Steps of each scene that are timed pass by pass, and as many that are timed as a whole
    #[arg(long, default_value_t = 20)]
    steps: u64,
    /// Scenes of `bench step` to time, with ; between them [default: the paper's, of two million particles and of 10
    /// 000 to 100 000 strands]
    #[arg(long, value_name = "NAME", value_delimiter = ';')]
    scenes: Vec<String>,
    /// Leave the checks out
    #[arg(long)]
    unchecked: bool,
}

impl Arguments {
    /// Adds the parts of the peak rates that so many bytes and operations in a time \[ms\] are.
    fn add_parts(&self, of: &mut Value, bytes: u64, operations: u64, ms: f64) {
        if let Some(peak) = self.bandwidth {
            // GB/s are bytes per nanosecond: 1e6 of them a millisecond.
            of["of_peak_bandwidth"] = (bytes as f64 / (peak * 1e6) / ms).into();
        }
        if let Some(peak) = self.operations {
            // TFLOP/s are 1e9 operations a millisecond.
            of["of_peak_operations"] = (operations as f64 / (peak * 1e9) / ms).into();
        }
    }
}

pub(crate) fn run(lab: &Lab, arguments: &Arguments) -> Result<()> {
    let checked = if arguments.unchecked || lab.quick { Value::Null } else { check(&lab.gpu)? };
    let named = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
    let scenes = match (&arguments.scenes[..], lab.quick) {
        ([], true) => step::scenes(&named(&SMALL))?,
        ([], false) => [step::scenes(&named(&SCENES))?, step::of_strands()].concat(),
        (names, _) => step::scenes(names)?,
    };
    let scenes: Vec<_> = scenes.iter().map(|setting| measure(lab, setting, arguments)).collect::<Result<_>>()?;
    let mut document = json!({
        "command": std::env::args().skip(1).collect::<Vec<_>>().join(" "),
        "operations": "those on f32 in the text of a pass (windswept_shaders::Operations), with the neighbours that there are; `more` where \
                       loops of which nobody knows the turns count once",
        "bytes": "each array that a pass reads, once as a whole, and each that it writes, once (PlanRow::bytes)",
        "scenes": scenes,
    });
    for (name, value) in provenance::now(&lab.gpu) {
        document[name] = value.into();
    }
    // Peak rates that no flag gives and checks that were not run are left out.
    if let Some(bandwidth) = arguments.bandwidth {
        document["peak_bandwidth_gb_per_s"] = bandwidth.into();
    }
    if let Some(operations) = arguments.operations {
        document["peak_tflop_per_s"] = operations.into();
    }
    if !checked.is_null() {
        document["validate"] = checked;
    }
    if !lab.quick {
        let name = lab.gpu.info().name.to_lowercase();
        let words: Vec<_> = name.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty()).collect();
        fs::create_dir_all(&lab.out)?;
        let path = lab.out.join(format!("gpu-{}.json", words.join("-")));
        fs::write(&path, serde_json::to_string_pretty(&document)? + "\n")?;
        println!("written: {}", path.display());
    }
    Ok(())
}

/// How many rows of `windswept validate` pass; an error names those that do not.
fn check(gpu: &Gpu) -> Result<Value> {
    let rows: Vec<Row> = CHECKS.iter().flat_map(|check| check.rows(gpu)).collect();
    let failing: Vec<&str> = rows.iter().filter(|row| !row.passes()).map(|row| row.quantity.as_str()).collect();
    if !failing.is_empty() {
        return Err(format!("the adapter computes wrongly, and is not timed: {}", failing.join("; ")).into());
    }
    println!("{} of {} checks pass", rows.len(), rows.len());
    Ok(json!({ "rows": rows.len(), "passed": true }))
}

fn measure(lab: &Lab, setting: &Setting, arguments: &Arguments) -> Result<Value> {
    let (scene, mut timed) = setting.timed(lab)?;
    let name = &setting.name;
    let goal = GOALS.iter().find(|goal| goal.0 == name).map(|goal| goal.1);
    let plan = windswept::plan(&scene.check()?)?;
    let steps = lab.rounds(arguments.steps);
    let mut passes = Vec::new();
    let (mut gpu_ms, mut all_bytes, mut all_operations) = (0.0, 0, 0);
    let rows = timed.steps(steps)?;
    let clusters = timed.simulation.engine().clusters()?;
    let hair_points = timed.simulation.engine().sizes().hair_points;
    let hair_clusters = timed.simulation.engine().sizes().hair_clusters;
    for row in rows {
        let same = |other: &&PlanRow| (other.pass, other.label, other.band) == (&row.pass, &row.name, row.band);
        let Some(planned) = plan.iter().find(same) else { continue };
        let is_met = |cluster: &&Cluster| match cluster.particles[0] < hair_points {
            true => planned.clusters.start < hair_clusters,
            false => planned.clusters.end > hair_clusters,
        };
        let (bytes, operations) = (planned.bytes, operations(planned, clusters.iter().filter(is_met)));
        gpu_ms += row.ms;
        all_bytes += bytes;
        all_operations += operations;
        let mut pass = json!({
            "pass": row.pass, "name": row.name, "runs": row.runs, "ms": row.ms, "bytes": bytes,
            "operations": operations, "more": planned.operations.more,
        });
        if let Some(band) = row.band {
            pass["band"] = band.into();
        }
        arguments.add_parts(&mut pass, bytes, operations, row.ms);
        passes.push(pass);
    }
    let walls = timed.walls(steps)?;
    let (on_the_gpu, of_the_host) = on_the_gpu(&lab.gpu, &mut timed.simulation, steps)?;
    let started = Instant::now();
    timed.simulation.step(steps)?;
    let in_a_row = started.elapsed().as_secs_f64() * 1e3 / steps as f64;
    let (least, median) = (walls[0], walls[walls.len() / 2]);
    let particles = timed.simulation.engine().sizes().particles;
    let dispatches: u32 = plan.iter().filter(|row| row.skipped.is_none()).map(|row| row.runs).sum();
    // Of a simulation that runs on, without pictures.
    let frames_per_second = 1e3 / (in_a_row / (FRAME_RATE * timed.simulation.dt()));
    let beside = goal.map_or_else(String::new, |goal| format!(" (goal on an H100: {goal} ms)"));
    println!(
        "{name}: {particles} particles, {dispatches} dispatches, passes {gpu_ms:.3} ms, a step by itself {median:.3} ms \
         (least {least:.3}), in a row {in_a_row:.3} ms or {frames_per_second:.1} frames a second, \
         on the GPU {on_the_gpu:.3} ms{beside}, encoded in {of_the_host:.3} ms"
    );
    let mut of_scene = json!({
        "name": name,
        "particles": particles,
        "dispatches_of_a_step": dispatches,
        "frames_per_second": frames_per_second,
        "memory_bytes": timed.simulation.engine().memory_bytes(),
        "ms_of_passes": gpu_ms,
        "ms_of_a_step_median": median,
        "ms_of_a_step_least": least,
        "ms_of_a_step_in_a_row": in_a_row,
        "ms_of_a_step_on_the_gpu": on_the_gpu,
        "ms_to_encode_a_step": of_the_host,
        "bytes": all_bytes,
        "operations": all_operations,
        "passes": passes,
    });
    if let Some(goal) = goal {
        of_scene["goal_ms"] = goal.into();
    }
    arguments.add_parts(&mut of_scene, all_bytes, all_operations, gpu_ms);
    Ok(of_scene)
}

/// Times that the neighbour list may grow while steps are timed.
const ATTEMPTS: u32 = 4;

/// Time of a step on the GPU, of many that are encoded and submitted together and run without timers, and time in which
/// the host encodes it \[ms\].
fn on_the_gpu(gpu: &Gpu, simulation: &mut Simulation, steps: u64) -> Result<(f64, f64)> {
    let ms_each = |from: Instant, to: Instant| (to - from).as_secs_f64() * 1e3 / steps as f64;
    for _ in 0..ATTEMPTS {
        let before = simulation.steps();
        let started = Instant::now();
        let mut encoder = gpu.device().create_command_encoder(&CommandEncoderDescriptor::default());
        simulation.encode_steps(&mut encoder, steps);
        let commands = encoder.finish();
        let encoded = Instant::now();
        gpu.queue().submit([commands]);
        gpu.wait()?;
        let done = Instant::now();
        simulation.finish_steps()?;
        // Steps that froze, since the neighbour list has to grow, took no time.
        if simulation.steps() == before + steps {
            return Ok((ms_each(encoded, done), ms_each(started, encoded)));
        }
    }
    Err("the neighbour list grows again and again, as where air clumps; take fewer --steps".into())
}

/// Operations of a pass in a step: of its invocations, and of the batches of neighbours that these clusters have.
fn operations<'a>(row: &PlanRow, clusters: impl Iterator<Item = &'a Cluster>) -> u64 {
    let batch = |entries: &[Seen]| entries.len().div_ceil(LANES as usize) as u64;
    let each = row.operations;
    let of_cluster =
        |cluster: &Cluster| each.own_batch * batch(&cluster.own_kind) + each.other_batch * batch(&cluster.other_kind);
    let of_clusters: u64 = clusters.map(of_cluster).sum();
    each.invocation * row.invocations + u64::from(row.runs) * u64::from(LANES) * of_clusters
}
