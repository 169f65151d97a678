//! Frames and files that must be refused, in words that name the file and the number.

#![cfg(feature = "vtkhdf")]
#![allow(clippy::unwrap_used)] // a test may panic

mod film;

use windswept_engine::Frame;
use windswept_export::{ExportError, Kind, VtkHdfReader, VtkHdfWriter};

use film::{PROVENANCE, assert_holds, film, frame, write};

/// Makes a frame one that does not fit.
type Spoil = fn(&mut Frame);

/// A frame that differs from the file in any count is refused, and the file keeps the frames it had.
#[test]
fn frames_of_another_size_are_refused() {
    let faults: [(Kind, &str, Spoil); 13] = [
        (Kind::Hair, "9 positions", |f| f.hair.positions.truncate(9)),
        (Kind::Hair, "9 velocities", |f| f.hair.velocities.truncate(9)),
        (Kind::Hair, "6 orientations", |f| f.hair.orientations.truncate(6)),
        (Kind::Hair, "2 root frames", |f| f.hair.root_frames.truncate(2)),
        (Kind::Hair, "other lengths", |f| f.hair.offsets[1] = 3),
        (Kind::Hair, "other lengths", |f| f.hair.offsets = vec![0, 7, 10]),
        (Kind::Air, "6 positions", |f| f.air.positions.truncate(6)),
        (Kind::Air, "8 velocities", |f| f.air.velocities.push([0.0; 3])),
        (Kind::Air, "6 values of Vorticity", |f| f.air.vorticity.truncate(6)),
        (Kind::Air, "the scalars [\"Vorticity\"], the file", |f| f.air.band_energy.clear()),
        (Kind::Air, "at NaN s", |f| f.time = f64::NAN),
        (Kind::Hair, "the one before at 0.01656 s; expected a later one", |f| f.time = frame(1).time),
        (Kind::Air, "at 0.01 s, the one before at 0.01656 s", |f| f.time = 0.01),
    ];
    let folder = tempfile::tempdir().unwrap();
    for (kind, words, spoil) in faults {
        let path = folder.path().join("film.vtkhdf");
        let mut writer = VtkHdfWriter::create(&path, kind, &frame(0), 3, &PROVENANCE).unwrap();
        writer.append(&frame(0)).unwrap();
        writer.append(&frame(1)).unwrap();
        let mut invalid = frame(2);
        spoil(&mut invalid);
        expect(writer.append(&invalid), &["film.vtkhdf", "frame 2", words]);
        writer.append(&frame(2)).unwrap();
        expect(writer.append(&frame(3)), &["film.vtkhdf", "frame 3", "the 3 announced"]);
        writer.finish().unwrap();
        assert_holds(&path, kind, &film(3));
    }
}

/// A frame that cannot be laid out is refused before the file is touched.
#[test]
fn senseless_layouts_are_refused() {
    let faults: [(Kind, usize, &str, Spoil); 8] = [
        (Kind::Hair, 2, "no strands", |f| f.hair = Default::default()),
        (Kind::Air, 2, "no air particles", |f| f.air = Default::default()),
        (Kind::Hair, 2, "to the 10 points", |f| f.hair.offsets = Vec::new()),
        (Kind::Hair, 2, "to the 10 points", |f| f.hair.offsets = vec![1, 10]),
        (Kind::Hair, 2, "to the 10 points", |f| f.hair.offsets = vec![0, 11]),
        (Kind::Hair, 2, "strand 1 has fewer", |f| f.hair.offsets = vec![0, 5, 6, 10]),
        (Kind::Hair, 2, "strand 1 has fewer", |f| f.hair.offsets = vec![0, 12, 2, 10]),
        (Kind::Air, usize::MAX, "fit into no file", |_| ()),
    ];
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("film.vtkhdf");
    write(&path, Kind::Air, &film(2), 2);
    for (kind, frames, words, spoil) in faults {
        let mut invalid = frame(0);
        spoil(&mut invalid);
        let refused = VtkHdfWriter::create(&path, kind, &invalid, frames, &PROVENANCE);
        expect(refused.map(drop), &["film.vtkhdf", words]);
        assert_holds(&path, Kind::Air, &film(2));
    }
}

/// A film goes on only with as many frames as it has, of its own kind and its own strands; it is left as it was.
#[test]
fn a_film_of_something_else_does_not_go_on() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("film.vtkhdf");
    write(&path, Kind::Hair, &film(2), 4);
    let mut other = frame(0);
    other.hair.offsets[1] = 3;
    for (kind, frame, written, words) in [
        (Kind::Hair, frame(0), 3, "has 2 frames, expected the first 3"),
        (Kind::Air, frame(0), 1, "other strands or particles"),
        (Kind::Hair, other, 1, "other strands or particles"),
    ] {
        let refused = VtkHdfWriter::go_on(&path, kind, &frame, written, 4, &PROVENANCE);
        expect(refused.map(drop), &["film.vtkhdf", words]);
    }
    let none = VtkHdfWriter::go_on(folder.path().join("none.vtkhdf"), Kind::Hair, &frame(0), 1, 4, &PROVENANCE);
    expect(none.map(drop), &["none.vtkhdf", "No such file"]);
    std::fs::write(folder.path().join("text.vtkhdf"), "text").unwrap();
    let text = VtkHdfWriter::go_on(folder.path().join("text.vtkhdf"), Kind::Hair, &frame(0), 1, 4, &PROVENANCE);
    expect(text.map(drop), &["text.vtkhdf", "could not be read"]);
    assert_holds(&path, Kind::Hair, &film(2));
}

/// A path that cannot be written is an error that names it and the system's reason.
#[test]
fn unwritable_paths_are_named() {
    let folder = tempfile::tempdir().unwrap();
    for (path, reason) in [("missing/film.vtkhdf", "No such file"), ("", "is a directory")] {
        let path = folder.path().join(path);
        let refused = VtkHdfWriter::create(&path, Kind::Hair, &frame(0), 2, &PROVENANCE);
        assert!(matches!(refused, Err(ExportError::File { .. })));
        expect(refused.map(drop), &[&path.display().to_string(), reason]);
    }
}

/// A file that is not ours, or not whole, is refused in words.
#[test]
fn foreign_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("film.vtkhdf");
    let read = || VtkHdfReader::open(&path).and_then(|reader| reader.frame(0)).map(drop);
    expect(read(), &["film.vtkhdf", "No such file"]);
    for text in [&b""[..], b"not HDF5 at all", &[0xff; 4096]] {
        std::fs::write(&path, text).unwrap();
        expect(read(), &["film.vtkhdf", "could not be read"]);
    }
    std::fs::remove_file(&path).unwrap();
    drop(hdf5::File::create(&path).unwrap());
    expect(read(), &["film.vtkhdf", "could not be read"]);
    for kind in [Kind::Hair, Kind::Air] {
        write(&path, kind, &film(3), 3);
        let whole = std::fs::read(&path).unwrap();
        // Cut anywhere: an error or the right frames, never a panic.
        for part in [0.05, 0.3, 0.6, 0.9, 0.999] {
            std::fs::write(&path, &whole[..(part * whole.len() as f64) as usize]).unwrap();
            expect(read(), &["film.vtkhdf"]);
        }
    }
    write(&path, Kind::Hair, &film(2), 9);
    let reader = VtkHdfReader::open(&path).unwrap();
    expect(reader.frame(2).map(drop), &["film.vtkhdf", "frame 2 was asked for, the file has 2"]);
}

/// A film whose structures lead in a circle, onto one another or beyond is read or refused, in words: libhdf5 would
/// follow them for ever, or make room for what is not there.
#[test]
fn films_that_lead_in_circles_are_read_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("film.vtkhdf");
    write(&path, Kind::Hair, &film(2), 2);
    let whole = std::fs::read(&path).unwrap();
    let find = |words: &[u8]| whole.windows(words.len()).position(|bytes| bytes == words).unwrap();
    let number = |at: usize| u64::from_le_bytes(whole[at..at + 8].try_into().unwrap());
    // The free space of the first local heap, the space left in the first global heap behind its texts, and the first
    // symbol.
    let (heap, texts, symbols) = (find(b"HEAP"), find(b"GCOL"), find(b"SNOD"));
    let free = number(heap + 24) + number(heap + 16);
    let mut left = texts + 16;
    while whole[left..left + 2] != [0; 2] {
        left += 16 + number(left + 8).next_multiple_of(8) as usize;
    }
    // Where the attribute of the adapter says how long its text is, and that it is the second of that heap.
    let text = PROVENANCE.adapter.len() as u64;
    let adapter = find(&[&(text as u32).to_le_bytes()[..], &(texts as u64).to_le_bytes()].concat());
    let longer = number(adapter) | 1 << 31;
    for (at, value, refused) in [
        (adapter, longer, None),
        (free as usize, number(heap + 16), None),
        (left + 8, 0, None),
        (symbols + 16, 96, Some("it has no Steps/PartOffsets".to_owned())),
        (symbols + 16, 1 << 62, Some(format!("16 bytes at byte {} do not lie within the file", 1_u64 << 62))),
    ] {
        let mut bytes = whole.clone();
        bytes[at..at + 8].copy_from_slice(&value.to_le_bytes());
        std::fs::write(&path, bytes).unwrap();
        let read = VtkHdfReader::open(&path).map(|film| film.origin());
        let gone_on = || VtkHdfWriter::go_on(&path, Kind::Hair, &frame(0), 1, 2, &PROVENANCE).map(drop);
        match refused {
            Some(words) => {
                expect(read.map(drop), &["film.vtkhdf: could not be read: expected a film as windswept", &words]);
                expect(gone_on(), &["film.vtkhdf: could not be read", &words]);
            }
            None => {
                let adapter_is_lost = at == adapter;
                assert_eq!(read.unwrap()[0].is_empty(), adapter_is_lost);
                gone_on().unwrap();
                assert_holds(&path, Kind::Hair, &film(1));
            }
        }
    }
}

/// Asserts that it failed with a message that holds these words.
fn expect(result: Result<(), ExportError>, words: &[&str]) {
    let message = result.expect_err("must be refused").to_string();
    for word in words {
        assert!(message.contains(word), "{word:?} is missing in {message:?}");
    }
}
