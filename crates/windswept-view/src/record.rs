//! Files that the window writes: films, scenes, checkpoints, pictures.

use std::fs;
use std::path::{Path, PathBuf};

use windswept::{AsChecked as _, Camera, Pose, Scene, Simulation};
use windswept_export::{Folder, Format, Lock, Recording, SCENE, Schedule};
use windswept_scene::{AtomicFile, Keyframe};

/// Frames of a film at most, ten seconds by default. A file of frames has room for all of them from the start.
const MOST_FRAMES: u64 = 600;

/// Why a file was not written, as it is shown.
pub(crate) type Refusal = String;

/// A film that is being made.
pub(crate) struct Film {
    recording: Recording,
    folder: PathBuf,
    schedule: Schedule,
    /// The frame of the schedule that comes next.
    next: u64,
    written: u64,
    camera: Camera,
    /// Time of each frame \[s\], and the poses of the bodies.
    poses: Vec<(f64, Vec<Pose>)>,
    /// Held until the last file is written.
    _lock: Lock,
}

impl Film {
    /// Begins a film with the state now in a new folder beneath `out`, in these formats; pictures are taken with the
    /// camera.
    pub(crate) fn begin(
        simulation: &mut Simulation,
        out: &Path,
        formats: &[&'static Format],
        camera: Camera,
    ) -> Result<Self, Refusal> {
        let folder = free(out, "film", "");
        if formats.iter().any(|format| format.name == "png") {
            let scene = Scene { cameras: vec![camera.clone()], ..simulation.scene().scene().clone() };
            simulation.update(&scene).map_err(|error| error.to_string())?;
        }
        let recording = Recording::new(formats, simulation, &folder, MOST_FRAMES as usize);
        let recording = recording.map_err(|error| error.to_string())?;
        fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
        let _lock = Folder(&folder).lock().map_err(|error| error.to_string())?;
        let schedule = Schedule::new(&simulation.scene().time, Some(Schedule::most_steps(&simulation.scene().time)));
        let next = schedule.frame_after(simulation.steps());
        let mut film = Self { recording, folder, schedule, next, written: 0, camera, poses: Vec::new(), _lock };
        film.write_scene(simulation)?;
        film.append(simulation)?;
        Ok(film)
    }

    /// Writes the state as a frame if one is due. Returns whether the film has room for more.
    pub(crate) fn take(&mut self, simulation: &mut Simulation) -> Result<bool, Refusal> {
        if simulation.steps() >= self.schedule.step(self.next) {
            self.next = self.schedule.frame_after(simulation.steps());
            self.append(simulation)?;
        }
        Ok(self.written < MOST_FRAMES)
    }

    fn append(&mut self, simulation: &mut Simulation) -> Result<(), Refusal> {
        let losses = self.recording.append(simulation).map_err(|error| error.to_string())?;
        self.written += 1;
        let time = simulation.time();
        self.poses.push((time, simulation.scene().bodies.iter().map(|body| body.motion.at(time)).collect()));
        // What a film goes on without is said; it can be made again.
        losses.into_iter().next().map_or(Ok(()), |loss| Err(format!("no more {}: {}", loss.format.writes, loss.error)))
    }

    /// Ends the files, and writes the scene with all that was changed meanwhile, and with the ways of bodies that were
    /// dragged as their keyframes. Returns what there is to say.
    pub(crate) fn finish(self, simulation: &Simulation) -> Result<String, Refusal> {
        let scene = self.write_scene(simulation);
        let losses = self.recording.finish().map_err(|error| error.to_string())?;
        scene?;
        match losses.into_iter().next() {
            Some(loss) => Err(loss.error.to_string()),
            None => Ok(format!("{}: {} frames", self.folder.display(), self.written)),
        }
    }

    fn write_scene(&self, simulation: &Simulation) -> Result<(), Refusal> {
        let mut scene = Scene { cameras: vec![self.camera.clone()], ..simulation.recorded() };
        for (i, body) in scene.bodies.iter_mut().enumerate() {
            let ways = || self.poses.iter().filter_map(|(time, poses)| Some((*time, *poses.get(i)?)));
            if ways().any(|(time, pose)| !is_near(&body.motion.at(time), &pose)) {
                body.motion = ways().map(|(time, pose)| Keyframe::posed(time, pose)).collect::<Vec<_>>().into();
            }
        }
        write_scene(&scene, &self.folder.join(SCENE))
    }

    pub(crate) fn folder(&self) -> &Path {
        &self.folder
    }

    pub(crate) fn written(&self) -> u64 {
        self.written
    }
}

/// Whether poses are one up to rounding \[m\], \[rad\].
fn is_near(a: &Pose, b: &Pose) -> bool {
    a.translation.distance(b.translation) < 1e-9 && a.rotation.angle_between(b.rotation) < 1e-6
}

/// Writes the scene that the simulation began with, and all changes since.
pub(crate) fn save_scene(simulation: &Simulation, out: &Path) -> Result<PathBuf, Refusal> {
    make(out)?;
    let path = free(out, "scene", ".toml");
    write_scene(&simulation.recorded(), &path)?;
    Ok(path)
}

/// Writes a checkpoint.
pub(crate) fn save_checkpoint(simulation: &Simulation, out: &Path) -> Result<PathBuf, Refusal> {
    make(out)?;
    let path = free(out, "checkpoint", ".windswept");
    simulation.save(&path).map_err(|error| error.to_string())?;
    Ok(path)
}

fn write_scene(scene: &Scene, path: &Path) -> Result<(), Refusal> {
    let checked = scene.as_checked().map_err(|error| error.to_string())?;
    let text = checked.text_in(path.parent().unwrap_or(Path::new(".")));
    AtomicFile::write(path, text.as_bytes()).map_err(|error| format!("{}: {error}", path.display()))
}

/// Makes the folder.
pub(crate) fn make(out: &Path) -> Result<(), Refusal> {
    fs::create_dir_all(out).map_err(|error| format!("{}: {error}", out.display()))
}

/// The first path `out/NAME-1ENDING`, `out/NAME-2ENDING`, … where nothing is.
pub(crate) fn free(out: &Path, name: &str, ending: &str) -> PathBuf {
    let path = |k: u32| out.join(format!("{name}-{k}{ending}"));
    (1..u32::MAX).map(path).find(|path| path.symlink_metadata().is_err()).unwrap_or_else(|| path(u32::MAX))
}
