//! A simulation in a file, from which it goes on with the same bits.

use std::{
    collections::BTreeMap,
    fs::File,
    io::{self, BufRead as _, BufReader, BufWriter, Read, Write},
    mem,
    path::Path,
    sync::OnceLock,
};

use glam::{DQuat, DVec3, Vec3};
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use windswept_scene::limits::FASTEST_WIND;
use windswept_scene::{AtomicFile, Change, CheckedBody, CheckedScene, InitialState, Keyframe, Motion, Scene, Warning};
use windswept_shaders::common::rod::{Root, StrandHistory};

use super::{
    Origin, Simulation,
    bodies::Driven as DrivenBody,
    drive::{held, is_rotation, is_wind},
};
use crate::{
    array::AnyArray,
    error::{CheckpointError, Error},
    gpu::{AdapterChoice, AdapterInfo, Gpu, adapters},
    report::Reset,
    simulation::sections::{Fault, Reading, Writing},
    state::{Sizes, State},
    status,
};

/// Format of the files. It rises when a section gets another content, or a buffer that lasts another layout or meaning.
const FORMAT: u32 = 14;

const ABOUT: &str = "about";
const SCENE: &str = "scene";
const FILES: &str = "files";
const START: &str = "start";
const DRIVEN: &str = "driven";
const NOTES: &str = "notes";

/// The origin of a checkpoint.
#[derive(Debug, Serialize, Deserialize)]
struct About {
    /// Version of windswept.
    windswept: String,
    /// Commit that windswept was built from, where the build knew it.
    commit: Option<String>,
    adapter: AdapterInfo,
}

impl About {
    fn of(gpu: &Gpu) -> Self {
        Self {
            windswept: env!("CARGO_PKG_VERSION").to_owned(),
            commit: option_env!("WINDSWEPT_COMMIT").map(str::to_owned),
            adapter: gpu.info().clone(),
        }
    }

    /// A warning if the adapter or the version is another than that of the saved run.
    fn differs_from(&self, now: &Self) -> Option<Warning> {
        let version = |about: &Self| {
            let commit = about.commit.as_deref().map(|commit| format!(" ({commit})")).unwrap_or_default();
            format!("windswept {}{commit}", about.windswept)
        };
        let differ = |what: &str, then: String, now: String| {
            let text = format!("goes on with another {what}, and so with other bits: saved by {then}, now {now}");
            (then != now).then(|| Warning::new("other_bits", "", text))
        };
        differ("adapter", self.adapter.to_string(), now.adapter.to_string())
            .or_else(|| differ("version", version(self), version(now)))
    }
}

/// Files that a scene's text only names, by what they are to it, each with the checksum of its bytes; without one where
/// it cannot be read.
pub(super) type Files = Vec<(String, Option<u32>)>;

/// The groom files and meshes of a scene, as they are now.
pub(super) fn files(scene: &CheckedScene) -> Files {
    let grooms =
        scene.hair.iter().enumerate().filter_map(|(k, hair)| Some((scene.scene().called(k), &*hair.as_file()?.file)));
    let meshes = scene
        .bodies
        .iter()
        .filter_map(|body| Some((format!("body {:?}", body.name), body.shape.solid()?.file().named().1)));
    grooms.chain(meshes).map(|(what, file)| (format!("{what}, {file},"), checksum(Path::new(file)).ok())).collect()
}

fn checksum(path: &Path) -> io::Result<u32> {
    // A pipe or a device may never end.
    if !path.metadata()?.is_file() {
        return Err(io::ErrorKind::InvalidInput.into());
    }
    let (mut file, mut hasher) = (BufReader::new(File::open(path)?), crc32fast::Hasher::new());
    loop {
        let bytes = file.fill_buf()?;
        if bytes.is_empty() {
            return Ok(hasher.finalize());
        }
        hasher.update(bytes);
        let read = bytes.len();
        file.consume(read);
    }
}

/// State of the host: targets of roots, wind and forces that a caller set.
#[derive(Debug, Serialize, Deserialize)]
struct Driven {
    /// Frame that clamps the root of each strand.
    root_frames: Vec<DQuat>,
    /// Mean wind that was set last, in place of the scene's own \[m/s\].
    wind: Option<DVec3>,
    /// Speed of the law of turbulence, which a wind that was set has raised \[m/s\].
    speed: f64,
    /// Text of the scene that the simulation began with, and the updates since.
    began: String,
    updates: Vec<Change>,
    /// Motions and poses that were set, by the bodies' indices.
    bodies: BTreeMap<usize, DrivenBody>,
    /// Whether the strands are a caller's own, and no scene's.
    own_hair: bool,
    /// Whether a force that was set pushes hair and air.
    pushes: bool,
    /// Resets so far.
    resets: Vec<Reset>,
}

/// A simulation that was saved, read and checked, and not yet on a GPU.
///
/// ```no_run
/// use windswept_engine::{AdapterChoice, Checkpoint, Gpu};
///
/// let checkpoint = Checkpoint::open("now.windswept")?;
/// println!("{}, saved on {}", checkpoint.scene().title, checkpoint.adapter());
/// let mut simulation = checkpoint.start(&Gpu::new(&AdapterChoice::Best)?)?;
/// simulation.step(100)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Checkpoint {
    file: String,
    about: About,
    scene: CheckedScene,
    files: Files,
    initial: InitialState,
    driven: Driven,
    notes: Vec<u8>,
    /// The content of each buffer that lasts, in the order of [`State::lasting`].
    buffers: Vec<Vec<u8>>,
}

impl Checkpoint {
    /// Reads a file that [`Simulation::save`] wrote, to its end.
    ///
    /// # Errors
    /// [`CheckpointError::File`], and [`CheckpointError::Content`] for a file that is foreign, of another version, cut
    /// off or damaged: it says what is wrong, and where.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, CheckpointError> {
        let path = path.as_ref();
        let opened = File::open(path).and_then(|file| Ok((file.metadata()?.len(), file)));
        let name = path.display().to_string();
        let (len, file) = opened.map_err(|reason| unreadable(&name, reason))?;
        Self::read(BufReader::new(file), len, name)
    }

    /// Reads what [`Simulation::to_bytes`] returned; errors call it by this name.
    ///
    /// # Errors
    /// [`CheckpointError::Content`] as [`Self::open`].
    pub fn from_bytes(bytes: &[u8], name: &str) -> Result<Self, CheckpointError> {
        Self::read(bytes, bytes.len() as u64, name.to_owned())
    }

    fn read(from: impl Read, len: u64, file: String) -> Result<Self, CheckpointError> {
        let refused = |fault| match fault {
            Fault::Io(reason) => unreadable(&file, reason),
            Fault::Content(problem) => CheckpointError::Content { file: file.clone(), problem },
        };
        let mut reading = Reading::begin(from, len, FORMAT).map_err(refused)?;
        let mut section = |name: &str| reading.section(name).map_err(refused);
        let about = decoded(&file, ABOUT, &section(ABOUT)?)?;
        let text = section(SCENE)?;
        let files: Files = decoded(&file, FILES, &section(FILES)?)?;
        let initial = decoded(&file, START, &section(START)?)?;
        let driven = decoded(&file, DRIVEN, &section(DRIVEN)?)?;
        let notes = section(NOTES)?;
        let buffers = State::new(&Sizes::default()).lasting();
        let buffers = buffers.iter().map(|array| section(array.name())).collect::<Result<_, _>>()?;
        reading.end().map_err(refused)?;
        let text = std::str::from_utf8(&text).map_err(|error| invalid(&file, format!("section {SCENE}: {error}")))?;
        let scene = Scene::parse_named(&format!("{file}, section {SCENE}"), text).and_then(|scene| scene.check());
        let scene = scene.map_err(|error| invalid(&file, error.to_string()))?;
        let now = self::files(&scene);
        if let Some((what, _)) = files.iter().find(|(what, sum)| sum.is_some() && !now.contains(&(what.clone(), *sum)))
        {
            let words = format!("{what} has changed since the simulation was saved, or cannot be read any more");
            return Err(invalid(&file, words));
        }
        Ok(Self { file, about, scene, files, initial, driven, notes, buffers })
    }

    /// The scene as it was given, without a wind that was set.
    #[must_use]
    pub fn scene(&self) -> &CheckedScene {
        &self.scene
    }

    /// The adapter that the simulation ran on.
    #[must_use]
    pub fn adapter(&self) -> &AdapterInfo {
        &self.about.adapter
    }

    /// Notes of the caller's own, as [`Simulation::save_with`] was given them.
    ///
    /// # Errors
    /// [`CheckpointError::Content`] if they are something else.
    pub fn notes<N: DeserializeOwned>(&self) -> Result<N, CheckpointError> {
        decoded(&self.file, NOTES, &self.notes)
    }

    /// The adapter to go on with: the one that `flag` names, as [`AdapterChoice::from_flag`]; without a flag the one
    /// that the simulation ran on, if it is there.
    #[must_use]
    pub fn choice(&self, flag: Option<&str>) -> AdapterChoice {
        let own = || flag.is_none() && adapters().contains(&self.about.adapter);
        match AdapterChoice::from_flag(flag) {
            AdapterChoice::Best if own() => AdapterChoice::Named(self.about.adapter.name.clone()),
            choice => choice,
        }
    }

    /// A warning where the adapter or the version of windswept is another than that of the saved run, so that the run
    /// goes on with other bits.
    #[must_use]
    pub fn differs(&self, gpu: &Gpu) -> Option<Warning> {
        self.about.differs_from(&About::of(gpu))
    }

    /// The simulation, as it was when it was saved. On the same adapter it goes on with the same bits; on another one,
    /// or with another version of windswept, [`Simulation::warnings`] says so.
    ///
    /// A simulation whose run was ended by something that is not finite is as it was before that step, which it takes
    /// again. Timings start anew, and [`Simulation::step_timed`] and the trace with them.
    ///
    /// # Errors
    /// [`CheckpointError::Start`] if the simulation does not fit the adapter, [`CheckpointError::Content`] if what was
    /// saved does not belong together.
    pub fn start(self, gpu: &Gpu) -> Result<Simulation, CheckpointError> {
        let differs = self.differs(gpu);
        let Self { file, scene, files, mut initial, driven, buffers, .. } = self;
        initial.warnings.extend(differs);
        let failed = |error| CheckpointError::Start { file: file.clone(), error };
        let mut simulation = Simulation::build(gpu, &scene, initial, Origin::Untrusted).map_err(failed)?;
        let strands = simulation.initial.hair.len();
        if driven.root_frames.len() != strands {
            let words = format!("section {DRIVEN} has {} root frames for {strands} strands", driven.root_frames.len());
            return Err(invalid(&file, words));
        }
        if let Some(s) = driven.root_frames.iter().position(|frame| !is_rotation(frame)) {
            return Err(invalid(&file, format!("section {DRIVEN}: the root frame of strand {s} is not a rotation")));
        }
        if let Some(wind) = driven.wind.filter(|wind| !is_wind(wind)) {
            return Err(invalid(&file, format!("section {DRIVEN} has a wind of {wind} m/s")));
        }
        let is_held = |k: &Keyframe| held(&k.translation.into()) && held(&k.rotation.into()) && k.time.is_finite();
        let is_motion = |motion: &Motion| motion.keyframes.len() == 2 && motion.keyframes.iter().all(is_held);
        let points = |body: &CheckedBody| body.shape.solid().map(|solid| solid.triangles().points.len());
        let are_poses = |body: &CheckedBody, driven: &DrivenBody| match &driven.poses {
            None => true,
            Some((poses, lattice)) => {
                let fits = |pose: &[Vec3]| Some(pose.len()) == points(body) && lattice.holds(pose);
                poses.iter().all(|pose| fits(pose))
            }
        };
        let is_driven = |(body, driven): (&usize, &DrivenBody)| {
            scene.bodies.get(*body).is_some_and(|body| is_motion(&driven.motion) && are_poses(body, driven))
        };
        if !driven.bodies.iter().all(is_driven) {
            return Err(invalid(&file, format!("section {DRIVEN} has motions that are no bodies'")));
        }
        if !(0.0..=FASTEST_WIND).contains(&driven.speed) && driven.speed != scene.turbulence.speed {
            return Err(invalid(&file, format!("section {DRIVEN} has a speed of {} m/s", driven.speed)));
        }
        simulation.raise_speed(driven.speed).map_err(failed)?;
        simulation.plan_force(driven.pushes).map_err(|error| failed(Error::Gpu(error)))?;
        let engine = &simulation.engine;
        for (array, bytes) in engine.state().lasting().iter().zip(&buffers) {
            let (found, expected) = (bytes.len() as u64, array.stride() * array.len());
            if found != expected {
                let words = format!("section {} has {found} bytes, the scene needs {expected}", array.name());
                return Err(invalid(&file, words));
            }
            if let Some((row, words)) = unusable(engine.state(), array, bytes) {
                return Err(invalid(&file, format!("section {}: row {row} {words}", array.name())));
            }
            engine.write_bytes(array, bytes)?;
        }
        let pins = engine.read(&engine.state().pins)?;
        simulation.plan_pins(&pins)?;
        let engine = &simulation.engine;
        simulation.last = engine.status()?;
        if simulation.last.causes != 0 {
            // An error that ended the run is found anew if it persists.
            simulation.last = status::thawed(&simulation.last);
            engine.set_status(&simulation.last)?;
        }
        (simulation.first_substep, simulation.loads_after) = (simulation.last.step, simulation.last.step);
        simulation.steps = u64::from(simulation.first_substep) / simulation.substeps();
        simulation.root_frames = driven.root_frames;
        (simulation.resets, simulation.own_hair) = (driven.resets, driven.own_hair);
        simulation.began = Scene::parse(&driven.began).map_err(|error| invalid(&file, error.to_string()))?;
        simulation.updates = driven.updates;
        simulation.files = OnceLock::from(files);
        if let Some(wind) = driven.wind {
            simulation.plan_wind(wind).map_err(failed)?;
        }
        for (body, driven) in driven.bodies {
            simulation.drive_body(body, driven).map_err(failed)?;
        }
        simulation.poses.bring(&simulation.engine, simulation.last.step)?;
        Ok(simulation)
    }
}

impl Simulation {
    /// Saves the simulation to a file, from which [`Self::load`] goes on with the same bits: all that lasts from step
    /// to step, the scene, the strands and air that it started from, what was set since, and by which windswept and on
    /// which adapter it ran.
    ///
    /// The file is written beside `path` (its name with `.part` behind it), flushed to the disk and renamed: whatever
    /// becomes of the process, `path` is a whole checkpoint or what it was before.
    ///
    /// # Errors
    /// [`CheckpointError::File`] if the file cannot be written, [`CheckpointError::Text`] for a scene that was made in
    /// code and is no scene file's, or one whose mesh files cannot be read any more, [`CheckpointError::Gpu`] if the
    /// device is lost.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), CheckpointError> {
        self.save_with(path, &())
    }

    /// Saves the simulation with notes of the caller's own, which [`Checkpoint::notes`] returns.
    ///
    /// # Errors
    /// As [`Self::save`].
    pub fn save_with(&self, path: impl AsRef<Path>, notes: &impl Serialize) -> Result<(), CheckpointError> {
        let path = path.as_ref();
        let name = path.display().to_string();
        let io = |reason| CheckpointError::File { file: name.clone(), be: "written", reason };
        let unmade = |reason| CheckpointError::File { file: format!("{name}.part"), be: "written", reason };
        let whole = AtomicFile::new(path).map_err(unmade)?;
        let file = whole.create().map_err(unmade)?;
        let out = self.write(BufWriter::new(file), &name, notes)?;
        let file = out.into_inner().map_err(|error| io(error.into_error()))?;
        file.sync_all().map_err(io)?;
        drop(file);
        whole.finish().map_err(io)?;
        sync_folder(path).map_err(io)
    }

    /// The bytes of the file that [`Self::save`] writes.
    ///
    /// # Errors
    /// As [`Self::save`].
    pub fn to_bytes(&self) -> Result<Vec<u8>, CheckpointError> {
        self.write(Vec::new(), "the simulation", &())
    }

    /// Goes on with a simulation that [`Self::save`] wrote. To look at what was saved before it is on a GPU, use
    /// [`Checkpoint`].
    ///
    /// # Errors
    /// As [`Checkpoint::open`] and [`Checkpoint::start`].
    pub fn load(gpu: &Gpu, path: impl AsRef<Path>) -> Result<Self, CheckpointError> {
        Checkpoint::open(path)?.start(gpu)
    }

    fn write<W: Write>(&self, out: W, file: &str, notes: &impl Serialize) -> Result<W, CheckpointError> {
        let io = |reason| CheckpointError::File { file: file.to_owned(), be: "written", reason };
        let text = self.given.scene().text_now();
        match Scene::parse(&text).and_then(|scene| scene.check()) {
            Ok(scene) if *scene == *self.given => {}
            Ok(_) => return Err(CheckpointError::Text("it reads as another scene".to_owned())),
            Err(error) => return Err(CheckpointError::Text(error.to_string())),
        }
        let driven = Driven {
            root_frames: self.root_frames.clone(),
            own_hair: self.own_hair,
            wind: self.wind_set,
            began: self.began.text_now(),
            updates: self.updates.clone(),
            speed: self.scene.turbulence.speed,
            bodies: self.bodies_set.clone(),
            pushes: self.plan.conditions.pushes.runs,
            resets: self.resets.clone(),
        };
        let mut writing = Writing::begin(out, FORMAT).map_err(io)?;
        let mut section = |name: &str, content: &[u8]| writing.section(name, content).map_err(io);
        section(ABOUT, &encoded(file, &About::of(self.gpu()))?)?;
        section(SCENE, text.as_bytes())?;
        section(FILES, &encoded(file, self.files.get_or_init(|| files(&self.given)))?)?;
        section(START, &encoded(file, &self.initial)?)?;
        section(DRIVEN, &encoded(file, &driven)?)?;
        section(NOTES, &encoded(file, notes)?)?;
        for array in self.engine.state().lasting() {
            section(array.name(), &self.engine.read_bytes(&array)?)?;
        }
        writing.end().map_err(io)
    }
}

/// First row of an array, among those that a step reads unchecked, that is not finite, no rotation or no particle
/// index, and why. A step checks the arrays that it computes.
fn unusable(state: &State, array: &AnyArray, bytes: &[u8]) -> Option<(usize, &'static str)> {
    let is = |names: [&str; 2]| names.contains(&array.name());
    let vector = |x: [f32; 3]| held(&DVec3::from_array(x.map(f64::from)));
    if is([state.strand_history.name(), state.root_targets.name()]) {
        let roots: Vec<Root> = if array.name() == state.root_targets.name() {
            bytemuck::pod_collect_to_vec(bytes)
        } else {
            bytemuck::pod_collect_to_vec::<u8, StrandHistory>(bytes).iter().map(|strand| strand.root).collect()
        };
        let turned = |root: &Root| is_rotation(&DQuat::from_array(root.frame.map(f64::from)));
        let row = roots.iter().position(|root| !(vector(root.position) && turned(root)))?;
        Some((row, "is not finite, or beyond 1e18, or not a rotation"))
    } else if is([state.wind_table.name(), state.pushed.name()]) {
        let rows: Vec<[f32; 4]> = bytemuck::pod_collect_to_vec(bytes);
        let row = rows.iter().position(|[x, y, z, w]| !(vector([*x, *y, *z]) && w.is_finite()))?;
        Some((row, "is not finite, or beyond 1e18"))
    } else if array.name() == state.air_id.name() {
        let ids: Vec<u32> = bytemuck::pod_collect_to_vec(bytes);
        let mut seen = vec![false; ids.len()];
        // Whether no earlier slot has this id.
        let mut first = |id: &u32| seen.get_mut(*id as usize).is_some_and(|seen| !mem::replace(seen, true));
        let row = ids.iter().position(|id| !first(id))?;
        Some((row, "is no particle of air, or one that an earlier row has"))
    } else {
        None
    }
}

fn invalid(file: &str, problem: String) -> CheckpointError {
    CheckpointError::Content { file: file.to_owned(), problem }
}

fn unreadable(file: &str, reason: io::Error) -> CheckpointError {
    CheckpointError::File { file: file.to_owned(), be: "read", reason }
}

fn encoded(file: &str, content: &impl Serialize) -> Result<Vec<u8>, CheckpointError> {
    postcard::to_stdvec(content).map_err(|error| invalid(file, error.to_string()))
}

fn decoded<T: DeserializeOwned>(file: &str, section: &str, bytes: &[u8]) -> Result<T, CheckpointError> {
    let wrong =
        |words: &str| invalid(file, format!("section {section} is not what this windswept writes there: {words}"));
    match postcard::take_from_bytes(bytes) {
        Ok((content, [])) => Ok(content),
        Ok((_, rest)) => Err(wrong(&format!("{} bytes are left", rest.len()))),
        Err(error) => Err(wrong(&error.to_string())),
    }
}

/// Makes the renaming of a file last.
#[cfg(unix)]
fn sync_folder(path: &Path) -> io::Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    File::open(folder)?.sync_all()
}

/// Elsewhere a folder cannot be opened as a file.
#[cfg(not(unix))]
fn sync_folder(_: &Path) -> io::Result<()> {
    Ok(())
}
