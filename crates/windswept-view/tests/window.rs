//! The window's content without a window: its panels, and what they do to the simulation, on the software adapter.
#![allow(clippy::unwrap_used)] // a test may panic

use std::path::Path;
use std::time::{Duration, Instant};

use eframe::egui::accesskit::Role;
use eframe::egui::{Event, Key, Modifiers, PointerButton, Pos2, pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use windswept::{AdapterChoice, Scene};
use windswept_export::image::{Rgba, RgbaImage};
use windswept_view::{App, Opened, setup};

const SCENES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/scenes");
const SIZE: [f32; 2] = [1000.0, 760.0];
/// Where the picture begins beside the panel.
const LEFT: u32 = 350;
/// Somewhere in the picture beside the panel.
const PICTURE: Pos2 = pos2(650.0, 380.0);
/// Longest that something may take; far beyond what it does.
const PATIENCE: Duration = Duration::from_secs(120);

type Window = Harness<'static, App>;

/// The window on a scene of the examples with these assignments.
fn window(name: &str, sets: &[&str], out: &Path) -> Window {
    let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
    let scene = Scene::load_with(Path::new(SCENES).join(name), &sets).unwrap().check().unwrap();
    opened(Opened::Scene(Box::new(scene)), out)
}

/// A brush of 20 strands in a small box, whose air is of the model drag: steps are fast.
fn brush(out: &Path) -> Window {
    window("quick.toml", &["hair.strands=20", "interaction.model=drag", "turbulence={}"], out)
}

fn opened(opened: Opened, out: &Path) -> Window {
    let out = out.to_path_buf();
    let mut window: Window =
        Harness::builder().with_size(SIZE).with_max_steps(2).wgpu_setup(setup(AdapterChoice::Software)).build_eframe(
            |cc| {
                let render = cc.wgpu_render_state.as_ref().unwrap();
                assert_eq!(format!("{:?}", render.adapter.get_info().device_type), "Cpu");
                App::new(cc, opened, out).unwrap()
            },
        );
    window.step();
    window
}

fn wait(window: &mut Window, what: &str, until: impl Fn(&Window) -> bool) {
    let began = Instant::now();
    while !until(window) {
        assert!(began.elapsed() < PATIENCE, "{what}: it never came");
        window.step();
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// Lets what was asked for come back.
fn settle(window: &mut Window) {
    for _ in 0..30 {
        window.step();
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// The value behind a label of the panel's numbers.
fn number(window: &Window, name: &str) -> String {
    let all: Vec<String> = window.query_all_by_role(Role::Label).filter_map(|node| node.value()).collect();
    let at = all.iter().position(|label| label == name).unwrap_or_else(|| panic!("no {name} among {all:?}"));
    all[at + 1].clone()
}

fn steps(window: &Window) -> u64 {
    number(window, "steps").parse().unwrap()
}

fn press(window: &mut Window, button: &str) {
    window.get_by_role_and_label(Role::Button, button).click();
    window.step();
}

/// Gives a slider a value, as a screen reader does.
fn turn(window: &mut Window, slider: &str, value: f64) {
    let node = window.get_by_role_and_label(Role::Slider, slider);
    node.set_value_accesskit(value);
    window.step();
}

/// The picture beside the panel.
fn picture(window: &mut Window) -> RgbaImage {
    window.step();
    let mut all = window.render().unwrap();
    windswept_export::image::imageops::crop(&mut all, LEFT, 0, 1000 - LEFT, 760).to_image()
}

/// Whether a pixel is brown, as hair and solids are: the backdrop is bluish grey.
fn is_brown(p: &Rgba<u8>) -> bool {
    p[0] > p[2].saturating_add(8)
}

/// Brown pixels in the right half of the picture, where only hair is.
fn brown(picture: &RgbaImage) -> usize {
    picture.enumerate_pixels().filter(|(x, _, p)| *x > 335 && is_brown(p)).count()
}

/// The picture without the scales of the colours at its foot.
fn above(picture: &RgbaImage) -> RgbaImage {
    windswept_export::image::imageops::crop_imm(picture, 0, 0, picture.width(), 640).to_image()
}

fn differing(a: &RgbaImage, b: &RgbaImage) -> usize {
    a.pixels().zip(b.pixels()).filter(|(a, b)| a != b).count()
}

/// The simulation waits until it is let go; it plays, pauses, takes one step, and goes back to the start.
#[test]
fn it_plays_pauses_steps_and_starts_over() {
    let out = tempfile::tempdir().unwrap();
    let mut window = brush(out.path());
    assert_eq!(steps(&window), 0);
    press(&mut window, "Play");
    wait(&mut window, "10 steps", |window| steps(window) >= 10);
    press(&mut window, "Pause");
    wait(&mut window, "a pause", |window| window.query_by_role_and_label(Role::Button, "Play").is_some());
    let paused = steps(&window);
    press(&mut window, "Step");
    wait(&mut window, "a step", |window| steps(window) == paused + 1);
    press(&mut window, "Start over");
    wait(&mut window, "the start", |window| steps(window) == 0);
    window.key_press(Key::Period);
    wait(&mut window, "a step by its key", |window| steps(window) == 1);
    // What was not asked to is not written.
    assert_eq!(std::fs::read_dir(out.path()).unwrap().count(), 0);
}

/// Hair is in the picture as lines and in the film look; the camera turns by a drag and frames the hair again.
#[test]
fn hair_is_drawn_in_both_looks() {
    let out = tempfile::tempdir().unwrap();
    let mut window = brush(out.path());
    let lines = picture(&mut window);
    assert!(brown(&lines) > 500, "{} pixels of hair", brown(&lines));
    window.get_by_label("Film").click();
    wait(&mut window, "the film look", |window| window.query_by_role_and_label(Role::Slider, "hairs").is_some());
    let mut film = picture(&mut window);
    let began = Instant::now();
    while differing(&lines, &film) < film.as_raw().len() / 8 {
        assert!(began.elapsed() < PATIENCE, "the film look never came");
        film = picture(&mut window);
    }
    assert!(brown(&film) > 4 * brown(&lines), "{} pixels of hair", brown(&film));
    window.get_by_label("Lines").click();
    wait(&mut window, "lines", |window| window.query_by_role_and_label(Role::Slider, "hairs").is_none());
    let before = picture(&mut window);
    window.hover_at(PICTURE);
    window.drag_at(PICTURE);
    window.step();
    window.hover_at(PICTURE + eframe::egui::vec2(200.0, 60.0));
    window.step();
    window.drop_at(PICTURE + eframe::egui::vec2(200.0, 60.0));
    let turned = picture(&mut window);
    assert!(differing(&before, &turned) > 1000, "{} pixels differ", differing(&before, &turned));
    window.key_press(Key::Home);
    window.step();
    window.remove_cursor();
    assert_eq!(differing(&before, &picture(&mut window)), 0);
}

/// A dial changes the scene that runs, hair follows, and a start over keeps the dial.
#[test]
fn a_dial_moves_hair() {
    let out = tempfile::tempdir().unwrap();
    let mut window = brush(out.path());
    turn(&mut window, "gravity", 0.0);
    turn(&mut window, "speed", 12.0);
    turn(&mut window, "direction", 90.0);
    press(&mut window, "Scene");
    let saved = out.path().join("scene-1.toml");
    wait(&mut window, "a scene", |_| saved.is_file());
    // Changes at the start are part of the scene as it runs.
    let text = std::fs::read_to_string(&saved).unwrap();
    assert!(text.contains("[[change]]") && text.contains("12.0") && text.contains("gravity"), "{text}");
    let calm = picture(&mut window);
    press(&mut window, "Play");
    wait(&mut window, "60 steps", |window| steps(window) >= 60);
    press(&mut window, "Pause");
    wait(&mut window, "a pause", |window| window.query_by_role_and_label(Role::Button, "Play").is_some());
    let blown = picture(&mut window);
    assert!(differing(&calm, &blown) > 500, "{} pixels differ", differing(&calm, &blown));
    press(&mut window, "Start over");
    wait(&mut window, "the start", |window| steps(window) == 0);
    press(&mut window, "Checkpoint");
    let saved = out.path().join("checkpoint-1.windswept");
    wait(&mut window, "a checkpoint", |_| saved.is_file());
    let scene = windswept::Checkpoint::open(&saved).unwrap().scene().clone();
    assert_eq!(scene.gravity.map(f64::abs), [0.0; 3]);
    let wind = scene.air.as_ref().unwrap().wind;
    assert!(wind[0].abs() < 1e-9 && (wind[2] - 12.0).abs() < 1e-9, "{wind:?}");
}

/// A film is recorded into a folder of its own, which opens for playback, frame by frame.
#[test]
fn a_film_is_recorded_and_played() {
    let out = tempfile::tempdir().unwrap();
    let mut window = brush(out.path());
    press(&mut window, "Record film");
    press(&mut window, "Play");
    wait(&mut window, "30 steps", |window| steps(window) >= 30);
    press(&mut window, "Pause");
    press(&mut window, "End film");
    let folder = out.path().join("film-1");
    let ended = |window: &Window| window.query_by_role_and_label(Role::Button, "Record film").is_some();
    wait(&mut window, "the film's end", ended);
    drop(window);
    let mut names: Vec<_> =
        std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    assert_eq!(names, ["hair.vtkhdf", "scene.toml"]);

    let mut window = opened(Opened::Run(folder, Vec::new()), out.path());
    assert_eq!(number(&window, "frame"), "0");
    let first = picture(&mut window);
    assert!(brown(&first) > 500, "{} pixels of hair", brown(&first));
    turn(&mut window, "time", 2.0);
    wait(&mut window, "frame 2", |window| number(window, "frame") == "2");
    assert_eq!(number(&window, "time"), "0.0331 s");
    let third = picture(&mut window);
    assert!(differing(&first, &third) > 100, "{} pixels differ", differing(&first, &third));
    press(&mut window, "Back");
    assert_eq!(number(&window, "frame"), "1");
    // A film has no dials, and nothing is saved of it but pictures.
    assert!(window.query_by_label("gravity").is_none() && window.query_by_label("Checkpoint").is_none());
    press(&mut window, "Picture");
    assert!(out.path().join("picture-1.png").is_file());
}

/// What there is under the pointer is said: the strand, the point and its values.
#[test]
fn the_pointer_says_what_it_is_over() {
    let out = tempfile::tempdir().unwrap();
    let mut window = brush(out.path());
    window.key_press(Key::F);
    settle(&mut window);
    let lines = picture(&mut window);
    // The lowest row of the picture that has hair, and a pixel of hair there.
    let found = lines.enumerate_pixels().filter(|(_, _, p)| is_brown(p));
    let (x, y, _) = found.max_by_key(|(x, _, _)| *x).unwrap();
    let before = picture(&mut window);
    let at = pos2(LEFT as f32 + x as f32, y as f32);
    window.hover_at(at);
    settle(&mut window);
    let pointed = picture(&mut window);
    // The words in their box.
    assert!(differing(&before, &pointed) > 2000, "{} pixels differ", differing(&before, &pointed));
}

/// A body that is dragged with Shift goes where the pointer goes, as time passes, in a film too.
#[test]
fn a_body_is_dragged() {
    let out = tempfile::tempdir().unwrap();
    let ball = "body=[{ name = \"ball\", shape = \"sphere\", center = [0.1, 0.03, 0.035], radius = 0.02 }]";
    let sets = ["hair.strands=20", "interaction.model=drag", "turbulence={}", ball];
    let mut window = window("quick.toml", &sets, out.path());
    let before = picture(&mut window);
    // The middle of the lowest row that has the ball in it: its lower edge; a little above is the ball.
    let low = before.enumerate_pixels().filter(|(_, _, p)| is_brown(p)).map(|(_, y, _)| y).max().unwrap();
    let row: Vec<u32> =
        before.enumerate_pixels().filter(|(_, y, p)| *y == low && is_brown(p)).map(|(x, ..)| x).collect();
    let from = pos2(LEFT as f32 + row[row.len() / 2] as f32, low as f32 - 12.0);
    let to = from + eframe::egui::vec2(-120.0, -20.0);
    let button = |pos, pressed| Event::PointerButton {
        pos,
        button: PointerButton::Primary,
        pressed,
        modifiers: Modifiers::SHIFT,
    };
    let between = from + eframe::egui::vec2(-20.0, 0.0);
    for event in [
        Event::ModifiersChanged(Modifiers::SHIFT),
        Event::PointerMoved(from),
        button(from, true),
        Event::PointerMoved(between),
        Event::PointerMoved(to),
        button(to, false),
        Event::ModifiersChanged(Modifiers::NONE),
        Event::PointerGone,
    ] {
        window.event(event);
        window.step();
    }
    // The camera stays, and so does the ball until time passes.
    press(&mut window, "Record film");
    press(&mut window, "Play");
    wait(&mut window, "100 steps", |window| steps(window) >= 100);
    press(&mut window, "Pause");
    press(&mut window, "End film");
    wait(&mut window, "a pause", |window| window.query_by_role_and_label(Role::Button, "Play").is_some());
    press(&mut window, "Checkpoint");
    let saved = out.path().join("checkpoint-1.windswept");
    wait(&mut window, "a checkpoint", |_| saved.is_file());
    let mut window = opened(Opened::Checkpoint(saved), out.path());
    let after = picture(&mut window);
    let mean = |picture: &RgbaImage| {
        let ball = picture.enumerate_pixels().filter(|(_, y, p)| *y > low.saturating_sub(60) && is_brown(p));
        let (sum, count) = ball.fold((0.0, 0.0), |(sum, count), (x, ..)| (sum + f64::from(x), count + 1.0));
        sum / count
    };
    let moved = mean(&after) - mean(&before);
    assert!((-150.0..-60.0).contains(&moved), "it moved by {moved} pixels");
    // The film's scene has the way of the ball: what is made of the film shows it.
    let filmed = Scene::load(out.path().join("film-1/scene.toml")).unwrap();
    let keyframes = filmed.bodies[0].motion.keyframes.clone();
    let way = keyframes.last().unwrap().translation[0] - keyframes[0].translation[0];
    assert!(
        keyframes.len() > 5 && keyframes[0].translation == [0.0; 3] && (-0.1..-0.01).contains(&way),
        "{keyframes:?}"
    );
}

/// Strands and air take the colours of their values, each with a scale that names its unit, and go back to none.
#[test]
fn hair_and_air_are_coloured() {
    let out = tempfile::tempdir().unwrap();
    let sets = ["hair.strands=20", "time.substeps=2", "air.box={ min = [0.0, 0.03, 0.0], max = [0.16, 0.10, 0.07] }"];
    let mut window = window("quick.toml", &sets, out.path());
    let choose = |window: &mut Window, what: &str, value: &str| {
        window.get_by_role_and_label(Role::ComboBox, what).click();
        settle(window);
        window.get_by_role_and_label(Role::Button, value).click();
        settle(window);
    };
    press(&mut window, "Play");
    wait(&mut window, "12 steps", |window| steps(window) >= 12);
    press(&mut window, "Pause");
    wait(&mut window, "a pause", |window| window.query_by_role_and_label(Role::Button, "Play").is_some());
    settle(&mut window);
    let plain = picture(&mut window);
    let mut before = plain.clone();
    for (what, value) in [
        ("strands by", "drag"),
        ("strands by", "length error"),
        ("strands by", "speed"),
        ("air", "points"),
        ("air", "arrows"),
        ("air by", "vorticity"),
    ] {
        choose(&mut window, what, value);
        let now = picture(&mut window);
        assert!(
            differing(&above(&before), &above(&now)) > 400,
            "{what} {value}: {} pixels differ",
            differing(&above(&before), &above(&now))
        );
        before = now;
    }
    choose(&mut window, "strands by", "hair");
    choose(&mut window, "air", "none");
    window.remove_cursor();
    let again = picture(&mut window);
    assert!(differing(&plain, &again) < 50, "{} pixels differ", differing(&plain, &again));
}
