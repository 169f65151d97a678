//! The commands that only look: `check`, `plan`, `adapters`.

use std::path::Path;

use windswept::{AdapterChoice, Gpu};
use windswept_export::{Followers, Schedule};
use windswept_scene::{CheckedForce, CheckedScene, InitialState, Scene};

use crate::arguments::{Changes, SceneOptions};
use crate::console::{Console, counted_frames};
use crate::failure::Failure;
use crate::groom::shown_box;
use crate::trial::Trial;

/// `windswept check`: the scene as it is understood, and the memory and the time that a run would take.
pub(crate) fn check(
    path: Option<&Path>,
    changes: &Changes,
    adapter: Option<&str>,
    pictures: bool,
    explain: bool,
    console: &mut Console<'_>,
) -> Result<(), Failure> {
    let read = |path| -> Result<(CheckedScene, InitialState), Failure> {
        let scene = changes.load(path)?;
        let initial = InitialState::new(&scene)?;
        Ok((scene, initial))
    };
    let read = path.map(read).transpose()?;
    if explain {
        console.print_lines(Scene::explain().trim_end());
    }
    let Some((scene, initial)) = read else { return Ok(()) };
    if explain {
        console.print("");
    }
    for (what, value) in summary(&scene, &initial)? {
        console.print(format_args!("{what:<9} {value}"));
    }
    for warning in initial.warnings.iter().cloned().chain(Schedule::warning(&scene.time)) {
        console.warn(warning);
    }
    // Last, as the first step may have to wait for the driver's compiler.
    let run = match Trial::run(&scene, initial, adapter, pictures) {
        Ok(trial) => trial.words(&scene),
        // The adapter that was asked for.
        Err(failure) if adapter.is_some() => return Err(failure),
        Err(failure) => format!("was not tried: {}", failure.why()),
    };
    console.print(format_args!("{:<9} {run}", "run"));
    Ok(())
}

/// `windswept check --schema`.
pub(crate) fn schema(console: &mut Console<'_>) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(&windswept_scene::schema());
    console.print_lines(&text.map_err(|error| Failure::Input(error.to_string()))?);
    Ok(())
}

fn summary(scene: &CheckedScene, initial: &InitialState) -> Result<Vec<(&'static str, String)>, Failure> {
    let schedule = Schedule::new(&scene.time, None);
    let (hair, air) = (&initial.hair, &initial.air);
    let mut rows = vec![("scene", scene.title.clone()), ("method", method(scene))];
    rows.push((
        "time",
        format!(
            "{} s: {} steps of {} ms{}, {}",
            scene.time.duration,
            schedule.steps(),
            scene.time.step * 1e3,
            if scene.time.substeps > 1 { format!(" in {} substeps", scene.time.substeps) } else { String::new() },
            counted_frames(schedule.frames()),
        ),
    ));
    let fibres: f64 = (0..hair.len()).map(|s| hair.fibres[hair.segments(s).start]).sum();
    rows.push((
        "hair",
        format!("{} strands that stand for {fibres:.0} fibres, {} points", hair.len(), hair.positions.len()),
    ));
    for (group, file) in (0..).zip(&scene.hair).filter_map(|(group, hair)| Some((group, hair.as_file()?))) {
        let name = Path::new(&file.file).file_name().unwrap_or_default().to_string_lossy().into_owned();
        rows.push(("groom", format!("{name}: {}", shown_box(hair.bounds(Some(group)).map(|x| x.to_array()), "m"))));
    }
    let all = Followers::number(scene, hair)?;
    if all > hair.len() {
        rows.push((
            "followers",
            format!("{all} hairs with the strands among them, for `windswept export --followers`"),
        ));
    }
    for (body, solid) in scene.bodies.iter().filter_map(|body| Some((body, body.shape.solid()?))) {
        let (grid, triangles) = (solid.grid(), solid.triangles().corners.len());
        rows.push((
            "mesh",
            format!(
                "{}: {triangles} triangles, holes covered: {}; {} distances {:.3} mm apart, {:.1} MB",
                body.name,
                solid.holes(),
                grid.counts.map(|count| count.to_string()).join(" x "),
                grid.spacing * 1e3,
                megabytes(4 * grid.values.len() as u64),
            ),
        ));
    }
    rows.push((
        "air",
        match (&scene.air, air.positions.len()) {
            (Some(_), 0) | (None, _) => "no particles".into(),
            (Some(settings), n) => format!(
                "{n} particles {:.3} mm apart in {} m, kernel radius {:.3} mm, {:.4} mg each",
                air.volume.cbrt() * 1e3,
                air.size.to_array().map(|side| format!("{side:.4}")).join(" x "),
                settings.kernel_radius * 1e3,
                air.mass * 1e6,
            ),
        },
    ));
    if let Some(settings) = &scene.air {
        rows.push((
            "wind",
            format!(
                "({}) m/s, over {} s{}",
                settings.wind.map(|u| u.to_string()).join(", "),
                settings.ramp,
                settings.follows.as_ref().map_or_else(String::new, |body| format!("; the box goes with {body}"))
            ),
        ));
    }
    if let Some(turbulence) = turbulence(scene) {
        rows.push(("turbulence", turbulence));
    }
    if !scene.forces.is_empty() {
        let field =
            |force: &CheckedForce| format!("{} ({}, {} m/s at most)", force.name, force.field.word(), force.fastest());
        rows.push(("forces", scene.forces.iter().map(field).collect::<Vec<_>>().join(", ")));
    }
    let bytes = windswept::memory_bytes(scene, initial)?;
    let memory = format!(
        "{:.1} MB on the GPU, on a software adapter at most {:.1} MB more for textures{}",
        megabytes(bytes.buffers),
        megabytes(bytes.textures),
        if bytes.grows { "; the neighbour list may grow" } else { "" }
    );
    rows.push(("memory", memory));
    Ok(rows)
}

/// Eddies of the air by size; `None` for air without any of its own.
fn turbulence(scene: &CheckedScene) -> Option<String> {
    let air = scene.air.as_ref().filter(|_| scene.interaction.model.has_air())?;
    let eddies = |scale: f64, intensity: f64| format!("{} mm of intensity {intensity}", 1e3 * scale);
    let strengthened = scene.turbulence.bands.iter().filter(|band| band.strength > 0.0);
    let strengthened: Vec<String> = strengthened.map(|band| eddies(band.scale, band.intensity)).collect();
    let strengthened =
        (!strengthened.is_empty()).then(|| format!("eddies of {} are strengthened", strengthened.join(", ")));
    let entering =
        air.inflow.map(|inflow| format!("eddies of {} enter with the wind", eddies(inflow.scale, inflow.intensity)));
    let rows: Vec<String> = [strengthened, entering].into_iter().flatten().collect();
    (!rows.is_empty()).then(|| rows.join("; "))
}

/// The method, and what is taken of it or instead of it.
fn method(scene: &CheckedScene) -> String {
    let model = scene.interaction.model;
    let air = if model.has_air() { format!(", air by {}", scene.fluid.solver.word()) } else { String::new() };
    let (solver, integrator) = (scene.rods.solver.word(), scene.rods.integrator.word());
    format!("{}: interaction {}{air}, rods by {solver} and {integrator}", scene.method.word(), model.word())
}

/// `windswept plan`: the passes of a step in order, under the step's stages.
pub(crate) fn plan(options: &SceneOptions, buffers: bool, console: &mut Console<'_>) -> Result<(), Failure> {
    let scene = options.load()?;
    let rows = windswept::plan(&scene)?;
    let width = |of: fn(&windswept::PlanRow) -> &str| rows.iter().map(|row| of(row).len()).max().unwrap_or(0);
    let (pass, label) = (width(|row| row.pass), width(|row| row.label));
    let mut stage = "";
    for row in &rows {
        if row.stage != stage {
            stage = row.stage;
            console.print(stage);
        }
        let does = match &row.skipped {
            Some(why) => format!("skipped: {why}"),
            None => {
                let (runs, invocations, moved) = (row.runs, row.invocations, megabytes(row.bytes));
                format!("runs {runs} x: {invocations} invocations, {moved:.2} MB")
            }
        };
        let band = row.band.map_or(String::new(), |band| format!(" (turbulence.bands.{band})"));
        console.print(format_args!("  {:<pass$}  {:<label$}  {does}{band}", row.pass, row.label));
        if buffers {
            let (reads, writes) = (row.uses.reads.join(", "), row.uses.writes.join(", "));
            console.print(format_args!("  {:<pass$}  reads {reads} → writes {writes}", ""));
        }
    }
    let all = windswept::buffers(&scene)?;
    if buffers {
        print_buffers(&all, console);
    }
    print_totals(&rows, all, console);
    Ok(())
}

/// Number of buffers that are named as the largest.
const LARGEST: usize = 5;

/// Prints the memory traffic of a substep, by the model of [`windswept::PlanRow::bytes`], and the memory of the scene.
fn print_totals(rows: &[windswept::PlanRow], mut buffers: Vec<windswept::BufferRow>, console: &mut Console<'_>) {
    let (runs, traffic) = (rows.iter().map(|row| row.runs).sum::<u32>(), rows.iter().map(|row| row.bytes).sum());
    console.print(format_args!(
        "a substep: {runs} dispatches move {:.1} MB, if each reads and writes each of its buffers once as a whole",
        megabytes(traffic)
    ));
    let all = buffers.len();
    let textures: u64 = buffers.iter().map(|row| row.texture_bytes).sum();
    buffers.retain(windswept::BufferRow::is_largest);
    let total: u64 = buffers.iter().map(windswept::BufferRow::bytes).sum();
    buffers.sort_by_key(|row| std::cmp::Reverse(row.bytes()));
    let largest = buffers.iter().take(LARGEST).map(|row| format!("{} {:.1}", row.name, megabytes(row.bytes())));
    console.print(format_args!(
        "{all} buffers in {} blocks of memory: {:.1} MB; the largest: {}",
        buffers.len(),
        megabytes(total),
        largest.collect::<Vec<_>>().join(", ")
    ));
    console.print(format_args!("on a software adapter at most {:.1} MB of textures besides", megabytes(textures)));
}

fn megabytes(bytes: u64) -> f64 {
    bytes as f64 * 1e-6
}

/// Every buffer: how many elements, of how many bytes, in whose memory if not in its own, and what they hold.
fn print_buffers(rows: &[windswept::BufferRow], console: &mut Console<'_>) {
    let name = rows.iter().map(|row| row.name.len()).max().unwrap_or(0);
    console.print("buffers");
    for row in rows {
        let memory = if row.is_largest() { String::new() } else { format!("in {}: ", row.memory) };
        console.print(format_args!(
            "  {:<name$}  {:>9} x {:>3} B = {:>8.2} MB  {memory}{}",
            row.name,
            row.len,
            row.stride,
            megabytes(row.bytes()),
            row.doc.replace('\\', "")
        ));
    }
}

/// `windswept adapters`: the adapters of the machine.
pub(crate) fn adapters(console: &mut Console<'_>) -> Result<(), Failure> {
    let adapters = windswept::adapters();
    if adapters.is_empty() {
        // The error of opening an adapter says which kind was looked for, and which package to install.
        Gpu::new(&AdapterChoice::Best)?;
    }
    for adapter in adapters {
        console.print(adapter);
    }
    Ok(())
}
