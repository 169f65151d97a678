//! Notes on a groom file that are no faults: data that it leaves to others, and data that another format cannot hold.

use crate::common::Folder;
use windswept_scene::{Curves, GroomFile, GroomFormat};

/// A note names the arrays that a format has no room for as a `.npz` file names them; arrays that follow from the
/// points are not named.
#[test]
fn what_a_format_cannot_hold_is_said() {
    let folder = Folder::new();
    let strand = |x: f64| [[x, 0.0, 0.0], [x, 1.0, 0.0]];
    let plain = Curves {
        points: [0.0, 1.0].into_iter().flat_map(strand).collect(),
        offsets: vec![0, 2, 4],
        ids: vec![0, 1],
        radius: vec![3e-5; 4],
        ..Curves::default()
    };
    let full = Curves {
        ids: vec![7, 3],
        radius: vec![3e-5, 2e-5, 3e-5, 2e-5],
        groups: vec![1, 1],
        root_uvs: vec![[0.5; 2]; 2],
        guides: vec![true, false],
        ..plain.clone()
    };
    for format in GroomFormat::ALL.iter().filter(|format| format.writes()) {
        let path = folder.path().join(format!("some.{}", format.extension));
        assert_eq!(plain.save(&path).unwrap(), None, ".{}", format.extension);
        let said = full.save(&path).unwrap();
        let back = Curves::load(&path, None).unwrap();
        let lost = [
            ("ids", back.ids != full.ids),
            ("radius", back.radius.is_empty()),
            ("groups", back.groups != full.groups),
            ("root_uv", back.root_uvs != full.root_uvs),
            ("guides", back.guides != full.guides),
        ];
        let lost: Vec<&str> = lost.into_iter().filter_map(|(name, lost)| lost.then_some(name)).collect();
        let expected = format!("{} has no {}: a .npz file holds them", path.display(), lost.join(", "));
        assert_eq!(said, (!lost.is_empty()).then_some(expected), ".{}", format.extension);
        assert_eq!(said.is_none(), format.extension == "npz");
    }
}

/// Strands that a file does not mark as guides, where it marks some, are counted, and so are those with the id of
/// another.
#[test]
fn guides_and_doubled_ids_are_said() {
    let folder = Folder::new();
    let strand = |s: u32| [0, 1, 2].map(|k| [f64::from(s), f64::from(k), 0.0]);
    let given = Curves {
        points: (0..9).flat_map(strand).collect(),
        offsets: (0..=9).map(|s| 3 * s).collect(),
        ids: (0..9).collect(),
        ..Curves::default()
    };
    let path = folder.path().join("nine.npz");
    let notes = |curves: &Curves, strands: Option<u32>| {
        curves.save(&path).unwrap();
        let file = GroomFile { scale: Some(0.01), strands, ..GroomFile::new(path.display().to_string()) };
        let of_groom = file.groom(1).unwrap().1;
        assert_eq!(file.curves(1).unwrap().1, of_groom);
        (of_groom, file.fitted(curves.clone(), 1).unwrap().1)
    };
    assert_eq!(notes(&given, None), (vec![], vec![]));
    let marked = Curves { guides: (0..9).map(|s| s < 2).collect(), ..given.clone() };
    let left = format!(
        "{} marks 2 of its 9 strands as guides: strands are taken of these, and 7 left to followers",
        path.display()
    );
    // All strands are taken where nothing is said of guides or number.
    assert_eq!(notes(&marked, None), (vec![left.clone()], vec![]));
    assert_eq!(notes(&marked, Some(1)), (vec![left.clone()], vec![left]));
    let all_marked = Curves { guides: vec![true; 9], ..given.clone() };
    assert_eq!(notes(&all_marked, None), (vec![], vec![]));
    let doubled = Curves { ids: vec![0, 1, 2, 0, 1, 2, 6, 0, 8], ..given };
    let said = vec![format!("4 of the 9 strands of {} have the id of a strand before them", path.display())];
    assert_eq!(notes(&doubled, None), (said.clone(), said));
}
