//! `windswept export`: a film of a run's strands for other programs.

use std::path::{Path, PathBuf};

use windswept::Frame;
use windswept_export::{Film, Followers, Kind, Provenance, Units};
use windswept_scene::{Outline, Scene};

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
    let followers = match options.followers {
        false => None,
        // They come from groom files, and stay out of meshes.
        true => Some(
            Followers::new(&Scene::load(output.scene())?.check()?, &first)
                .map_err(|e| Failure::Input(e.to_string()))?,
        ),
    };
    let units = Units { metres: options.scale, up: options.up };
    let frame = |k| {
        let frame = hair.frame(k)?;
        let frame = if let Some(followers) = &followers { followers.frame(&frame)? } else { frame };
        Ok(Frame { hair: units.of(frame.hair), ..frame })
    };
    let _lock = options.out.is_none().then(|| output.lock_for(options.format.file)).transpose()?;
    (options.format.write)(&path, &Film { frames, frame: &frame, rate: outline.time.frame_rate, provenance, units })?;
    let strands = first.offsets.len() - 1;
    let hairs = followers.map(|followers| format!("{} hairs of ", followers.len())).unwrap_or_default();
    console.print(format_args!("{}: {hairs}{strands} strands, {}", path.display(), counted_frames(frames as u64)));
    Ok(())
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
