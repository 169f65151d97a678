//! USD's own library sees what was written, at every moment of it.

#![allow(clippy::unwrap_used)] // a test may panic

mod film;
mod python;

use std::path::Path;

use windswept_engine::{Frame, HairFrame};
use windswept_export::{ExportError, Film, Format, Units, UsdWriter};

use film::{PROVENANCE, dump, film, frame};

const RATE: f64 = 60.0;

/// Makes a frame one that does not fit.
type Spoil = fn(&mut Frame);

/// Has usd_back.py compare the stages of this folder with plain dumps of the film.
fn read_back(folder: &Path, frames: usize) {
    dump(folder, &film(frames));
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
    let mut writer = UsdWriter::create(folder.path(), &frame(0).hair, RATE, &PROVENANCE).unwrap();
    for k in 0..3 {
        writer.append(&frame(k)).unwrap();
        let now = folder.path().join(k.to_string());
        std::fs::create_dir(&now).unwrap();
        for name in UsdWriter::FILES {
            std::fs::copy(folder.path().join(name), now.join(name)).unwrap();
        }
        read_back(&now, k + 1);
    }
    drop(writer);
    // Behind the first two, as of a run that was killed.
    let times: Vec<f64> = film(2).iter().map(|frame| frame.time).collect();
    let mut writer = UsdWriter::go_on(folder.path(), &frame(0).hair, RATE, &times).unwrap();
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
        &Film { frames, frame: &|k| Ok(frame(k)), rate: RATE, provenance: PROVENANCE, units: Units::default() },
    )
}

/// Wherever a process was ended within a write, the files show the frames before, and the film goes on behind them.
#[test]
fn a_frame_that_was_begun_is_not_seen() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = || UsdWriter::FILES.map(|name| std::fs::read(folder.path().join(name)).unwrap());
    let mut writer = UsdWriter::create(folder.path(), &frame(0).hair, RATE, &PROVENANCE).unwrap();
    writer.append(&frame(0)).unwrap();
    writer.append(&frame(1)).unwrap();
    let before = bytes();
    writer.append(&frame(2)).unwrap();
    let after = bytes();
    let times: Vec<f64> = film(2).iter().map(|frame| frame.time).collect();
    for part in [0.0, 0.3, 0.99, 1.0] {
        for ((name, before), after) in UsdWriter::FILES.iter().zip(&before).zip(&after) {
            let end = before.len() + (part * (after.len() - before.len()) as f64) as usize;
            // The bytes at the end are written first; the stage's last time code, and the end of the samples before,
            // are written after.
            let begun = [before, &after[before.len()..end]].concat();
            std::fs::write(folder.path().join(name), begun).unwrap();
        }
        read_back(folder.path(), 2);
        let mut writer = UsdWriter::go_on(folder.path(), &frame(0).hair, RATE, &times).unwrap();
        writer.append(&frame(2)).unwrap();
        assert!(bytes() == after, "after {part} of a write");
    }
}

/// A frame that does not fit a film, or a film that is to go on, is refused in words, and the film stays as it was.
#[test]
fn invalid_frames_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut writer = UsdWriter::create(folder.path(), &frame(0).hair, RATE, &PROVENANCE).unwrap();
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
    let go_on = |frame: &Frame, times: &[f64]| UsdWriter::go_on(folder.path(), &frame.hair, RATE, times);
    let mut other = frame(0);
    other.hair.ids[0] = 6;
    for (refused, words) in [
        (go_on(&other, &[0.0]), "other strands"),
        (go_on(&frame(0), &[0.0, 0.1]), "time code 6 as number 1"),
        (go_on(&frame(0), &[0.0, frame(1).time, frame(2).time]), "as number 2"),
    ] {
        let error = refused.map(drop).unwrap_err().to_string();
        assert!(error.contains("hair.usda") && error.contains(words), "{error}");
    }
    read_back(folder.path(), 2);
    let missing = folder.path().join("missing");
    let error = UsdWriter::create(&missing, &frame(0).hair, RATE, &PROVENANCE).map(drop).unwrap_err().to_string();
    assert!(error.contains("missing") && error.contains("No such file"), "{error}");
    let error = write_usd(&missing.join("a.usda"), 1).unwrap_err().to_string();
    assert!(error.contains("a.usda") && error.contains("No such file"), "{error}");
}

/// Files that were cut or changed anywhere are refused, or the film goes on behind the frames that are whole; nothing
/// panics.
#[test]
fn altered_films_do_no_harm() {
    let whole = tempfile::tempdir().unwrap();
    let mut writer = UsdWriter::create(whole.path(), &frame(0).hair, RATE, &PROVENANCE).unwrap();
    film(3).iter().for_each(|frame| writer.append(frame).unwrap());
    let times: Vec<f64> = film(2).iter().map(|frame| frame.time).collect();
    let mut state = 1_u32;
    let mut random = move |below: usize| {
        state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        (state >> 8) as usize % below
    };
    let (folder, mut refused) = (tempfile::tempdir().unwrap(), 0);
    for round in 0..200 {
        for name in UsdWriter::FILES {
            let mut bytes = std::fs::read(whole.path().join(name)).unwrap();
            let at = random(bytes.len());
            match round % 4 {
                0 => bytes.truncate(at),
                1 => bytes[at] = b'#',
                2 => bytes[at] = b'\n',
                _ => bytes[at] ^= 1 << random(8),
            }
            std::fs::write(folder.path().join(name), bytes).unwrap();
        }
        match UsdWriter::go_on(folder.path(), &frame(0).hair, RATE, &times) {
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
