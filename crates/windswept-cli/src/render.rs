//! `windswept render`: pictures of a run that is over, or was stopped.

use std::path::{Path, PathBuf};

use windswept::{AdapterChoice, Frame, Gpu};
use windswept_export::{
    Folder, FrameSink, Kind, Pictures, Renderer, VtkHdfReader, check_sheet, contact_sheet, write_png,
};
use windswept_scene::{AirPicture, CheckedScene, Scene};

use crate::arguments::{Range, RenderOptions, of_pictures};
use crate::console::Console;
use crate::failure::Failure;
use crate::finished::{OF_HAIR, OF_SCENE, check_folder, open, there};
use crate::interrupt::Interrupt;
use crate::output::{Output, no_folder};
use crate::progress::Progress;

pub(crate) fn render(options: &RenderOptions, console: &mut Console<'_>) -> Result<(), Failure> {
    let run = FinishedRun::open(options)?;
    match &options.contact_sheet {
        Some(times) => sheet(&run, times, &options.sheet_path(), options, console),
        None => film(&run, options.out.as_deref().unwrap_or(&options.dir), options, console),
    }
}

/// frames/ and preview.gif in a folder.
fn film(run: &FinishedRun, dir: &Path, options: &RenderOptions, console: &mut Console<'_>) -> Result<(), Failure> {
    let chosen = run.choose(options)?;
    let output = Output::of_run(dir);
    if !options.overwrite && output.has_pictures() {
        return Err(Failure::Input(format!("{}: has pictures already; --overwrite replaces them", dir.display())));
    }
    output.check_pictures()?;
    std::fs::create_dir_all(dir).map_err(|error| no_folder(dir, &error))?;
    let _lock = Folder(dir).lock()?;
    let gpu = gpu(options, console)?;
    let mut pictures = Pictures::new(dir, &gpu, &run.scene, &run.frame(0)?, None)?;
    let interrupt = Interrupt::listen()?;
    output.remove_pictures()?;
    let mut progress = Progress::new("pictures", 0, chosen.len() as u64, console.terminal);
    let mut drawn = || {
        for &k in &chosen {
            if interrupt.asked() {
                return Ok(());
            }
            let frame = run.frame(k)?;
            // Errors at the start are bad input; an error here is a failure of the run.
            pictures.add(k as u64, &frame).map_err(|e| Failure::Run(e.to_string()))?;
            progress.show(pictures.made(), frame.time, console);
        }
        Ok(())
    };
    let drawn: Result<(), Failure> = drawn();
    progress.finish();
    let made = pictures.made();
    let finished = Box::new(pictures).finish();
    drawn?;
    finished?;
    let [_, preview] = Pictures::FILES.map(|name| dir.join(name));
    let done = format!("{}: {made} of {} pictures, {}", dir.display(), chosen.len(), preview.display());
    if made < chosen.len() as u64 {
        return Err(Failure::Interrupted(format!("interrupted; {done}")));
    }
    console.print(done);
    Ok(())
}

/// Draws some frames side by side into one picture.
fn sheet(
    run: &FinishedRun,
    times: &[f64],
    path: &Path,
    options: &RenderOptions,
    console: &mut Console<'_>,
) -> Result<(), Failure> {
    let chosen = run.at(times)?;
    if path.extension().is_none_or(|ending| !ending.eq_ignore_ascii_case("png")) {
        return Err(Failure::Input(format!("{}: expected a name that ends in .png", path.display())));
    }
    Output::of_run(&run.dir).check_place(path, "--out", options.overwrite)?;
    let camera = &run.scene.cameras[0];
    check_sheet(&vec![(camera.width, camera.height); chosen.len()])
        .map_err(|error| Failure::Input(format!("--contact-sheet: {error}")))?;
    let gpu = gpu(options, console)?;
    let renderer = Renderer::new(&gpu, &run.scene, &run.frame(0)?.hair)?;
    let draw = |&k: &usize| Ok(renderer.render(&run.frame(k)?)?);
    let pictures = chosen.iter().map(draw).collect::<Result<Vec<_>, Failure>>()?;
    write_png(path, &contact_sheet(&pictures)?)?;
    let shown: Vec<_> = chosen.iter().map(|&k| format!("{:.3}", run.times()[k])).collect();
    console.print(format_args!("{}: t = {} s", path.display(), shown.join(", ")));
    Ok(())
}

/// The scene with the camera of this name as its only one.
fn taken_with(scene: &CheckedScene, name: &str) -> Result<CheckedScene, Failure> {
    match scene.cameras.iter().find(|camera| camera.name == name) {
        Some(camera) => Ok(scene.assuming(|_, values| values.cameras = vec![camera.clone()])),
        None => {
            let names: Vec<&str> = scene.cameras.iter().map(|camera| &*camera.name).collect();
            Err(Failure::Input(format!("--camera: expected one of {}, found {name:?}", names.join(", "))))
        }
    }
}

fn gpu(options: &RenderOptions, console: &mut Console<'_>) -> Result<Gpu, Failure> {
    let gpu = Gpu::new(&AdapterChoice::from_flag(options.adapter.as_deref()))?;
    console.note(format_args!("drawing on {}", gpu.info()));
    Ok(gpu)
}

/// A run that is over, by what it left in its folder.
struct FinishedRun {
    dir: PathBuf,
    scene: CheckedScene,
    hair: VtkHdfReader,
    /// The film of air, if it is drawn.
    air: Option<VtkHdfReader>,
}

impl FinishedRun {
    fn open(options: &RenderOptions) -> Result<Self, Failure> {
        let dir = &options.dir;
        check_folder(dir)?;
        of_pictures(&options.sets)?;
        let output = Output::of_run(dir);
        let scene = there(output.scene(), OF_SCENE)?;
        let hair = there(output.film(Kind::Hair), OF_HAIR)?;
        let scene = Scene::load_with(scene, &options.sets)?.check()?;
        let scene = match &options.camera {
            Some(name) => taken_with(&scene, name)?,
            None => scene,
        };
        let air = match scene.picture.air {
            AirPicture::None => None,
            _ => Some(open(
                &there(output.film(Kind::Air), "picture.air needs it; a run with air particles writes it")?,
                Kind::Air,
            )?),
        };
        let run = Self { dir: dir.clone(), scene, hair: open(&hair, Kind::Hair)?, air };
        if run.times().is_empty() {
            return Err(Failure::Input(format!("{}: no frame was finished", hair.display())));
        }
        Ok(run)
    }

    /// Times of the frames that all its files have [s].
    fn times(&self) -> &[f64] {
        let times = self.hair.times();
        let air = self.air.as_ref().map_or(times.len(), |air| air.times().len());
        &times[..times.len().min(air)]
    }

    fn frame(&self, k: usize) -> Result<Frame, Failure> {
        let mut frame = self.hair.frame(k)?;
        if let Some(air) = &self.air {
            frame.air = air.frame(k)?.air;
        }
        Ok(frame)
    }

    /// Which frames `--frames` and `--every` ask for.
    fn choose(&self, options: &RenderOptions) -> Result<Vec<usize>, Failure> {
        let there = self.times().len();
        let Range { from, to } = options.frames.unwrap_or(Range { from: 0, to: None });
        let chosen: Vec<_> = (from..to.unwrap_or(there).min(there)).step_by(options.every.get()).collect();
        if chosen.is_empty() || to.is_some_and(|to| to > there) {
            let dir = self.dir.display();
            return Err(Failure::Input(format!("--frames: {dir} has frames 0 to {}", there - 1)));
        }
        Ok(chosen)
    }

    /// The frames at these times [s], each once.
    fn at(&self, times: &[f64]) -> Result<Vec<usize>, Failure> {
        let mut chosen = Vec::new();
        for &time in times {
            let frame = self.nearest(time)?;
            if !chosen.contains(&frame) {
                chosen.push(frame);
            }
        }
        Ok(chosen)
    }

    /// The frame at this time [s].
    fn nearest(&self, time: f64) -> Result<usize, Failure> {
        let times = self.times();
        let last = times[times.len() - 1];
        // As far beyond the end as from one frame to the next.
        if !(0.0..=last + 1.0 / self.scene.time.frame_rate).contains(&time) {
            return Err(Failure::Input(format!("--contact-sheet {time}: the run has frames from 0 to {last:.3} s")));
        }
        let near = (0..times.len()).min_by(|&a, &b| (times[a] - time).abs().total_cmp(&(times[b] - time).abs()));
        Ok(near.unwrap_or(0))
    }
}
