//! Hostile files: whatever the bytes, each reader of files returns within a second and a gigabyte, and never panics.
//!
//! The functions that read are those of `fuzz/`, and so are the corpora. Here a corpus is replayed and mutated on
//! stable: pieces are changed, cut, doubled and swapped with those of other files, from a seed.
//! `WINDSWEPT_FUZZ_SECONDS` says for how long.
#![allow(clippy::unwrap_used, clippy::expect_used, missing_docs)]

#[path = "../fuzz/src/lib.rs"]
#[allow(dead_code, unreachable_pub)]
mod targets;

use std::{
    ffi::OsString,
    fs,
    panic::{AssertUnwindSafe, catch_unwind},
    path::{Path, PathBuf},
    sync::mpsc,
    thread,
    time::{Duration, Instant},
};

use rand::{Rng, SeedableRng, seq::IndexedRandom};
use rand_pcg::Pcg64;
use windswept::Checkpoint;
use windswept::export::VtkHdfReader;
use windswept_scene::{Curves, GroomFormat, Scene, Triangles};

/// Longest time that a reader may take, and most memory that the process may have used by then \[bytes\].
const LONGEST: Duration = Duration::from_secs(1);
const LARGEST: u64 = 1 << 30;
/// Twice this time, after which a reader is taken for one that never returns.
const PATIENCE: Duration = Duration::from_secs(30);
/// Size of all corpora \[bytes\].
const CORPORA: u64 = 1 << 20;
/// Mutated files per target, unless a time is given.
const FILES: u32 = 400;
/// Longest file that mutations make \[bytes\].
const LONGEST_FILE: usize = 1 << 16;
/// Words and numbers that readers look for.
const WORDS: &[&[u8]] = &[
    b"\xff\xff\xff\xff",
    b"\xff\xff\xff\x7f",
    b"\x00\x00\x00\x80",
    b"\x00\x00\x00\x00",
    b"\x01\x00\x00\x00",
    b"\x00\x00\xc0\x7f",
    b"\x00\x00\x80\xff",
    b"18446744073709551615",
    b"4294967296",
    b"-1",
    b"1e999",
    b"nan",
    b"inf",
    b"[[",
    b"{",
    b"\"",
    b"'''",
    b"\n",
    b"element vertex ",
    b"property list uchar int ",
    b"end_header\n",
    b"'shape': (",
    b"'descr': '<f8'",
    b"fortran_order",
    b"PK\x01\x02",
    b"PK\x03\x04",
    b"HAIR",
    b"f 1 -1 1000000000\n",
    b"v 1e38 -1e38 0\n",
    b"\nusemtl a\n",
    b"property list uchar int vertex_indices\n",
    b"\"byteOffset\":",
    b"\"count\":4294967295",
    b"glTF",
    b"JSON",
    b"\xff\xff\xff\xff\xff\xff\xff\xff",
    b"\x01\x00\x00\x00\x00\x00\x00\x00",
    b"\x00\x00\x00\x00\x00\x00\x00\x40",
];

fn corpus(name: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus").join(name);
    let mut files: Vec<_> = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(!files.is_empty(), "{}", folder.display());
    files
}

/// Reads bytes and returns the reader's fault. A reader that takes long is tried again, later each time: other
/// processes may have had the processor. A reader that does not return, as a C library may not, cannot be stopped: it
/// ends the program, and the bytes are kept.
fn fault(target: &targets::Target, bytes: &[u8]) -> Option<String> {
    let mut least = Duration::MAX;
    for pause in 0..8 {
        thread::sleep(Duration::from_millis(500) * pause);
        let started = Instant::now();
        let (read, copy) = (target.read, bytes.to_vec());
        let (returned, done) = mpsc::channel();
        thread::spawn(move || returned.send(catch_unwind(AssertUnwindSafe(|| read(&copy))).is_ok()));
        // Twice, as the program may have been stopped meanwhile.
        match done.recv_timeout(PATIENCE).or_else(|_| done.recv_timeout(PATIENCE)) {
            Ok(true) => (),
            Ok(false) => return Some("panics".to_owned()),
            Err(_) => {
                eprintln!("{} does not return: {}", target.name, keep(target.name, bytes).display());
                std::process::abort();
            }
        }
        least = least.min(started.elapsed());
        if least < LONGEST {
            return None;
        }
    }
    Some(format!("takes {least:?}"))
}

/// Keeps bytes that a reader fails on beside the tests' other outputs.
fn keep(name: &str, bytes: &[u8]) -> PathBuf {
    let kept = std::env::temp_dir().join(format!("windswept-{name}-{:08x}", crc32fast::hash(bytes)));
    fs::write(&kept, bytes).unwrap();
    kept
}

/// Most memory that this process has used, where the system tells it as Linux does \[bytes\].
fn peak() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.split_whitespace().next()?.parse::<u64>().ok().map(|kib| 1024 * kib)
}

/// Changes a file in one to six places.
fn mutated(files: &[Vec<u8>], rng: &mut Pcg64) -> Vec<u8> {
    let mut bytes = files.choose(rng).unwrap().clone();
    for _ in 0..rng.random_range(1..=6) {
        let at = rng.random_range(0..=bytes.len());
        let end = (at + [1, 4, 16, 256][rng.random_range(0..4)]).min(bytes.len());
        match rng.random_range(0..8) {
            0 if at < bytes.len() => bytes[at] ^= 1 << rng.random_range(0..8),
            1 => bytes[at..end].iter_mut().for_each(|byte| *byte = rng.random()),
            2 => bytes.truncate(at),
            3 => drop(bytes.drain(at..end)),
            4 => {
                let word = WORDS.choose(rng).unwrap();
                let end = if rng.random() { at } else { (at + word.len()).min(bytes.len()) };
                bytes.splice(at..end, word.iter().copied());
            }
            5 => {
                let piece = bytes[at..end].to_vec();
                bytes.splice(at..at, piece.repeat(rng.random_range(1..20)));
            }
            6 if bytes.len() >= 16 => {
                // A word of the file in the place of another: an address, a length.
                let [from, to] = [0; 2].map(|_| rng.random_range(0..bytes.len() / 8) * 8);
                bytes.copy_within(from..from + 8, to);
            }
            _ => {
                let other = files.choose(rng).unwrap();
                let from = rng.random_range(0..=other.len());
                let to = (from + 256).min(other.len());
                bytes.splice(at..end, other[from..to].iter().copied());
            }
        }
        bytes.truncate(LONGEST_FILE);
    }
    bytes
}

/// Replays a corpus, then mutates it. A file that a reader fails on is kept beside the tests' other outputs.
fn attack(name: &str) {
    let target = targets::TARGETS.iter().find(|target| target.name == name).unwrap();
    let files: Vec<Vec<u8>> = corpus(name).iter().map(|path| fs::read(path).unwrap()).collect();
    for (path, bytes) in corpus(name).iter().zip(&files) {
        assert_eq!(fault(target, bytes), None, "{}", path.display());
    }
    let seconds: Option<u64> = std::env::var("WINDSWEPT_FUZZ_SECONDS").ok().map(|text| text.parse().unwrap());
    let (started, mut count) = (Instant::now(), 0);
    let seed = seconds.map_or(1, |_| rand::random());
    let mut rng = Pcg64::seed_from_u64(seed);
    while seconds.map_or(count < FILES, |seconds| started.elapsed() < Duration::from_secs(seconds)) {
        count += 1;
        let bytes = mutated(&files, &mut rng);
        if let Some(fault) = fault(target, &bytes) {
            panic!("{name} {fault}: {}", keep(name, &bytes).display());
        }
    }
    let most = peak();
    println!("{name}: {} files, {count} of their mutants, seed {seed}; {most:?} bytes at most", files.len());
    assert!(most.is_none_or(|most| most < LARGEST), "{name}: {most:?} bytes");
}

/// A test per target; none is left out.
macro_rules! targets {
    ($($test:ident: $name:literal),+ $(,)?) => {
        $(
            #[test]
            fn $test() {
                attack($name);
            }
        )+

        #[test]
        fn every_target_has_its_test() {
            let names: Vec<_> = targets::TARGETS.iter().map(|target| target.name).collect();
            assert_eq!(names, [$($name),+]);
        }
    };
}

targets! {
    any_scene_is_read: "scene",
    any_checkpoint_is_read: "checkpoint",
    any_film_is_read: "film",
    any_hair_is_read: "hair",
    any_data_is_read: "data",
    any_bin_is_read: "bin",
    any_npz_is_read: "npz",
    any_npy_is_read: "npy",
    any_ply_is_read: "ply",
    any_obj_is_read: "obj",
    any_polygons_are_read: "polygons",
    any_glb_is_read: "glb",
}

/// The corpora stay small.
#[test]
fn corpora_are_small() {
    let files = targets::TARGETS.iter().flat_map(|target| corpus(target.name));
    let bytes: u64 = files.map(|path| fs::metadata(path).unwrap().len()).sum();
    assert!(bytes < CORPORA, "{bytes} bytes");
}

/// Exit status and standard error of the command.
fn windswept(arguments: &[&str]) -> (u8, String) {
    let (mut out, mut err) = (Vec::new(), Vec::new());
    let words = std::iter::once("windswept").chain(arguments.iter().copied()).map(OsString::from);
    let status = windswept_cli::run_on(words, &mut out, &mut err, false);
    (status, String::from_utf8_lossy(&err).into_owned())
}

/// Says how long something took, if it took too long or too much memory.
fn soon<T>(what: &str, run: impl FnOnce() -> T) -> T {
    let started = Instant::now();
    let result = run();
    let took = started.elapsed();
    assert!(took < LONGEST, "{what}: {took:?}");
    assert!(peak().is_none_or(|most| most < LARGEST), "{what}: {:?} bytes", peak());
    result
}

/// A sparse file of 2 GB, which has one line.
fn line_of_2_gb(path: &Path, start: &[u8]) {
    fs::write(path, start).unwrap();
    fs::File::options().write(true).open(path).unwrap().set_len(2_000_000_000).unwrap();
}

/// Files of a single line of 2 GB are refused before they are read.
#[test]
fn a_line_of_2_gb_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("long.toml");
    line_of_2_gb(&scene, b"title = \"");
    let said = soon("scene", || Scene::load(&scene).unwrap_err().to_string());
    assert!(said.contains("long.toml") && said.contains("at most"), "{said}");
    for (name, start) in
        [("a.ply", &b"ply\nformat ascii 1.0\ncomment "[..]), ("a.hair", b"HAIR"), ("a.npz", b"PK\x03\x04")]
    {
        let path = folder.path().join(name);
        line_of_2_gb(&path, start);
        let said = soon(name, || Curves::load(&path, None).unwrap_err().to_string());
        assert!(said.contains(name) && said.contains("at most"), "{said}");
    }
    let path = folder.path().join("a.windswept");
    line_of_2_gb(&path, b"\x89WSWP\x0d\x0a\x1a");
    let said = soon("checkpoint", || windswept::Checkpoint::open(&path).unwrap_err().to_string());
    assert!(said.contains("a.windswept"), "{said}");
}

/// Counts that overflow, in a scene and in the heads of groom files.
#[test]
fn overflowing_sizes_are_errors() {
    let scene = |keys: &[&str]| {
        let sets: Vec<String> = keys.iter().map(|key| (*key).to_owned()).collect();
        let text = include_str!("../examples/scenes/quick.toml");
        soon(&format!("{keys:?}"), || {
            let scene = Scene::parse_with("quick.toml", text, &sets);
            scene.and_then(|scene| windswept_scene::InitialState::new(&scene).map(|_| ())).unwrap_err().to_string()
        })
    };
    // 1e12 particles of air, in a large box and of little mass, and 1e12 strands and points.
    assert!(scene(&["air.box.max=[48, 48, 48]", "air.spacing=4.77e-4"]).contains("particles"));
    assert!(scene(&["hair.strands=1000000000000"]).contains("hair.strands"));
    assert!(scene(&["hair.strands=16777216", "hair.points=16384"]).contains("points"));
    assert!(scene(&["hair.points=18446744073709551616"]).contains("hair.points"));
    assert!(scene(&["time.duration=1e18", "time.step=1e-18"]).contains("steps"));
    assert!(scene(&["turbulence={bands=[{ scale = 1e-9 }]}"]).contains("turbulence"));
    let npy = |shape: &str| {
        let head = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({shape}), }}");
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((head.len() as u16).to_le_bytes());
        bytes.extend(head.as_bytes());
        bytes
    };
    let mut hair = b"HAIR".to_vec();
    hair.extend([0xff; 124]);
    let ply = |count: &str| {
        let head = format!(
            "ply\nformat binary_little_endian 1.0\nelement vertex {count}\nproperty double x\n\
                            property double y\nproperty double z\nend_header\n"
        );
        head.into_bytes()
    };
    let files = [
        ("npy", npy("4294967296, 4294967296, 3")),
        ("npy", npy("18446744073709551615, 2, 3")),
        ("npy", npy("99999999999999999999999, 2, 3")),
        ("hair", hair),
        ("ply", ply("18446744073709551615")),
        ("ply", ply("4000000000")),
        ("data", [0xff; 64].to_vec()),
        ("bin", [0xff; 64].to_vec()),
    ];
    for (extension, bytes) in files {
        let format = windswept_scene::GroomFormat::ALL.iter().find(|format| format.extension == extension).unwrap();
        let said = soon(extension, || format.read(&bytes, Some(4)).unwrap_err().to_string());
        assert!(!said.is_empty(), "{extension}");
    }
}

/// Paths that lead nowhere, to themselves, or out of the scene's folder: an error, or the file that they name; nothing
/// is written anywhere but where `--out` says.
#[test]
fn odd_paths_are_errors() {
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str| folder.path().join(name);
    let scene = |file: &str| {
        let text = format!(
            "time = {{ step = 1e-3, duration = 0.01 }}\ninteraction.model = \"none\"\n[hair]\nscale = 1.0\nfile = {file:?}\n"
        );
        fs::write(place("scene.toml"), text).unwrap();
        let (scene, out) = (place("scene.toml"), place("out"));
        soon(file, || windswept(&["run", scene.to_str().unwrap(), "--out", out.to_str().unwrap()]))
    };
    fs::create_dir(place("folder.hair")).unwrap();
    let (status, said) = scene("/etc/passwd");
    assert!(status == 2 && said.contains("scene.toml:5: hair.file: expected a path relative"), "{said}");
    let odd = ["scene.toml", "", ".", "..", "/", "folder.hair", "none.hair", "/none/none.npz", "a\0b.hair", "~/x.ply"];
    for file in odd {
        let (status, said) = scene(file);
        assert_eq!(status, 2, "{file:?}: {said}");
        assert!(said.contains("scene.toml") || said.contains(file), "{file:?}: {said}");
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::symlink;
        symlink("loop.hair", place("loop.hair")).unwrap();
        symlink("/dev/zero", place("endless.hair")).unwrap();
        for file in ["loop.hair", "endless.hair"] {
            let (status, said) = scene(file);
            assert_eq!(status, 2, "{file}: {said}");
            assert!(said.contains(file), "{said}");
        }
        let (status, said) = soon("/dev/zero", || windswept(&["check", "/dev/zero"]));
        assert!(status == 2 && said.contains("/dev/zero"), "{said}");
    }
    assert!(!place("out").exists(), "a refused run has written");
}

/// Files that mutants are made of are read: mutants of a file that is refused at its first byte would show nothing.
#[test]
fn corpora_are_read() {
    for (name, extension) in [("obj", "obj"), ("polygons", "ply"), ("glb", "glb")] {
        for path in corpus(name) {
            let read = Triangles::read(extension, &fs::read(&path).unwrap());
            assert!(read.is_ok_and(|mesh| mesh.corners.len() > 1), "{}", path.display());
        }
    }
    for format in GroomFormat::ALL {
        let reads = |path: &PathBuf| format.read(&fs::read(path).unwrap(), None).is_ok_and(|curves| curves.len() > 1);
        assert!(corpus(format.extension).iter().any(reads), "no file of {}", format.extension);
    }
    assert!(corpus("scene").iter().any(|path| Scene::load(path).is_ok()), "no scene");
    for path in corpus("film") {
        let read = VtkHdfReader::open(&path).map(|film| film.times().len());
        assert!(matches!(read, Ok(3)), "{}: {read:?}", path.display());
    }
    for path in corpus("checkpoint") {
        let read = Checkpoint::open(&path);
        assert!(read.is_ok(), "{}; Simulation::save makes a file of the format of today", read.err().unwrap());
    }
}
