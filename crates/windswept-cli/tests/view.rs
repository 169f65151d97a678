//! `windswept view` without a display, and on a virtual one.
#![allow(clippy::unwrap_used)] // a test may panic

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

const PATIENCE: Duration = Duration::from_secs(120);
/// The virtual screen, which the window fills.
const SCREEN: [usize; 2] = [1280, 800];

fn windswept(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_windswept"));
    command.args(arguments).env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
    command
}

fn scene() -> String {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/scenes/quick.toml");
    scenes.to_str().unwrap().to_owned()
}

/// Without a display the command says so, and what there is in a window's place; bad input is found before.
#[test]
#[cfg(all(unix, not(target_vendor = "apple")))]
fn without_a_display_it_names_what_else_there_is() {
    let out = windswept(&["view", &scene()]).output().unwrap();
    let said = String::from_utf8(out.stderr).unwrap();
    assert_eq!(out.status.code(), Some(2), "{said}");
    for word in ["no display", "windswept run", "windswept render", "ws.show", "ws.live"] {
        assert!(said.contains(word), "{said}");
    }
    let out = windswept(&["view", &scene(), "--set", "hair.strands=0"]).output().unwrap();
    let said = String::from_utf8(out.stderr).unwrap();
    assert!(out.status.code() == Some(2) && said.contains("hair.strands"), "{said}");
}

/// A program that ends with the test.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A virtual screen of X, whose pixels are in a file.
struct Screen {
    _server: Running,
    display: String,
    folder: tempfile::TempDir,
}

impl Screen {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let number = folder.path().join("display");
        let size = format!("{}x{}x24", SCREEN[0], SCREEN[1]);
        let mut server = Command::new("Xvfb");
        // The server takes a free display, and writes its number to its standard output.
        server.args(["-displayfd", "1", "-screen", "0", &size, "-nolisten", "tcp", "-fbdir"]).arg(folder.path());
        server.stdout(fs::File::create(&number).unwrap()).stderr(Stdio::null());
        let server = Running(server.spawn().expect("Xvfb, of the package xvfb"));
        let mut display = String::new();
        wait("a display", || {
            display = fs::read_to_string(&number).unwrap_or_default().trim().to_owned();
            !display.is_empty()
        });
        Self { _server: server, display: format!(":{display}"), folder }
    }

    /// The screen's pixels, row by row: red, green, blue.
    fn pixels(&self) -> Vec<[u8; 3]> {
        let dump = fs::read(self.folder.path().join("Xvfb_screen0")).unwrap();
        let word = |k: usize| u32::from_be_bytes(dump[4 * k..4 * k + 4].try_into().unwrap()) as usize;
        // XWD's header: its size, then 4: width, 5: height, 12: bytes per line, 19: colours, of 12 bytes each.
        let (first, line) = (word(0) + 12 * word(19), word(12));
        assert_eq!([word(4), word(5)], SCREEN);
        let row = |y: usize| dump[first + y * line..][..4 * SCREEN[0]].chunks(4).map(|p| [p[2], p[1], p[0]]);
        (0..SCREEN[1]).flat_map(row).collect()
    }

    fn save(&self, path: &Path) {
        let bytes = self.pixels().into_iter().flat_map(|[r, g, b]| [r, g, b, 255]).collect();
        image::RgbaImage::from_raw(SCREEN[0] as u32, SCREEN[1] as u32, bytes).unwrap().save(path).unwrap();
    }

    fn xdotool(&self, arguments: &[&str]) -> String {
        let mut command = Command::new("xdotool");
        let out =
            command.args(arguments).env("DISPLAY", &self.display).output().expect("xdotool, of the package xdotool");
        String::from_utf8(out.stdout).unwrap().trim().to_owned()
    }
}

fn wait(what: &str, mut until: impl FnMut() -> bool) {
    let began = Instant::now();
    while !until() {
        assert!(began.elapsed() < PATIENCE, "{what}: it never came");
        sleep(Duration::from_millis(100));
    }
}

/// Pixels of the right half of the picture that are brown: only hair is, there.
fn brown(pixels: &[[u8; 3]]) -> Vec<usize> {
    let is_hair = |(k, p): (usize, &[u8; 3])| (k % SCREEN[0] > 810 && p[0] > p[2].saturating_add(8)).then_some(k);
    pixels.iter().enumerate().filter_map(is_hair).collect()
}

/// The window opens on a virtual screen, shows hair, runs by a key, saves what it shows, and closes with success.
#[test]
#[ignore = "long: a window on a virtual screen, by Xvfb and xdotool"]
fn the_window_opens_runs_and_closes() {
    let screen = Screen::new();
    let out = tempfile::tempdir().unwrap();
    let saved = out.path().join("saved");
    let mut command = windswept(&["view", &scene(), "--adapter", "software", "--set", "interaction.model=drag"]);
    command.args(["--set", "turbulence={}", "--out"]).arg(&saved).env("DISPLAY", &screen.display);
    let mut window = Running(command.stderr(Stdio::piped()).spawn().unwrap());
    wait("hair", || brown(&screen.pixels()).len() > 500);
    let still = brown(&screen.pixels());
    let id = screen.xdotool(&["search", "--name", "windswept"]);
    screen.xdotool(&["windowfocus", &id]);
    screen.xdotool(&["key", "space"]);
    wait("hair that moves", || {
        let now = brown(&screen.pixels());
        now.iter().filter(|k| still.binary_search(k).is_err()).count() > 300
    });
    screen.xdotool(&["key", "p"]);
    wait("a picture", || saved.join("picture-1.png").is_file());
    let picture: PathBuf = Path::new(env!("CARGO_TARGET_TMPDIR")).join("view.png");
    screen.save(&picture);
    println!("the screen is in {}", picture.display());
    screen.xdotool(&["key", "ctrl+q"]);
    let mut status = None;
    wait("the end", || {
        status = window.0.try_wait().unwrap();
        status.is_some()
    });
    assert!(status.is_some_and(|status| status.success()), "{status:?}");
}
