//! `windswept export`: a film of a run for other programs.

use std::path::{Path, PathBuf};

use windswept::Frame;
use windswept_export::{ExportError, Film, Followers, Kind, Provenance, Scenery, Units};
use windswept_scene::{CheckedScene, Outline, Scene};

use crate::arguments::ExportOptions;
use crate::console::{Console, counted_frames};
use crate::failure::Failure;
use crate::finished::{OF_HAIR, OF_SCENE, check_folder, open, there};
use crate::output::Output;

pub(crate) fn export(options: &ExportOptions, console: &mut Console<'_>) -> Result<(), Failure> {
    let dir = &options.dir;
    check_folder(dir)?;
    let output = Output::of_run(dir);
    let outline = Outline::load(there(output.scene(), OF_SCENE)?)?;
    let film = there(output.film(Kind::Hair), OF_HAIR)?;
    let hair = open(&film, Kind::Hair)?;
    let frames = hair.times().len();
    if frames == 0 {
        return Err(Failure::Input(format!("{}: no frame was finished", film.display())));
    }
    let path = place(options, &output)?;
    let [adapter, version] = hair.origin();
    let provenance = Provenance { scene: &outline.text, version: &version, adapter: &adapter, seed: outline.seed };
    let first = hair.frame(0)?.hair;
    let beside = options.format.scenery && !options.hair_only;
    // Followers come from groom files, and stay out of meshes, which bodies are too.
    let scene = if options.followers || beside { Some(scene(output.scene(), options)?) } else { None };
    let of_input = |e: ExportError| Failure::Input(e.to_string());
    let followers = match &scene {
        Some(scene) if options.followers => Some(Followers::new(scene, &first).map_err(of_input)?),
        _ => None,
    };
    let scenery = match &scene {
        Some(scene) if beside => Scenery::of(scene, &first, None).map_err(of_input)?,
        _ => Scenery::default(),
    };
    let units = Units { metres: options.scale, up: options.up };
    let frame = |k| {
        let frame = hair.frame(k)?;
        let frame = if let Some(followers) = &followers { followers.frame(&frame)? } else { frame };
        Ok(Frame { hair: units.of(frame.hair), ..frame })
    };
    let _lock = options.out.is_none().then(|| output.lock_for(options.format.file)).transpose()?;
    let time = &outline.time;
    (options.format.write)(&path, &Film { frames, frame: &frame, scenery: &scenery, time, provenance, units })?;
    // Arrays have times, and no time codes.
    if let Some(uneven) = time.uneven().filter(|_| options.format.scenery) {
        console.note(uneven);
    }
    let strands = first.offsets.len() - 1;
    let hairs = followers.map(|followers| format!("{} hairs of ", followers.len())).unwrap_or_default();
    console.print(format_args!("{}: {hairs}{strands} strands, {}", path.display(), counted_frames(frames as u64)));
    Ok(())
}

/// The scene of the run, with its files.
fn scene(path: PathBuf, options: &ExportOptions) -> Result<CheckedScene, Failure> {
    let scene = Scene::load(path)?.check();
    scene.map_err(|error| match options.followers {
        true => error.into(),
        false => Failure::Input(format!("{error}\n--hair-only writes a film without bodies and cameras")),
    })
}

/// The file to write.
fn place(options: &ExportOptions, output: &Output) -> Result<PathBuf, Failure> {
    let path = options.out.clone().unwrap_or_else(|| options.dir.join(options.format.file));
    let ending = Path::new(options.format.file).extension();
    if path.extension() != ending {
        let ending = ending.unwrap_or_default().display();
        return Err(Failure::Input(format!("{}: expected a name that ends in .{ending}", path.display())));
    }
    output.check_place(&path, "--out", options.overwrite)?;
    Ok(path)
}
