//! Groom files: the same curves out as in, in every format; a broken file is an error that says where.

use std::path::Path;

use crate::common::{Folder, deflated, load, parse, zeros_of};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use windswept_scene::{
    CheckedScene, Curves, End, Fibre, Groom, GroomFile, GroomFormat, HairSource, InitialState, Moduli, RestShape,
    Scene, Stiffness, Triangles, Up, Warning, npy_head,
};

fn f32s(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|x| x.to_le_bytes()).collect()
}

/// A `.hair` file, written from the description of the format: 128 bytes of header, then arrays.
fn hair_file(strands: &[Vec<[f32; 3]>], thickness: Option<&[f32]>) -> Vec<u8> {
    let points: usize = strands.iter().map(Vec::len).sum();
    let mut bytes = b"HAIR".to_vec();
    let arrays = 0b11 + if thickness.is_some() { 0b100 } else { 0 };
    for number in [strands.len() as u32, points as u32, arrays, 0] {
        bytes.extend(number.to_le_bytes());
    }
    bytes.extend(f32s(&[0.1, 0.0, 1.0, 1.0, 1.0]));
    bytes.resize(128, 0);
    bytes.extend(strands.iter().flat_map(|strand| (strand.len() as u16 - 1).to_le_bytes()));
    bytes.extend(strands.iter().flat_map(|strand| f32s(strand.as_flattened())));
    bytes.extend(thickness.map(f32s).unwrap_or_default());
    bytes
}

/// Wavy strands of 2 to 33 points, on a sphere of 10 units.
fn strands(count: usize) -> Vec<Vec<[f32; 3]>> {
    let mut rng = Pcg64::seed_from_u64(7);
    let strand = |_| {
        let root: [f32; 3] = [0, 1, 2].map(|_| rng.random_range(-10.0..10.0));
        let n = rng.random_range(2..34);
        let point = |k: i32| {
            let t = k as f32;
            [root[0] + 0.3 * (0.5 * t).sin(), root[1] - 0.5 * t, root[2] + 0.2 * (0.7 * t).cos()]
        };
        (0..n).map(point).collect()
    };
    (0..count).map(strand).collect()
}

/// 10 000 strands, an odd number of them in all, come back from every format as they were, in their order.
#[test]
fn strands_come_back_as_they_were() {
    let folder = Folder::new();
    let given = strands(10_001);
    let points: Vec<[f32; 3]> = given.iter().flatten().copied().collect();
    let thickness: Vec<f32> = (0..points.len()).map(|i| 0.01 + 1e-6 * i as f32).collect();
    let path = folder.write("in.hair", &hair_file(&given, Some(&thickness)));
    let curves = Curves::load(&path, None).unwrap();
    assert_eq!((curves.len(), curves.points.len()), (10_001, points.len()));
    assert_eq!(curves.ids, (0..10_001).collect::<Vec<u32>>());
    for (s, strand) in given.iter().enumerate() {
        assert_eq!(curves.strand(s), strand.iter().map(|x| x.map(f64::from)).collect::<Vec<_>>());
    }
    assert!(curves.radius.iter().zip(&thickness).all(|(radius, thickness)| *radius == 0.5 * f64::from(*thickness)));
    for format in GroomFormat::ALL.iter().filter(|format| format.writes()) {
        let path = folder.path().join(format!("out.{}", format.extension));
        if format.extension == "npy" {
            assert!(curves.save(&path).unwrap_err().message().contains("expected a .npz file"));
            let even = curves.resampled(9);
            even.save(&path).unwrap();
            assert_eq!(Curves::load(&path, None).unwrap().points, even.points);
            continue;
        }
        curves.save(&path).unwrap();
        let back = Curves::load(&path, None).unwrap();
        assert_eq!((&back.offsets, &back.ids), (&curves.offsets, &curves.ids), ".{}", format.extension);
        // Measured 0: files of 32 bits hold what a file of 32 bits held.
        assert_eq!(back.points, curves.points, ".{}", format.extension);
        assert_eq!(back.radius.is_empty(), format.extension == "data");
        assert!(back.radius.is_empty() || back.radius == curves.radius, ".{}", format.extension);
    }
    // Strands keep the file's numbers where some are left out, and the archive knows the unit.
    let (fit, dropped) = Curves { ids: curves.ids.iter().map(|id| 2 * id).collect(), ..curves }
        .in_metres(0.01, Up::Y)
        .guides(Some(100), 1)
        .fit();
    assert_eq!((fit.len(), dropped.total()), (100, 0));
    let path = folder.path().join("few.npz");
    fit.save(&path).unwrap();
    assert_eq!(Curves::load(&path, None).unwrap(), fit);
    assert!(fit.ids.is_sorted() && fit.ids.iter().all(|id| id % 2 == 0) && fit.unit == Some(1.0));
}

/// MonoHair's files have numbers alone in place of a header.
#[test]
fn files_of_monohair_are_read() {
    let folder = Folder::new();
    let strands = strands(7);
    let whole = Curves::load(folder.write("whole.hair", &hair_file(&strands, None)), None).unwrap();
    let total = strands.iter().map(Vec::len).sum::<usize>() as u32;
    let mut bytes: Vec<u8> = [strands.len() as u32, total].into_iter().flat_map(u32::to_le_bytes).collect();
    bytes.extend(strands.iter().flat_map(|strand| (strand.len() as u16).to_le_bytes()));
    bytes.extend(strands.concat().as_flattened().iter().flat_map(|x| x.to_le_bytes()));
    assert_eq!(Curves::load(folder.write("short.hair", &bytes), None).unwrap(), whole);
    bytes[8] += 1;
    let error = Curves::load(folder.write("other.hair", &bytes), None).unwrap_err().to_string();
    assert!(error.contains("at byte 4: expected the ") && error.contains("points that the strands have"), "{error}");
    bytes.push(0);
    let error = Curves::load(folder.write("longer.hair", &bytes), None).unwrap_err().to_string();
    assert!(error.contains("expected the word HAIR"), "{error}");
}

/// Every count that a header can hold, however large: an error, and no room is made for it.
#[test]
fn counts_beyond_the_file_are_errors() {
    let folder = Folder::new();
    let refused = |name: &str, bytes: &[u8], expected: &[&str]| {
        let error = Curves::load(folder.write(name, bytes), None).unwrap_err().to_string();
        assert!(expected.iter().all(|words| error.contains(words)), "{error}");
    };
    let hair = hair_file(&strands(3), None);
    let with = |at: usize, number: u32| {
        let mut bytes = hair.clone();
        bytes[at..at + 4].copy_from_slice(&number.to_le_bytes());
        bytes
    };
    refused("a.hair", b"HAI", &["at byte 0", "the word HAIR", "ends at byte 3"]);
    refused("a.hair", b"PNG of some length", &["found \"PNG \""]);
    refused("a.hair", &with(4, u32::MAX), &["at byte 128", "the segments of each strand", "ends at byte"]);
    refused("a.hair", &with(8, u32::MAX), &["at byte 8", "found 4294967295"]);
    refused("a.hair", &with(12, 1), &["at byte 12", "bit 1 (points)"]);
    refused("a.hair", &with(12, 1 << 20), &["at byte 12"]);
    let mut lone = with(4, u32::MAX);
    lone[8..20].copy_from_slice(&[0xff, 0xff, 0xff, 0xff, 2, 0, 0, 0, 0, 0, 0, 0]);
    refused("a.hair", &lone, &["at byte 128", "the points"]);
    let mut none = with(16, u32::MAX);
    none[4..16].copy_from_slice(&[0, 0, 0, 0, 0, 0, 0, 0, 2, 0, 0, 0]);
    none.truncate(128);
    assert!(Curves::load(folder.write("no_strands.hair", &none), None).unwrap().is_empty());
    refused("a.hair", &hair[..hair.len() - 1], &[&format!("ends at byte {}", hair.len() - 1)]);
    refused("a.hair", &[&hair[..], b"x"].concat(), &["expected the end of the file, found 1 bytes more"]);
    refused("a.data", &u32::MAX.to_le_bytes(), &["at least 0; found -1"]);
    refused("a.data", &i32::MAX.to_le_bytes(), &["at byte 4", "the strands"]);
    refused("a.bin", &[1, 0, 0, 0, 0xff, 0xff, 0xff, 0x7f], &["at byte 8", "2147483647 points of strand 0"]);
    let npy =
        |header: &str| [b"\x93NUMPY\x01\x00", &(header.len() as u16).to_le_bytes()[..], header.as_bytes()].concat();
    refused(
        "a.npy",
        &npy("{'descr': '<f4', 'fortran_order': False, 'shape': (99999999999, 9, 3), }"),
        &["the numbers"],
    );
    refused("a.npy", &npy("{'descr': '<f4', 'fortran_order': False, 'shape': (99999999999, 0, 3), }"), &["points"]);
    refused("a.npy", &npy("{'descr': '|O', 'fortran_order': False, 'shape': (9, 9, 3), }"), &["found \"O\""]);
    refused("a.npy", &npy("{'descr': '<f4', 'fortran_order': False, 'shape': (-1, 9, 3), }"), &["a shape of whole"]);
    refused("a.npz", b"PK\x03\x04", &["zip archive"]);
    let npz = folder.path().join("whole.npz");
    Curves::load(folder.write("whole.hair", &hair_file(&strands(31), None)), None).unwrap().save(&npz).unwrap();
    let whole = std::fs::read(npz).unwrap();
    let last = whole.len() - 19;
    refused("a.npz", &[&whole[..], b"abc"].concat(), &[&format!("at byte {last}: expected the archive's last record")]);
    let at = whole.windows(10).position(|bytes| bytes == b"points.npy").unwrap();
    let mut altered = whole.clone();
    altered[at + 200] ^= 0x55;
    refused("a.npz", &altered, &["points: at byte 0: expected", "bytes with the checksum that the archive says"]);
    let ply = |body: &str| format!("ply\nformat binary_little_endian 1.0\n{body}end_header\n");
    let vertex = "element vertex 18446744073709551615\nproperty float x\nproperty float y\nproperty float z\n";
    refused("a.ply", ply(vertex).as_bytes(), &["18446744073709551615 rows of element vertex: the file ends"]);
    refused("a.ply", ply("element vertex 0\nproperty float x\n").as_bytes(), &["a property y"]);
    refused("a.ply", ply("property float x\n").as_bytes(), &["Property without element"]);
    refused("a.ply", ply("element junk 18446744073709551615\n").as_bytes(), &["element junk to have a property"]);
    refused("a.ply", ply("").as_bytes(), &["expected an element vertex"]);
    refused("a.usd", b"", &[".hair, .data, .bin, .npz, .npy, .ply"]);
    let error = Curves::load(folder.path(), None).unwrap_err();
    assert!(error.message().contains("expected a"), "{error}");
    let error = Curves::load(folder.path().join("none.hair"), None).unwrap_err();
    assert!(error.message().contains("cannot be read"), "{error}");
}

/// A second element of vertices, strands or faces is refused where it is said, in a groom and in a mesh: points of the
/// first one that have a thickness or a normal of their own would make lists of different lengths.
#[test]
fn elements_of_ply_files_are_there_once() {
    let vertex = "element vertex 1\nproperty float x\nproperty float y\nproperty float z\n";
    let strand = "element strand 1\nproperty ushort nsegs\n";
    let face = "element face 1\nproperty list uchar int vertex_indices\n";
    let head = format!("ply\nformat ascii 1.0\n{vertex}{strand}{face}");
    let format = GroomFormat::ALL.iter().find(|format| format.extension == "ply").unwrap();
    for (name, again) in
        [("vertex", &format!("{vertex}property float thickness\n")[..]), ("strand", strand), ("face", face)]
    {
        let text = format!("{head}{again}end_header\n0 0 0\n0\n3 0 0 0\n0 0 0 1\n");
        let expected = format!("in the header: expected one element {name}, found a second");
        assert_eq!(format.read(text.as_bytes(), None).unwrap_err().message(), expected);
        assert_eq!(Triangles::read("ply", text.as_bytes()).unwrap_err().message(), expected);
    }
}

/// Elements and properties of `.ply` files stand in any order, beside others.
#[test]
fn elements_of_ply_files_have_any_order() {
    let text = include_bytes!("../../../fuzz/corpus/ply/text.ply");
    let ply = GroomFormat::ALL.iter().find(|format| format.extension == "ply").unwrap();
    let curves = ply.read(text, None).unwrap();
    assert_eq!((curves.offsets.len(), curves.strand(0)), (3, &[[0.0, 1.0, 0.0], [0.0, 2.0, 0.0]][..]));
    assert_eq!(curves.strand(1)[1], [5.0, 4.0, f64::from(0.1_f32)]);
}

/// Files without an end of strands: equally many points each, once it is said how many.
#[test]
fn equal_strands_need_their_number_of_points() {
    let folder = Folder::new();
    let text = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nend_header\n\
                0 0 0\n0 1 0\n5 0 0\n5 1 0";
    let path = folder.write("gaussian.ply", text.as_bytes());
    let refused = |points| Curves::load(&path, points).unwrap_err().to_string();
    assert!(refused(None).ends_with(
        "gaussian.ply: points_per_strand: the 4 points do not say where a strand ends: expected how many points each strand has"
    ));
    assert!(refused(Some(3)).contains("divides the 4 points"));
    assert!(refused(Some(0)).contains("divides the 4 points"));
    let curves = Curves::load(&path, Some(2)).unwrap();
    assert_eq!(curves.offsets, [0, 2, 4]);
    assert_eq!(curves.strand(1), [[5.0, 0.0, 0.0], [5.0, 1.0, 0.0]]);
}

/// A fault of a file that an assignment names is the assignment's, and so is that of a key that the file then needs;
/// else it is the line's.
#[test]
fn the_file_of_an_assignment_is_its_fault() {
    let folder = Folder::new();
    let strand: Vec<_> = (0..4).map(|k| [0.0, -0.1 * k as f32, 0.0]).collect();
    folder.write("unit.hair", &hair_file(&[strand], None));
    let text = "time = { step = 1e-3, duration = 1 }\ninteraction.model = \"none\"\n[hair]\nfile = \"none.npz\"\n";
    let path = folder.write("scene.toml", text.as_bytes());
    let said = |sets: &[&str]| {
        let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
        InitialState::new(&Scene::load_with(&path, &sets).unwrap().check().unwrap()).unwrap_err().to_string()
    };
    assert!(said(&[]).contains("scene.toml:4: hair.file: "), "{}", said(&[]));
    assert!(said(&["title=other"]).contains("scene.toml:4: hair.file: "), "{}", said(&["title=other"]));
    for set in ["hair.file=gone.npz", "hair.0.file=gone.npz"] {
        assert!(said(&[set]).starts_with(&format!("--set {set}: hair.file: ")), "{}", said(&[set]));
    }
    let lacks = said(&["title=other", "hair.file=unit.hair"]);
    assert!(lacks.starts_with("--set hair.file=unit.hair: hair.scale: "), "{lacks}");
}

/// Strands that cannot be are left out, each for its reason, and the others keep order and number.
#[test]
fn what_cannot_be_a_strand_is_left_out_and_counted() {
    let folder = Folder::new();
    let line = |x: f32| (0..4).map(|k| [x, -0.1 * k as f32, 0.0]).collect::<Vec<_>>();
    let mut doubled = line(1.0);
    doubled[2] = doubled[1];
    let mut not_finite = line(2.0);
    not_finite[3][1] = f32::NAN;
    let given = [line(0.0), doubled, not_finite, vec![[3.0; 3]], vec![[4.0; 3]; 4], line(5.0)];
    let path = folder.write("some.hair", &hair_file(&given, None));
    let file = GroomFile { scale: Some(1.0), ..GroomFile::new(path.to_string_lossy()) };
    let (curves, notes) = file.curves(1).unwrap();
    assert_eq!(curves.ids, [0, 5]);
    let [note] = &notes[..] else { panic!("{notes:?}") };
    assert!(note.contains("4 of the 6 strands"), "{note}");
    assert!(
        note.ends_with("1 not finite, 1 of fewer than two points, 1 of no length, 1 with doubled points"),
        "{note}"
    );
    // Points that are placed anew are not doubled.
    let (curves, notes) = GroomFile { points: Some(3), ..file.clone() }.curves(1).unwrap();
    assert_eq!((&curves.ids[..], &curves.offsets[..]), (&[0, 1, 5][..], &[0, 3, 6, 9][..]));
    assert!(notes[0].contains("3 of the 6 strands"), "{notes:?}");
    // None is left.
    let path = folder.write("none.hair", &hair_file(&given[2..5], None));
    let error = GroomFile { scale: Some(1.0), ..GroomFile::new(path.to_string_lossy()) }.curves(1).unwrap_err();
    assert!(error.message().contains("expected strands that can be simulated"), "{error}");
}

/// A strand that is far shorter than the others is simulated like them, and named.
#[test]
fn strands_far_shorter_than_the_rest_are_named() {
    let folder = Folder::new();
    let line = |length: f32| (0..10).map(|k| [0.0, -length * k as f32 / 9.0, 0.0]).collect::<Vec<_>>();
    let of = |length: f32| {
        let path = folder.write("some.hair", &hair_file(&[line(0.15), line(0.15), line(length), line(0.15)], None));
        GroomFile { scale: Some(1.0), ..GroomFile::new(path.to_string_lossy()) }.curves(1).unwrap()
    };
    let (curves, notes) = of(1e-3);
    assert_eq!(curves.len(), 4);
    assert!(notes[0].contains("1 of the 4 strands") && notes[0].ends_with("id 2, 1.000e-3 m"), "{notes:?}");
    assert_eq!(of(4e-3).1, Vec::<String>::new());
}

/// Arrays of unlike strands are filled up behind the tips, with a constant, not-a-numbers or repeats: no part of a
/// strand.
#[test]
fn padding_is_cut_off_and_counted() {
    let folder = Folder::new();
    let line = |x: f64, n: usize| (0..n).map(|k| [x, -0.01 * k as f64, 0.0]).collect::<Vec<_>>();
    for fill in [Some(0.0), Some(-1.0), Some(f64::NAN), None] {
        let mut points = Vec::new();
        for (x, n) in [(0.1, 8), (0.2, 5), (0.3, 2)] {
            let strand = line(x, n);
            let last = fill.map_or(strand[n - 1], |x| [x; 3]);
            points.extend(strand.into_iter().chain(std::iter::repeat_n(last, 8 - n)));
        }
        let array = npy_head("<f8", &[3, 8, 3]);
        let numbers = points.as_flattened().iter().flat_map(|x| x.to_le_bytes());
        let path = folder.write("some.npy", &array.into_iter().chain(numbers).collect::<Vec<_>>());
        let file = GroomFile { scale: Some(1.0), ..GroomFile::new(path.to_string_lossy()) };
        let (curves, notes) = file.curves(1).unwrap();
        assert_eq!(curves.offsets, [0, 8, 13, 15]);
        assert_eq!(curves.strand(1), line(0.2, 5));
        assert!(notes[0].contains("2 of the 3 strands") && notes[0].contains("padding"), "{notes:?}");
        // Points that are placed anew are all on the strand.
        let (curves, _) = GroomFile { points: Some(3), ..file }.curves(1).unwrap();
        assert!((curves.strand(2)[2][1] + 0.01).abs() < 1e-15, "{:?}", curves.strand(2));
    }
    // A tip at the origin is no padding.
    let tip =
        Curves { points: vec![[0.0, 1.0, 0.0], [0.0; 3]], offsets: vec![0, 2], ids: vec![0], ..Curves::default() };
    assert_eq!(tip.clone().without_padding(), (tip, 0));
}

/// Lines of a `.ply` file are strands, in whatever order its edges and points stand.
#[test]
fn edges_of_ply_files_are_strands() {
    let ply = GroomFormat::ALL.iter().find(|format| format.extension == "ply").unwrap();
    let read = |edges: &[[u32; 2]]| {
        let rows: String = edges.iter().map(|[a, b]| format!("{a} {b}\n")).collect();
        let text = format!(
            "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\n\
             property float thickness\nelement edge {}\nproperty int vertex1\nproperty int vertex2\nend_header\n\
             0 0 0 2\n5 0 0 4\n0 1 0 6\n5 1 0 8\n0 2 0 10\n9 9 9 12\n{rows}",
            edges.len()
        );
        ply.read(text.as_bytes(), Some(2))
    };
    for edges in [[[0, 2], [2, 4], [1, 3]], [[3, 1], [4, 2], [0, 2]]] {
        let curves = read(&edges).unwrap();
        assert_eq!(curves.offsets, [0, 3, 5, 6]);
        assert_eq!(curves.strand(0), [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 2.0, 0.0]]);
        assert_eq!(curves.strand(1), [[5.0, 0.0, 0.0], [5.0, 1.0, 0.0]]);
        assert_eq!(curves.radius, [1.0, 3.0, 5.0, 2.0, 4.0, 6.0]);
    }
    for (edges, words) in [
        (
            &[[0, 1], [0, 2], [0, 3]][..],
            "edge 2: expected strands, which do not branch, found a third edge at vertex 0",
        ),
        (&[[0, 1], [1, 2], [2, 0]], "expected strands with two ends, found a ring of edges through vertex 0"),
        (&[[0, 6]], "edge 0: expected vertices below 6, found 6"),
    ] {
        let said = read(edges).unwrap_err().to_string();
        assert!(said.contains(words), "{said}");
    }
}

/// A file whose strands are longer or shorter than hair is told how long they would be in other units.
#[test]
fn files_in_another_unit_are_told() {
    let folder = Folder::new();
    let strand = |x: f32| (0..4).map(|k| [x, -0.1 * k as f32, 0.0]).collect::<Vec<_>>();
    let path = folder.write("some.hair", &hair_file(&[strand(0.0), strand(1.0), strand(2.0)], None));
    let notes =
        |scale: f64| GroomFile { scale: Some(scale), ..GroomFile::new(path.to_string_lossy()) }.curves(1).unwrap().1;
    let long = "are at least 3.000 m with a scale of 10; it would be 0.300 m with 1, of metres, 0.030 m with 0.1, of decimetres, 0.008 m";
    assert!(notes(10.0)[0].contains(long), "{:?}", notes(10.0));
    let short = "some.hair are at least 3.0e-4 m with a scale of 0.001; it would be 0.300 m with 1, of metres";
    assert!(notes(1e-3)[0].contains(short), "{:?}", notes(1e-3));
    assert!(notes(1.0).is_empty() && notes(5.0).is_empty() && notes(0.01).is_empty());
}

/// Points placed anew are equally far apart along the strand, on it, from root to tip.
#[test]
fn points_are_placed_evenly() {
    // An L of 3 and 1.
    let curves = Curves {
        points: vec![[0.0; 3], [1.0, 0.0, 0.0], [3.0, 0.0, 0.0], [3.0, 1.0, 0.0]],
        offsets: vec![0, 4],
        ids: vec![9],
        radius: vec![4.0, 3.0, 1.0, 0.0],
        ..Curves::default()
    };
    let even = curves.resampled(9);
    let expected: Vec<[f64; 3]> =
        (0..=6).map(|k| [0.5 * f64::from(k), 0.0, 0.0]).chain([[3.0, 0.5, 0.0], [3.0, 1.0, 0.0]]).collect();
    assert_eq!((even.points, even.ids), (expected, vec![9]));
    assert_eq!(even.radius, [4.0, 3.5, 3.0, 2.5, 2.0, 1.5, 1.0, 0.5, 0.0]);
}

/// Data of strands beside their shape comes back from the archive, and stays with its strand.
#[test]
fn groups_and_places_of_roots_come_back() {
    let folder = Folder::new();
    let curves = Curves {
        points: [[0.0; 3], [0.0, 1.0, 0.0], [0.0, 3.0, 0.0]].repeat(4),
        offsets: vec![0, 3, 6, 9, 12],
        ids: vec![7, 5, 3, 1],
        groups: vec![2, 2, 0, 4_000_000_000],
        root_uvs: vec![[0.25, 0.5], [-0.0, 1.0], [0.1, 0.2], [3.0, 4.0]],
        guides: vec![true, false, false, true],
        ..Curves::default()
    };
    let path = folder.path().join("marks.npz");
    curves.save(&path).unwrap();
    assert_eq!(Curves::load(&path, None).unwrap(), curves);
    let file = GroomFile { points: Some(5), scale: Some(1.0), ..GroomFile::new(path.to_string_lossy()) };
    let (groom, _) = file.groom(1).unwrap();
    assert_eq!((&groom.ids, &groom.groups), (&curves.ids, &curves.groups));
    assert_eq!((&groom.root_uvs, &groom.guides), (&curves.root_uvs, &curves.guides));
    // The strands that are marked are simulated. A groom that is saved keeps the others too.
    let scene = parse("time = { step = 1e-3, duration = 1 }\ninteraction.model = \"none\"").unwrap();
    let state = InitialState::with_groom(&scene, &groom).unwrap();
    let hair = &state.hair;
    assert_eq!((&hair.ids[..], &hair.groups[..]), (&[7, 1][..], &[2, 4_000_000_000][..]));
    assert_eq!(hair.root_uvs, [[0.25, 0.5], [3.0, 4.0]]);
    assert_eq!(state.followers.as_ref(), Some(&groom.curves().unwrap()));
    groom.curves().unwrap().save(&path).unwrap();
    let again = Curves::load(&path, None).unwrap();
    assert_eq!((again.ids, again.guides, again.points), (curves.ids.clone(), curves.guides.clone(), groom.points));
    curves.save(&path).unwrap();
    // Marks can be left aside, and fewer of the marked be asked for.
    let (unmarked, _) = GroomFile { file_guides: false, ..file.clone() }.groom(1).unwrap();
    assert_eq!((unmarked.len(), unmarked.guides), (4, vec![]));
    let (one, _) = GroomFile { strands: Some(1), ..file.clone() }.groom(1).unwrap();
    assert!(one.guides == [true, false, false, false] || one.guides == [false, false, false, true], "{:?}", one.guides);
    // The others follow, and all of them are what the file becomes as another file.
    let (simulated, all) = file.followers(1).unwrap();
    let all = all.unwrap();
    assert_eq!((simulated, all.ids, all.points.len()), (2, curves.ids.clone(), 20));
    assert_eq!(file.fitted(curves.clone(), 1).unwrap().0.guides, curves.guides);
    // A file whose guides are all broken is no groom.
    let mut bald = curves.clone();
    bald.points[0] = bald.points[1];
    bald.points[9][0] = f64::NAN;
    bald.save(&path).unwrap();
    let said = GroomFile { points: None, ..file.clone() }.groom(1).unwrap_err().to_string();
    assert!(said.ends_with("expected guides that can be simulated: 1 not finite, 1 with doubled points"), "{said}");
    curves.save(&path).unwrap();
    for (invalid, name) in [
        (Curves { groups: vec![1], ..curves.clone() }, "groups"),
        (Curves { root_uvs: vec![[0.0; 2]; 5], ..curves.clone() }, "root_uvs"),
        (Curves { guides: vec![true; 3], ..curves.clone() }, "guides"),
    ] {
        let error = invalid.save(&path).unwrap_err();
        assert!(error.message().contains(&format!("{name}: expected 4, one a strand")), "{error}");
    }
}

/// The roots that are kept leave no hole: on a line of 101, the farthest from 5 of them is an eighth of the line away.
#[test]
fn the_strands_that_are_kept_are_far_apart() {
    let points: Vec<[f64; 3]> = (0..101).flat_map(|k| [[f64::from(k), 0.0, 0.0], [f64::from(k), -1.0, 0.0]]).collect();
    let curves =
        Curves { points, offsets: (0..=101).map(|s| 2 * s).collect(), ids: (0..101).collect(), ..Curves::default() };
    for seed in 0..10 {
        let few = curves.clone().guides(Some(5), seed);
        assert!(few.ids.is_sorted() && few.len() == 5);
        let gaps = |x: u32| few.ids.iter().map(|id| id.abs_diff(x)).min().unwrap();
        // The greedy choice is at most twice as far as the best one, 10.1.
        assert!((0..101).all(|x| gaps(x) <= 20), "{:?}", few.ids);
        assert_eq!(few, curves.clone().guides(Some(5), seed));
    }
    // Where a file marks its guides, only those are.
    let marked = Curves { guides: (0..101).map(|s| s % 10 == 5).collect(), ..curves };
    assert_eq!(marked.clone().guides(None, 1).ids, (0..10).map(|k| 10 * k + 5).collect::<Vec<u32>>());
    assert!(marked.clone().guides(Some(3), 1).ids.iter().all(|id| id % 10 == 5));
    assert_eq!(marked.clone().guides(Some(3), 1).len(), 3);
    let unmarked = Curves { guides: vec![false; 101], ..marked };
    assert_eq!(unmarked.guides(None, 1).len(), 101);
    // Roots in one place are different strands.
    let same = Curves {
        points: [[0.0; 3], [0.0, 1.0, 0.0]].repeat(4),
        offsets: vec![0, 2, 4, 6, 8],
        ids: vec![0, 1, 2, 3],
        ..Curves::default()
    };
    assert_eq!(same.guides(Some(3), 1).len(), 3);
}

fn scene_of(folder: &Folder, keys: &str) -> Result<CheckedScene, windswept_scene::SceneError> {
    let text = format!("time = {{ step = 1e-3, duration = 1 }}\ninteraction.model = \"none\"\n[hair]\n{keys}\n");
    load(folder.write("scene.toml", text.as_bytes()))
}

/// A scene names a file beside it, whatever the folder that one is in; it carries the path from then on.
#[test]
fn a_scene_takes_its_strands_from_a_file() {
    let folder = Folder::new();
    let given = [vec![[0.0, 0.0, 0.0], [0.0, 0.0, -10.0], [0.0, 0.0, -20.0]], vec![[1.0, 0.0, 0.0], [1.0, 5.0, 0.0]]];
    folder.write("two.hair", &hair_file(&given, Some(&[0.01; 5])));
    let scene = scene_of(&folder, "file = \"two.hair\" # ours\nscale = 0.01\nup = \"z\"\ndensity = 1000").unwrap();
    let HairSource::File(file) = &scene.hair[0].source else { panic!("{scene:?}") };
    assert!(Path::new(&file.file).is_absolute() && file.file.ends_with("two.hair"));
    assert!(scene.scene().text().contains("# ours"));
    assert_eq!(parse(scene.scene().text()).unwrap(), scene);
    assert_eq!(parse(&scene.scene().to_toml()).unwrap(), scene);
    let state = InitialState::new(&scene).unwrap();
    let points: Vec<[f64; 3]> = state.hair.positions.iter().map(|x| x.to_array()).collect();
    let expected = [[0.0, 0.0, 0.0], [0.0, -0.1, 0.0], [0.0, -0.2, 0.0], [0.01, 0.0, 0.0], [0.01, 0.0, -0.05]];
    for (x, y) in points.iter().flatten().zip(expected.iter().flatten()) {
        assert!((x - y).abs() < 1e-9, "{points:?}");
    }
    assert_eq!((state.hair.group, state.hair.ids), (vec![0, 0], vec![0, 1]));
    assert_eq!(state.hair.point_offsets, [0, 3, 5]);
    // 0.01 units are 0.1 mm across.
    assert!(state.hair.radius.iter().all(|radius| (radius - 5e-5).abs() < 1e-10), "{:?}", state.hair.radius);
    assert!(state.warnings.iter().any(|warning| warning.text.contains("the radius that")), "{:?}", state.warnings);
    let scene = scene_of(&folder, "file = \"two.hair\"\nscale = 0.01\nfile_radius = false\nradius = 6e-5").unwrap();
    assert!(InitialState::new(&scene).unwrap().hair.radius.iter().all(|radius| *radius == 6e-5));
    // A tenth of a metre is no hair's.
    let scene = scene_of(&folder, "file = \"two.hair\"\nscale = 1").unwrap();
    let state = InitialState::new(&scene).unwrap();
    assert!(state.hair.radius.iter().all(|radius| *radius == 4e-5));
    assert!(state.warnings.iter().any(|warning| warning.text.contains("no hair's")), "{:?}", state.warnings);
    // Keyframes move the roots about the file's origin.
    let keys = "file = \"two.hair\"\nscale = 0.01\nmotion = [{ time = 0, translation = [0, 1, 0], rotation = [0, 0, 1.5707963267948966] }]";
    let moved = InitialState::new(&scene_of(&folder, keys).unwrap()).unwrap();
    let root = moved.hair.positions[3];
    assert!((root - glam::DVec3::new(0.0, 1.01, 0.0)).length() < 1e-12, "{root}");
}

/// A path that starts elsewhere than in the scene's folder is refused with its line, key and reason, unless an
/// assignment says it; one that leads out of the folder is not. A scene's text for another folder has paths that start
/// there.
#[test]
fn paths_start_from_the_scenes_folder() {
    let folder = Folder::new();
    let file = folder.write("two.hair", &hair_file(&strands(5), None)).to_string_lossy().into_owned();
    let keys = |file: &str| format!("file = {file:?}\nscale = 0.01");
    let expected = format!(
        "hair.file: expected a path relative to the scene's folder, found {file:?}: a scene file goes to other machines with its files; \
         --set and code may say any path"
    );
    let error = scene_of(&folder, &keys(&file)).unwrap_err();
    assert_eq!((error.key(), error.line()), (Some("hair.file"), Some(4)), "{error}");
    assert!(error.to_string().ends_with(&format!("scene.toml:4: {expected}")), "{error}");
    let scene = scene_of(&folder, &keys("two.hair")).unwrap();
    let path = folder.path().join("scene.toml");
    let set = format!("hair.file={file:?}");
    let assigned = Scene::load_with(&path, &[set]).and_then(|scene| scene.check()).unwrap();
    assert_eq!(assigned.hair[0].as_file().unwrap().file, file);
    let body =
        "[hair]\nfile = \"two.hair\"\nscale = 0.01\n[[body]]\nshape = \"mesh\"\nscale = 1\nfile = \"/none.obj\"\n";
    let head = "time = { step = 1e-3, duration = 1 }\ninteraction.model = \"none\"\n";
    let error = load(folder.write("body.toml", (head.to_owned() + body).as_bytes())).unwrap_err();
    assert_eq!((error.key(), error.line()), (Some("body.file"), Some(9)), "{error}");
    // From a folder beside it, which a link leads to.
    for name in ["real", "real/deep", "runs"] {
        std::fs::create_dir(folder.path().join(name)).unwrap();
    }
    #[cfg(unix)]
    std::os::unix::fs::symlink("../real/deep", folder.path().join("runs/link")).unwrap();
    #[cfg(not(unix))]
    std::fs::create_dir(folder.path().join("runs/link")).unwrap();
    let beside = folder.path().join("runs/link");
    let text = scene.text_in(&beside);
    assert!(text.contains("two.hair") && !text.contains(&file), "{text}");
    std::fs::write(beside.join("scene.toml"), &text).unwrap();
    let again = load(beside.join("scene.toml")).unwrap();
    assert_eq!(InitialState::new(&again).unwrap().hair, InitialState::new(&scene).unwrap().hair);
    assert_eq!(again.text_in(&beside), text);
}

/// Faults of the keys, and of the file behind them.
#[test]
fn faults_of_files_name_the_key() {
    let folder = Folder::new();
    folder.write("two.hair", &hair_file(&strands(5), None));
    let refused = |keys: &str, key: &str, words: &[&str]| {
        let error = scene_of(&folder, keys).and_then(|scene| InitialState::new(&scene)).unwrap_err();
        assert_eq!(error.key(), Some(key), "{error}");
        assert!(error.source_name().ends_with("scene.toml"), "{error}");
        let line = error.line().and_then(|line| error.source_text().lines().nth(line - 1)).unwrap_or_default();
        let spelled = key.trim_start_matches("hair.");
        assert!(line.starts_with(spelled) || line == "[hair]", "{error}: {line}");
        assert!(words.iter().all(|words| error.to_string().contains(words)), "{error}");
    };
    refused(
        "file = \"two.hair\"",
        "hair.scale",
        &["two.hair: the file does not say its unit", "m if that is the metre", "give scale"],
    );
    refused("file = \"none.hair\"\nscale = 1", "hair.file", &["none.hair", "cannot be read"]);
    let to_npz = "windswept.usd.to_npz(FILE, \"groom.npz\") in Python";
    refused("file = \"a.usdc\"", "hair.file", &["a.usdc: expected a groom file: .hair", to_npz]);
    refused("file = \"a.abc\"", "hair.file", &["expected a groom file", "Blender imports Alembic", to_npz]);
    let of_two =
        |keys: &str| format!("file = \"two.hair\"\nscale = 1\n{keys}\n[[body]]\ncenter = [0, 0.5, 0]\nradius = 50");
    let large = "m large, body \"body\" 100.000 x 100.000 x 100.000 m: hair.scale is";
    refused(&of_two(""), "hair.scale", &["is rooted", "expected at most a tenth of its radius", large]);
    refused("file = \"two.hair\"\nscale = 1\nlength = 0.1", "hair.length", &["goes with strands that are drawn"]);
    refused(
        "file = \"two.hair\"\nscale = 1\nroots = { center = [0, 0, 0], radius = 1 }",
        "hair.roots",
        &["a groom file"],
    );
    refused("file = \"two.hair\"\nscale = 0", "hair.scale", &["greater than 0"]);
    refused("file = \"two.hair\"\nscale = 1\nup = \"q\"", "hair.up", &["\"yzx\""]);
    refused("strands = 1\npoints = 2\nlength = 1\nscale = 1", "hair.scale", &["goes with a groom file"]);
    folder.write("two.hair", b"HAIR");
    refused("file = \"two.hair\"\nscale = 1", "hair.file", &["two.hair", "at byte 4", "the number of strands"]);
}

/// More strands than a file has are not there, and that is said with both numbers.
#[test]
fn strands_that_a_file_lacks_are_said() {
    let folder = Folder::new();
    folder.write("five.hair", &hair_file(&strands(5), None));
    let warnings = |count: u32| {
        let scene = scene_of(&folder, &format!("file = \"five.hair\"\nscale = 0.01\nstrands = {count}")).unwrap();
        InitialState::new(&scene).unwrap().warnings
    };
    assert!(warnings(5).iter().all(|warning| !warning.text.contains("asked for")), "{:?}", warnings(5));
    let said = warnings(9);
    let said = said
        .iter()
        .filter(|warning| warning.text.contains("9 strands are asked for, and") && warning.text.contains("has 5"));
    assert_eq!(said.count(), 1, "{:?}", warnings(9));
}

/// A struct that was made in code is checked as a scene is.
#[test]
fn numbers_made_in_code_are_checked() {
    let file = GroomFile::new("none.hair");
    for (bad, key) in [
        (GroomFile { scale: Some(f64::NAN), ..file.clone() }, "scale"),
        (GroomFile { scale: Some(-1.0), ..file.clone() }, "scale"),
        (GroomFile { points: Some(1), ..file.clone() }, "points"),
        (GroomFile { points: Some(u32::MAX), ..file.clone() }, "points"),
        (GroomFile { strands: Some(0), ..file.clone() }, "strands"),
        (GroomFile { points_per_strand: Some(0), ..file.clone() }, "points_per_strand"),
    ] {
        assert_eq!(bad.curves(1).unwrap_err().key(), Some(key), "{bad:?}");
    }
}

/// Arrays that do not belong together are an error where they are written or become strands.
#[test]
fn curves_made_in_code_are_checked() {
    let folder = Folder::new();
    let good =
        Curves { points: vec![[0.0; 3], [0.0, 1.0, 0.0]], offsets: vec![0, 2], ids: vec![7], ..Curves::default() };
    let file = GroomFile::new("code");
    assert!(good.save(folder.path().join("a.npz")).is_ok() && file.fitted(good.clone(), 1).is_ok());
    for (bad, word) in [
        (Curves { offsets: vec![0, 3], ..good.clone() }, "offsets"),
        (Curves { offsets: vec![], ..good.clone() }, "offsets"),
        (Curves { offsets: vec![0, 2, 1, 2], ..good.clone() }, "offsets"),
        (Curves { ids: vec![], ..good.clone() }, "ids"),
        (Curves { radius: vec![1.0], ..good.clone() }, "radius"),
    ] {
        let errors = [bad.save(folder.path().join("a.npz")).unwrap_err(), file.fitted(bad, 1).unwrap_err()];
        assert!(errors.iter().all(|error| error.message().starts_with(word)), "{errors:?}");
    }
    // A strand without points has no root, and is one all the same.
    let none = Curves { points: vec![], offsets: vec![0, 0, 0], ids: vec![0, 1], ..Curves::default() };
    assert_eq!(none.guides(Some(1), 1).len(), 1);
}

/// Warnings of a straight upright strand of this γ = ρAgL³/EI, given as it hangs.
fn upright(gamma: f64, lean: f64) -> Vec<Warning> {
    let (length, radius) = (0.1, 4e-5);
    let youngs_modulus = 1320.0 * 9.81 * length * length * length / (0.25 * gamma * radius * radius);
    let stiffness = Stiffness::Moduli(Moduli { youngs_modulus, poissons_ratio: 0.38 });
    let fibre = Fibre { radius, stiffness, ..Fibre::default() };
    let along = |k: u32| length * f64::from(k) / 30.0;
    let points = (0..=30).map(|k| [lean * along(k), along(k), 0.0]).collect();
    let groom = Groom { fibre: fibre.into(), rest: RestShape::Hanging, ..Groom::new(points, vec![0, 31]) };
    let scene = parse("time = { step = 1e-3, duration = 1 }\ninteraction.model = \"none\"").unwrap();
    InitialState::with_groom(&scene, &groom).unwrap().warnings
}

/// A root that is not clamped holds no strand as it hangs, which is said; without weight there is nothing to hold.
#[test]
fn strands_whose_roots_are_not_clamped_are_told() {
    for (gravity, root, tip, told) in [
        (9.81, End::Clamped, End::Free, false),
        (9.81, End::Clamped, End::Pinned, false),
        (9.81, End::Pinned, End::Free, true),
        (9.81, End::Free, End::Clamped, true),
        (0.0, End::Free, End::Free, false),
    ] {
        let points = vec![[0.0; 3], [0.01, 0.0, 0.0], [0.02, -0.001, 0.0]];
        let ends = Groom { root: root.into(), tip: tip.into(), ..Groom::new(points, vec![0, 3]) };
        let groom = Groom { rest: RestShape::Hanging, ..ends };
        let text = format!(
            "gravity = [0, -{gravity}, 0]\ntime = {{ step = 1e-3, duration = 1 }}\ninteraction.model = \"none\""
        );
        let warnings = InitialState::with_groom(&parse(&text).unwrap(), &groom).unwrap().warnings;
        let says =
            warnings.iter().any(|warning| warning.text.contains("1 of 1 strands have a root that is not clamped"));
        assert_eq!(says, told, "{root:?} {tip:?}: {warnings:?}");
    }
}

/// A column falls over above γ = 7.8373 (Greenhill 1881); the 30 segments change that by less than 1 %.
#[test]
fn a_strand_that_would_fall_over_is_told() {
    for lean in [0.0, 0.05] {
        assert!(upright(7.7, lean).is_empty(), "{:?}", upright(7.7, lean));
        let warnings = upright(7.95, lean);
        assert!(
            warnings.iter().any(|warning| warning.text.contains("so soft that they do not stay")),
            "{lean}: {warnings:?}"
        );
    }
}

/// A compressed array is refused by what its head says, before any of its numbers is unpacked: a few bytes can stand
/// for gigabytes.
#[test]
fn compressed_arrays_are_not_unpacked_without_end() {
    let npz = GroomFormat::ALL.iter().find(|format| format.extension == "npz").unwrap();
    let said = |bytes: &[u8]| npz.read(bytes, Some(10)).unwrap_err().to_string();
    for (name, kind, shape, zeros, words) in [
        ("points", "<f4", &[2_000_000, 10, 3][..], 240_000_000, "expected at most 16777216 numbers in "),
        ("positions", "|u1", &[60_000_000, 3], 180_000_000, "found 180000000 of shape [60000000, 3]"),
        ("points", "<f8", &[3, 3], 100_000_000, "expected 200 bytes for shape [3, 3], found 100000128"),
        ("points", "<f4", &[10_000_000, 10, 3], 100, "expected at most 16777216 numbers in "),
        ("points", "<f4", &[1, 1, 1, 1, 2, 3], 24, "at most 3 sides"),
    ] {
        let shown = said(&deflated([(name, kind, shape, zeros_of(zeros))]));
        assert!(shown.starts_with(&format!("{name}: ")) && shown.contains(words), "{shown}");
    }
    // An honest file is read.
    let honest = deflated([("points", "<f4", &[100, 10, 3][..], zeros_of(12_000))]);
    assert_eq!(npz.read(&honest, None).unwrap().len(), 100);
}
