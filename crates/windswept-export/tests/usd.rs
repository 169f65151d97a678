//! USD's own library sees what was written, at every moment of it.

#![allow(clippy::unwrap_used)] // a test may panic

mod film;
mod python;

use std::path::Path;

use glam::{DQuat, DVec3};
use windswept_engine::{Frame, HairFrame};
use windswept_export::{ExportError, Film, Format, Scenery, Units, UsdWriter, View};
use windswept_scene::{Body, CheckedBody, Form, Pose, Scene, Time};

use film::{PROVENANCE, dump, film as hair_film, frame as hair_frame};

const RATE: f64 = 60.0;
/// Files of the film: those of its hair, and one of each body.
const LAYERS: [&str; 6] = [
    "hair.usda",
    "hair.points.usda",
    "hair.velocities.usda",
    "hair.extent.usda",
    "bodies/0000.usda",
    "bodies/0001.usda",
];
/// Camera that stands upright in no axis.
const VIEW: View =
    View { eye: DVec3::new(0.4, 0.3, -0.2), target: DVec3::new(-0.1, 0.05, 0.03), fov: 35.0, width: 640, height: 400 };

fn time() -> Time {
    Time::new(1.38e-3, 1.0)
}

/// A capsule and a ball, and a camera.
fn scenery() -> Scenery {
    let text = "time = { step = 1e-3, duration = 1.0 }\ninteraction.model = \"none\"";
    let mut scene = Scene::parse(text).unwrap();
    scene.bodies = vec![
        Body::capsule([0.1, 0.02, 0.0], [0.1, 0.12, 0.05], 0.03).named("left arm"),
        Body::sphere([0.0, 0.0, 0.3], 0.07).named("2nd"),
    ];
    Scenery { bodies: scene.check().unwrap().bodies.clone(), cameras: vec![("Hair".to_owned(), VIEW)] }
}

/// A frame with the bodies somewhere.
fn frame(k: usize) -> Frame {
    let pose = |i: usize| Pose {
        translation: 0.1 * DVec3::new(k as f64, i as f64, -0.7 * k as f64),
        rotation: DQuat::from_scaled_axis(DVec3::new(0.3, 0.9 + i as f64, -0.2) * 0.4 * k as f64),
    };
    Frame { bodies: (0..2).map(pose).collect(), ..hair_frame(k) }
}

fn film(frames: usize) -> Vec<Frame> {
    (0..frames).map(frame).collect()
}

/// Makes a frame one that does not fit.
type Spoil = fn(&mut Frame);

/// Has usd_back.py compare the stages of this folder with plain dumps of the film.
fn read_back(folder: &Path, frames: usize) {
    dump(folder, &hair_film(frames));
    let numbers = |numbers: Vec<f64>| numbers.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<_>>();
    // The ends of each body's axis, where a frame has them.
    let ends = |frame: &Frame| {
        let bodies = scenery().bodies.into_iter().zip(&frame.bodies);
        let both = |(body, pose): (CheckedBody, &Pose)| {
            let placed = body.placed(pose, frame.time);
            let Form::Round(shape) = placed.form() else { panic!("a mesh") };
            [shape.low, shape.high].map(|end| shape.center + shape.rotation * end)
        };
        bodies.flat_map(both).flat_map(|x| x.to_array()).collect::<Vec<_>>()
    };
    std::fs::write(folder.join("ends.f64"), numbers(film(frames).iter().flat_map(ends).collect())).unwrap();
    // Places in the camera's picture.
    let places = [[0.1, 0.2, 0.0], [-0.1, 0.0, 0.1], [0.0, -0.1, 0.05], [-1.0, 0.4, -0.3]].map(DVec3::from_array);
    let seen = places.iter().flat_map(|x| x.to_array().into_iter().chain(VIEW.project(*x).unwrap())).collect();
    std::fs::write(folder.join("seen.f64"), numbers(seen)).unwrap();
    let (seed, folder, rate) = (PROVENANCE.seed.to_string(), folder.display().to_string(), RATE.to_string());
    let answer = python::run("usd_back.py", &[&folder, &rate, PROVENANCE.version, PROVENANCE.adapter, &seed]);
    assert!(
        [format!("{frames} frames"), "no usd-core for this Python".into()].contains(&answer.trim().into()),
        "{answer}"
    );
}

/// A film that is written frame by frame, one that goes on and one that is written at once hold the same; so does the
/// first after each of its frames.
#[test]
fn usd_reads_every_frame() {
    let folder = tempfile::tempdir().unwrap();
    let mut writer = create(folder.path()).unwrap();
    for k in 0..3 {
        writer.append(&frame(k)).unwrap();
        let now = folder.path().join(k.to_string());
        std::fs::create_dir_all(now.join("bodies")).unwrap();
        for name in LAYERS {
            std::fs::copy(folder.path().join(name), now.join(name)).unwrap();
        }
        read_back(&now, k + 1);
    }
    drop(writer);
    // Behind the first two, as of a run that was killed.
    let times: Vec<f64> = film(2).iter().map(|frame| frame.time).collect();
    let mut writer = go_on(folder.path(), &times).unwrap();
    read_back(folder.path(), 2);
    for k in 2..5 {
        writer.append(&frame(k)).unwrap();
    }
    writer.sync().unwrap();
    read_back(folder.path(), 5);

    let whole = tempfile::tempdir().unwrap();
    write_usd(&whole.path().join("hair.usda"), 5).unwrap();
    assert_eq!(std::fs::read_dir(&whole).unwrap().count(), 1);
    read_back(whole.path(), 5);
}

/// Writes a film of so many frames as one file of format usd.
fn write_usd(path: &Path, frames: usize) -> Result<(), ExportError> {
    let (_, usd) = Format::of_films().find(|(format, _)| format.name == "usd").unwrap();
    (usd.write)(
        path,
        &Film {
            frames,
            frame: &|k| Ok(frame(k)),
            scenery: &scenery(),
            time: &time(),
            provenance: PROVENANCE,
            units: Units::default(),
        },
    )
}

/// Begins a film that grows.
fn create(folder: &Path) -> Result<UsdWriter, ExportError> {
    UsdWriter::create(folder, &frame(0).hair, scenery(), &time(), &PROVENANCE)
}

/// Goes on with it, behind frames of these times.
fn go_on(folder: &Path, times: &[f64]) -> Result<UsdWriter, ExportError> {
    UsdWriter::go_on(folder, &frame(0).hair, scenery(), &time(), times)
}

/// Strands of two groom files with the same numbers have their indices as `groom_id`.
#[test]
fn a_groom_id_is_of_one_curve() {
    for (ids, words) in [(vec![5, 0, 9], "[5, 0, 9]"), (vec![5, 0, 5], "[0, 1, 2]"), (vec![], "[0, 1, 2]")] {
        let folder = tempfile::tempdir().unwrap();
        let hair = HairFrame { ids, ..frame(0).hair };
        let mut writer = UsdWriter::create(folder.path(), &hair, scenery(), &time(), &PROVENANCE).unwrap();
        writer.append(&Frame { hair, ..frame(0) }).unwrap();
        let text = LAYERS.map(|name| std::fs::read_to_string(folder.path().join(name)).unwrap()).concat();
        let line = text.lines().find(|line| line.contains("primvars:groom_id")).unwrap();
        assert!(line.contains(words), "{line}");
    }
}

/// Frames are at whole time codes where a whole number of steps is as long as a frame, however the step is rounded;
/// else at the steps' own, which a note says.
#[test]
fn time_codes_are_whole_where_steps_fit() {
    for step in [1.0 / 600.0, 0.001_666_67, 1.0 / 60.0, 0.016_666_6] {
        let time = Time { step, ..time() };
        assert_eq!(time.uneven(), None, "{step}");
        for k in [0, 1, 7, 100_000] {
            assert_eq!(time.code(time.step_of_frame(k) as f64 * step), k as f64, "{step}");
        }
    }
    assert_eq!(Time { step: 0.001_666_67, ..time() }.code(0.001_666_67 * 25.0), 2.5);
    assert_eq!(time().code(12.0 * 1.38e-3), 0.9936);
    let note = time().uneven().unwrap();
    assert!(note.contains("time code 0.9936; time.step = 0.00138889 puts"), "{note}");
    assert_eq!(Time { step: 0.001_388_89, ..time() }.uneven(), None);
}

/// Wherever a process was ended within a write, the files show the frames before, and the film goes on behind them.
#[test]
fn a_frame_that_was_begun_is_not_seen() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = || LAYERS.map(|name| std::fs::read(folder.path().join(name)).unwrap());
    let mut writer = create(folder.path()).unwrap();
    writer.append(&frame(0)).unwrap();
    writer.append(&frame(1)).unwrap();
    let before = bytes();
    writer.append(&frame(2)).unwrap();
    let after = bytes();
    let times: Vec<f64> = film(2).iter().map(|frame| frame.time).collect();
    for part in [0.0, 0.3, 0.99, 1.0] {
        for ((name, before), after) in LAYERS.iter().zip(&before).zip(&after) {
            let end = before.len() + (part * (after.len() - before.len()) as f64) as usize;
            // The bytes at the end are written first; the end of the samples before, and the stage's last time code,
            // are written after.
            let begun = [before, &after[before.len()..end]].concat();
            std::fs::write(folder.path().join(name), begun).unwrap();
        }
        read_back(folder.path(), 2);
        let mut writer = go_on(folder.path(), &times).unwrap();
        writer.append(&frame(2)).unwrap();
        assert!(bytes() == after, "after {part} of a write");
    }
}

/// A frame that does not fit a film, or a film that is to go on, is refused in words, and the film stays as it was.
#[test]
fn invalid_frames_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut writer = create(folder.path()).unwrap();
    writer.append(&frame(0)).unwrap();
    writer.append(&frame(1)).unwrap();
    let spoils: [(&str, Spoil); 6] = [
        ("no strands", |f| f.hair = HairFrame::default()),
        ("not from 0 to the 10 points", |f| f.hair.offsets[3] = 9),
        ("other lengths", |f| f.hair.offsets[1] = 3),
        ("9 velocities, expected 10", |f| f.hair.velocities.truncate(9)),
        ("cannot follow", |f| f.time = frame(1).time),
        ("cannot follow", |f| f.time = f64::NAN),
    ];
    for (words, spoil) in spoils {
        let mut invalid = frame(2);
        spoil(&mut invalid);
        let error = writer.append(&invalid).unwrap_err().to_string();
        assert!(error.contains("hair.usda") && error.contains(words), "{error}");
    }
    drop(writer);
    let go_on = |frame: &Frame, times: &[f64]| UsdWriter::go_on(folder.path(), &frame.hair, scenery(), &time(), times);
    let mut other = frame(0);
    other.hair.ids[0] = 6;
    for (refused, words) in [
        (go_on(&other, &[0.0]), "other strands"),
        (go_on(&frame(0), &[0.0, 0.1]), "time code 6 as number 1"),
        (go_on(&frame(0), &[0.0, frame(1).time, frame(2).time]), "as number 2"),
    ] {
        let error = refused.map(drop).unwrap_err().to_string();
        assert!(error.contains(".usda") && error.contains(words), "{error}");
    }
    read_back(folder.path(), 2);
    let missing = folder.path().join("missing");
    let error = create(&missing).map(drop).unwrap_err().to_string();
    assert!(error.contains("missing") && error.contains("No such file"), "{error}");
    let error = write_usd(&missing.join("a.usda"), 1).unwrap_err().to_string();
    assert!(error.contains("a.usda") && error.contains("No such file"), "{error}");
}

/// Files that were cut or changed anywhere are refused, or the film goes on behind the frames that are whole; nothing
/// panics.
#[test]
fn altered_films_do_no_harm() {
    let whole = tempfile::tempdir().unwrap();
    let mut writer = create(whole.path()).unwrap();
    film(3).iter().for_each(|frame| writer.append(frame).unwrap());
    let times: Vec<f64> = film(2).iter().map(|frame| frame.time).collect();
    let mut state = 1_u32;
    let mut random = move |below: usize| {
        state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        (state >> 8) as usize % below
    };
    let (folder, mut refused) = (tempfile::tempdir().unwrap(), 0);
    std::fs::create_dir(folder.path().join("bodies")).unwrap();
    for round in 0..200 {
        for name in LAYERS {
            let mut bytes = std::fs::read(whole.path().join(name)).unwrap();
            let at = random(bytes.len());
            match round % 4 {
                _ if random(2) == 0 => {}
                0 => bytes.truncate(at),
                1 => bytes[at] = b'#',
                2 => bytes[at] = b'\n',
                _ => bytes[at] ^= 1 << random(8),
            }
            std::fs::write(folder.path().join(name), bytes).unwrap();
        }
        match go_on(folder.path(), &times) {
            Ok(mut writer) => writer.append(&frame(2)).unwrap(),
            Err(error) => {
                refused += 1;
                assert!(error.to_string().contains(".usda: "), "{error}");
            }
        }
    }
    // Measured 144 of 200.
    assert!((100..200).contains(&refused), "{refused}");
}
