//! `windswept render`, and what `run` does about pictures. On the software adapter.

use crate::support::{folder, listing, run, windswept};
use std::fs;
use std::path::Path;

/// Status of the program and its messages.
fn render(folder: &Path, more: &[&str]) -> (Option<i32>, String) {
    let mut command = windswept(folder, &["render", "out", "--adapter", "software"]);
    let ran = command.args(more).output().expect("the program starts");
    let said = [ran.stdout, ran.stderr].concat();
    (ran.status.code(), String::from_utf8_lossy(&said).into_owned())
}

fn pictures(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let frames = folder.join("out/frames");
    let read = |name: String| {
        let bytes = fs::read(frames.join(&name)).expect("a picture");
        (name, bytes)
    };
    listing(&frames).into_iter().map(read).collect()
}

/// Pictures made afterwards are those that the run made, to the bit; some of them, or others, on request.
#[test]
fn render_makes_the_runs_pictures() {
    let folder = folder();
    let folder = folder.path();
    assert_eq!(run(folder, &["--set", "picture.air=vorticity"]).status.code(), Some(0));
    let (first, film) = (pictures(folder), fs::read(folder.join("out/preview.gif")).expect("a preview"));
    assert_eq!(first.len(), 7);
    assert!(first.windows(2).all(|w| w[0].1 != w[1].1), "two frames look the same");

    let (status, said) = render(folder, &[]);
    assert!(status == Some(2) && said.contains("--overwrite"), "{said}");
    let (status, said) = render(folder, &["--overwrite"]);
    assert!(status == Some(0) && said.contains("7 of 7 pictures"), "{said}");
    assert!(pictures(folder) == first, "not the run's pictures");
    assert!(fs::read(folder.join("out/preview.gif")).expect("a preview") == film, "not the run's preview");

    let (status, said) = render(folder, &["--overwrite", "--frames", "2..6", "--every", "3"]);
    assert_eq!(status, Some(0), "{said}");
    assert!(pictures(folder) == [first[2].clone(), first[5].clone()], "not frames 2 and 5");

    let (status, said) = render(folder, &["--overwrite", "--set", "picture.hairs=80", "--frames", "2..3"]);
    assert_eq!(status, Some(0), "{said}");
    assert!(pictures(folder)[0].1 != first[2].1, "as many hairs as before");

    // Another size frames the hair all the same.
    let (status, said) = render(folder, &["--overwrite", "--set", "camera.width=480", "--frames", "2..3"]);
    assert_eq!(status, Some(0), "{said}");
    assert_eq!(pictures(folder)[0].1[16..24], [480_u32.to_be_bytes(), 540_u32.to_be_bytes()].concat());
}

/// Each camera's pictures are made by its name, into a folder of their own, beside those of the run; a film has them
/// all.
#[test]
fn each_camera_has_its_pictures() {
    let folder = folder();
    let folder = folder.path();
    let scene = fs::read_to_string(folder.join("scene.toml")).expect("the scene");
    let cameras = "[[camera]]\nname = \"front\"\nwidth = 320\nheight = 180\n[[camera]]\nname = \"side\"\nwidth = 200\n\
                   height = 300\neye = [0.3, 0.02, 0.02]\ntarget = [0.0, 0.02, 0.02]\n";
    fs::write(folder.join("scene.toml"), format!("{scene}\n{cameras}")).expect("a scene");
    assert_eq!(run(folder, &["--steps", "12"]).status.code(), Some(0));
    let runs = pictures(folder);
    let made = |camera: &str, out: &str| {
        let (status, said) = render(folder, &["--camera", camera, "--out", out]);
        assert!(status == Some(0) && said.contains(&format!("{out}: 2 of 2 pictures")), "{said}");
        assert_eq!(listing(&folder.join(out)), ["frames", "preview.gif"]);
        let read =
            |name: String| (name.clone(), fs::read(folder.join(out).join("frames").join(name)).expect("a picture"));
        listing(&folder.join(out).join("frames")).into_iter().map(read).collect::<Vec<_>>()
    };
    assert!(made("front", "views/front") == runs, "not the run's pictures");
    let side = made("side", "views/side");
    assert_eq!(side[0].1[16..24], [200_u32.to_be_bytes(), 300_u32.to_be_bytes()].concat());
    assert!(pictures(folder) == runs, "the run's pictures changed");
    let (status, said) = render(folder, &["--camera", "side", "--out", "views/side"]);
    assert!(status == Some(2) && said.contains("views/side: has pictures already"), "{said}");
    // A key of one of them, by its name.
    let (status, said) = render(folder, &["--overwrite", "--camera", "side", "--set", "camera.side.width=240"]);
    assert_eq!(status, Some(0), "{said}");
    assert_eq!(pictures(folder)[0].1[16..24], [240_u32.to_be_bytes(), 300_u32.to_be_bytes()].concat());
    let done = windswept(folder, &["export", "out", "--format", "usd"]).output().expect("the program starts");
    assert_eq!(done.status.code(), Some(0), "{done:?}");
    let film = fs::read_to_string(folder.join("out/film.usda")).expect("a film");
    assert!(["front", "side"].iter().all(|name| film.contains(&format!("def Camera \"{name}\""))), "{film}");
}

/// Pictures of others stay, however they are called, unless a frame takes their name; the target of a link stays in any
/// case.
#[test]
fn pictures_of_others_stay() {
    let folder = folder();
    let folder = folder.path();
    assert_eq!(run(folder, &["--steps", "12", "--checkpoint-every", "12"]).status.code(), Some(0));
    let first = pictures(folder);
    let frames = folder.join("out/frames");
    // One without the text by which it would be windswept's, as a picture program saves it.
    let mine = image::load_from_memory(&first[0].1).expect("a picture");
    for name in ["0001.png", "2024.png"] {
        mine.save(frames.join(name)).expect("a picture");
    }
    let kept = fs::read(frames.join("2024.png")).expect("a picture");
    fs::write(folder.join("photo.png"), "precious").expect("a file");
    #[cfg(unix)]
    {
        fs::remove_file(frames.join("0000.png")).expect("a picture");
        for name in ["0000.png", "0005.png"] {
            std::os::unix::fs::symlink("../../photo.png", frames.join(name)).expect("a link");
        }
    }
    let (status, said) = render(folder, &["--overwrite", "--frames", "0..1"]);
    assert_eq!(status, Some(0), "{said}");
    let there: Vec<_> = listing(&frames).into_iter().filter(|name| name != "0005.png").collect();
    assert_eq!(there, ["0000.png", "0001.png", "2024.png"]);
    let (status, said) = render(folder, &["--overwrite"]);
    assert_eq!(status, Some(0), "{said}");
    assert!(pictures(folder)[..2] == first[..], "not the run's pictures");
    let on = windswept(folder, &["run", "--resume", "out", "--steps", "24"]).output().expect("the program starts");
    assert_eq!(on.status.code(), Some(0), "{on:?}");
    assert_eq!(run(folder, &["--steps", "1", "--overwrite", "--formats", "none"]).status.code(), Some(0));
    let there: Vec<_> = listing(&frames).into_iter().filter(|name| name != "0005.png").collect();
    assert_eq!(there, ["2024.png"]);
    assert!(fs::read(frames.join("2024.png")).expect("a picture") == kept);
    assert_eq!(fs::read_to_string(folder.join("photo.png")).expect("a file"), "precious");
}

/// Frames side by side, in DIR or where asked, without touching the other pictures.
#[test]
fn a_contact_sheet_is_one_picture() {
    let folder = folder();
    let folder = folder.path();
    assert_eq!(run(folder, &["--formats", "vtkhdf"]).status.code(), Some(0));
    let (status, said) = render(folder, &["--contact-sheet", "0,0.05,0.0501,0.1,0"]);
    // Frames 0, 3 and 6 of 7, at whole steps, each once.
    assert!(status == Some(0) && said.contains("t = 0.000, 0.050, 0.099 s"), "{said}");
    let sheet = folder.join("out/contact-sheet.png");
    let bytes = fs::read(&sheet).expect("a sheet");
    // Three pictures of 960 x 540, 4 px apart, as a PNG says it: big-endian, after 16 bytes.
    assert_eq!(bytes[16..24], [2888_u32.to_be_bytes(), 540_u32.to_be_bytes()].concat());
    assert_eq!(
        listing(&folder.join("out")),
        ["air.vtkhdf", "contact-sheet.png", "hair.vtkhdf", "report.json", "scene.toml"]
    );
    let (status, said) = render(folder, &["--contact-sheet", "0"]);
    assert!(status == Some(2) && said.contains("is there already"), "{said}");
    let (status, said) = render(folder, &["--contact-sheet", "0", "--out", "sheet.png"]);
    assert_eq!(status, Some(0), "{said}");
    assert!(folder.join("sheet.png").is_file());
}

/// Without vtkhdf there are only pictures; and from those no others can be made.
#[test]
fn pictures_alone() {
    let folder = folder();
    let folder = folder.path();
    assert_eq!(run(folder, &["--formats", "png", "--steps", "12"]).status.code(), Some(0));
    assert_eq!(listing(&folder.join("out")), ["frames", "preview.gif", "report.json", "scene.toml"]);
    let (status, said) = render(folder, &["--overwrite"]);
    assert!(status == Some(2) && said.contains("hair.vtkhdf: is missing"), "{said}");
    assert_eq!(pictures(folder).len(), 2);
}

/// A run that cannot be rendered ends the command with status 2 and the name of the missing part; pictures that were
/// there stay.
#[test]
fn bad_requests_touch_nothing() {
    let folder = folder();
    let folder = folder.path();
    let (status, said) = render(folder, &[]);
    assert!(status == Some(2) && said.contains("out: no such folder"), "{said}");
    assert_eq!(run(folder, &["--steps", "12"]).status.code(), Some(0));
    let before = pictures(folder);
    for (more, word) in [
        (&["--frames", "9..12"][..], "has frames 0 to 1"),
        (&["--frames", "3..1"], "expected A..B"),
        (&["--every", "0"], "expected a whole number of at least 1"),
        (&["--set", "air.wind=[9, 0, 0]"], "only keys of camera and picture"),
        (&["--set", "picture.hair=9"], "picture.hairs"),
        (&["--set", "picture.hairs=2000000"], "at least 1, at most 1000000"),
        (&["--set", "picture.air=vorticity"], "the frame's air has no vorticity"),
        (&["--set", "camera.eye=[1,1,1]", "--set", "camera.target=[1,1,1]"], "the same point"),
        (&["--contact-sheet", "5"], "the run has frames from 0 to 0.017 s"),
        (&["--contact-sheet", "0", "--out", "nowhere/sheet.png"], "expected a file in a folder that is there"),
        (&["--contact-sheet", "NaN"], "expected times in seconds"),
        (&["--contact-sheet", "-1"], "the run has frames from 0 to 0.017 s"),
        (&["--frames", "0..9"], "has frames 0 to 1"),
        (&["--contact-sheet", "0", "--out", "out/hair.vtkhdf"], "a name that ends in .png"),
        (&["--contact-sheet", "0", "--out", "out/scene.toml"], "a name that ends in .png"),
        (&["--contact-sheet", "0", "--out", "out/frames/0000.png"], "belongs to the run"),
        (&["--contact-sheet", "0", "--out", "out/../out/frames/0099.png"], "belongs to the run"),
        (
            &["--contact-sheet", "0,0.017", "--set", "camera.width=12000", "--set", "camera.height=6000"],
            "2 pictures of 12000 x 6000 pixels are too many for a contact sheet of 134217728 pixels; expected at most 1",
        ),
        (&["--set", "camera.eye=[1,1,1]"], "camera.0.target: is missing"),
        (&["--camera", "back"], "--camera: expected one of camera, found \"back\""),
        (&["--out", "out/scene.toml"], "out/scene.toml"),
    ] {
        let (status, said) = render(folder, &[&["--overwrite"], more].concat());
        assert!(status == Some(2) && said.contains(word), "{more:?}: {said}");
        assert!(pictures(folder) == before, "{more:?}");
    }
    fs::create_dir(folder.join("out/frames/0099.png")).expect("a folder");
    let (status, said) = render(folder, &["--overwrite"]);
    assert!(status == Some(2) && said.contains("0099.png: is a folder"), "{said}");
    fs::remove_dir(folder.join("out/frames/0099.png")).expect("a folder");
    fs::write(folder.join("out/hair.vtkhdf"), "no film").expect("a file");
    let (status, said) = render(folder, &["--overwrite"]);
    assert!(status == Some(2) && said.contains("hair.vtkhdf: could not be read"), "{said}");
    fs::remove_file(folder.join("out/scene.toml")).expect("a file");
    let (status, said) = render(folder, &["--overwrite"]);
    assert!(status == Some(2) && said.contains("scene.toml: is missing"), "{said}");
    assert!(pictures(folder) == before);
}

/// Pictures that fail under way leave the simulation's files whole; the run says so and ends with status 1.
#[cfg(unix)]
#[test]
fn a_failed_picture_loses_no_frame() {
    let folder = folder();
    let folder = folder.path();
    // A file of the user's where the pictures' folder should be.
    fs::create_dir(folder.join("out")).expect("a folder");
    fs::write(folder.join("out/frames"), "mine").expect("a file");
    let ran = run(folder, &["--overwrite", "--steps", "12"]);
    let said = String::from_utf8_lossy(&ran.stderr).into_owned();
    assert_eq!(ran.status.code(), Some(1), "{said}");
    assert!(said.contains("no more pictures") && said.contains("frames: could not be made"), "{said}");
    assert_eq!(listing(&folder.join("out")), ["air.vtkhdf", "frames", "hair.vtkhdf", "report.json", "scene.toml"]);
    fs::remove_file(folder.join("out/frames")).expect("a file");
    let (status, said) = render(folder, &[]);
    assert!(status == Some(0) && said.contains("2 of 2 pictures"), "{said}");
}
