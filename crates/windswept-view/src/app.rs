//! The window's content.

mod pointer;

use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use eframe::egui::{self, Key, Modifiers, Sense};
use windswept::{Camera, CheckedScene, Gpu, LookAt, Simulation};
use windswept_export::write_png;

use crate::camera::Orbit;
use crate::dials::{DIALS, Wind};
use crate::fields::{AirColour, AirLook, HairColour};
use crate::picture::{Look, Looks, Picture, State};
use crate::playback::Playback;
use crate::record::{Refusal, free, make};
use crate::worker::{Ask, Now, Want, Worker};
use crate::{Opened, ViewError, help, panel};
use pointer::Drag;

/// Hairs of the film look at first, on a software adapter and on others: their followers are made on the CPU.
const HAIRS: [u32; 2] = [600, 5000];
/// Time that a message stays in the picture.
pub(crate) const SAID: Duration = Duration::from_secs(6);
/// Time in which what was asked for is done, and sliders do not follow the scene.
pub(crate) const ASKED: Duration = Duration::from_millis(600);

/// What is shown.
pub(crate) enum Source {
    /// A simulation that runs, and its last state.
    Live(Worker, Box<Now>),
    /// The film of a run.
    Film(Box<Playback>),
}

/// The window's content.
pub struct App {
    pub(crate) source: Source,
    pub(crate) picture: Picture,
    pub(crate) cameras: Vec<(String, Orbit)>,
    pub(crate) orbit: Orbit,
    pub(crate) looks: Looks,
    /// Hairs that the slider is at, and most that it asks for.
    pub(crate) hairs: [u32; 2],
    /// Values of the sliders: of [`DIALS`], of the wind where there is air, of the gust \[m/s\], of the pace.
    pub(crate) dials: Vec<Option<f64>>,
    pub(crate) wind: Option<Wind>,
    pub(crate) gust: f64,
    pub(crate) pace: f64,
    /// When something was asked last that changes the scene.
    pub(crate) asked: Option<Instant>,
    /// Folder that is written into, and the formats of films by their names.
    pub(crate) out: String,
    pub(crate) formats: Vec<&'static str>,
    pub(crate) panel: bool,
    pub(crate) help: bool,
    frames: VecDeque<Instant>,
    /// What was said last, and when; how much the worker had said by then.
    pub(crate) said: Option<(Instant, String)>,
    heard: u64,
    want: Want,
    hovered: bool,
    /// Whether the camera frames the hair as soon as a state has its strands.
    framing: bool,
    drag: Option<Drag>,
    adapter: String,
    /// Size of the picture \[px\]; `None` before the first.
    size: Option<[u32; 2]>,
}

impl App {
    /// The content of a window that eframe has opened, or of a test's.
    ///
    /// # Errors
    /// [`ViewError`] where what is opened cannot be shown.
    pub fn new(cc: &eframe::CreationContext<'_>, opened: Opened, out: PathBuf) -> Result<Self, ViewError> {
        let no_wgpu = || ViewError::Window("eframe runs without wgpu".to_owned());
        let render = cc.wgpu_render_state.clone().ok_or_else(no_wgpu)?;
        let gpu = Gpu::from_device(&render.adapter, render.device.clone(), render.queue.clone())?;
        cc.egui_ctx.set_theme(egui::Theme::Dark);
        let (source, start, groom) = match opened {
            Opened::Run(folder, sets) => {
                let playback = Playback::open(&folder, &sets)?;
                let start = playback.frame().hair.clone();
                (Source::Film(Box::new(playback)), start, None)
            }
            Opened::Scene(scene) => Self::live(cc, Simulation::new(&gpu, &*scene)?)?,
            Opened::Checkpoint(path) => Self::live(cc, Simulation::load(&gpu, path)?)?,
        };
        let scene = match &source {
            Source::Live(_, now) => (*now.scene).clone(),
            Source::Film(playback) => playback.scene().clone(),
        };
        let software = gpu.info().kind == "software";
        let hairs = scene.picture.hairs.min(HAIRS[usize::from(!software)]);
        let picture = Picture::new(&gpu, &render, &scene, start, groom)?;
        let cameras = picture.cameras([960, 720])?;
        // A scene has a camera at least.
        let orbit = cameras.first().map(|(_, orbit)| *orbit).ok_or_else(no_wgpu)?;
        let looks = Looks {
            look: if software { Look::Lines } else { Look::Film },
            hairs,
            sharpness: 1.0,
            hair: HairColour::default(),
            air: AirLook::default(),
            air_colour: AirColour::default(),
        };
        let mut app = Self {
            source,
            picture,
            cameras,
            orbit,
            looks,
            hairs: [hairs, scene.picture.hairs.max(20_000)],
            dials: Vec::new(),
            wind: Wind::of(&scene),
            gust: 3.0,
            pace: 1.0,
            asked: None,
            out: out.display().to_string(),
            formats: vec!["vtkhdf"],
            panel: true,
            help: false,
            frames: VecDeque::new(),
            said: None,
            heard: 0,
            want: Want::default(),
            hovered: false,
            framing: false,
            drag: None,
            adapter: gpu.info().name.clone(),
            size: None,
        };
        app.follow_scene(&scene);
        Ok(app)
    }

    /// A simulation in a thread of its own, with its strands at the start.
    fn live(
        cc: &eframe::CreationContext<'_>,
        simulation: Simulation,
    ) -> Result<(Source, windswept::HairFrame, Option<windswept_scene::Curves>), ViewError> {
        let (start, groom) = (simulation.hair_at_start(), simulation.initial().followers.clone());
        let (ctx, opened) = (cc.egui_ctx.clone(), simulation.scene().scene().clone());
        let worker = Worker::new(simulation, opened, move || ctx.request_repaint());
        let worker = worker.map_err(|error| ViewError::Window(error.to_string()))?;
        let now = Box::new(worker.now());
        Ok((Source::Live(worker, now), start, groom))
    }

    /// The scene as it is now.
    pub(crate) fn scene(&self) -> Arc<CheckedScene> {
        match &self.source {
            Source::Live(_, now) => now.scene.clone(),
            Source::Film(playback) => Arc::new(playback.scene().clone()),
        }
    }

    /// Time of the state that is shown \[s\], and the steps or the frame that it is.
    pub(crate) fn time(&self) -> (f64, u64) {
        match &self.source {
            Source::Live(_, now) => (now.time, now.steps),
            Source::Film(playback) => (playback.frame().time, playback.at() as u64),
        }
    }

    pub(crate) fn is_playing(&self) -> bool {
        match &self.source {
            Source::Live(_, now) => now.playing,
            Source::Film(playback) => playback.is_playing(),
        }
    }

    /// Name of the adapter.
    pub(crate) fn adapter(&self) -> &str {
        &self.adapter
    }

    /// Asks the simulation for something; nothing where a film is shown.
    pub(crate) fn ask(&mut self, ask: Ask) {
        if let Source::Live(worker, _) = &self.source {
            if matches!(ask, Ask::Dial(..) | Ask::Wind(_) | Ask::Restart) {
                self.asked = Some(Instant::now());
            }
            worker.ask(ask);
        }
    }

    pub(crate) fn say(&mut self, words: impl Into<String>) {
        self.said = Some((Instant::now(), words.into())).filter(|(_, words)| !words.is_empty());
    }

    pub(crate) fn play(&mut self, play: bool) {
        match &mut self.source {
            Source::Live(worker, _) => worker.ask(Ask::Play(play)),
            Source::Film(playback) => {
                if let Err(error) = playback.play(play) {
                    self.say(error.to_string());
                }
            }
        }
    }

    /// One step, or a number of frames of a film.
    pub(crate) fn step(&mut self, frames: isize) {
        match &mut self.source {
            Source::Live(worker, _) if frames > 0 => worker.ask(Ask::Step),
            Source::Live(..) => {}
            Source::Film(playback) => {
                let to = playback.at().saturating_add_signed(frames);
                if let Err(error) = playback.play(false).and_then(|()| playback.seek(to)) {
                    self.say(error.to_string());
                }
            }
        }
    }

    pub(crate) fn restart(&mut self) {
        self.ask(Ask::Restart);
        if let Source::Film(playback) = &mut self.source
            && let Err(error) = playback.seek(0)
        {
            self.say(error.to_string());
        }
    }

    /// A gust along the wind, or along +x where there is none.
    pub(crate) fn blow(&mut self) {
        if let Some(wind) = self.wind {
            let along = Wind { speed: self.gust, ..wind };
            self.ask(Ask::Gust(along.velocity()));
        }
    }

    /// Begins a film, or ends it.
    pub(crate) fn film(&mut self) {
        let Source::Live(worker, now) = &self.source else { return };
        if now.film.is_some() {
            return worker.ask(Ask::EndFilm);
        }
        let formats =
            windswept_export::Format::of_runs().filter(|format| self.formats.contains(&format.name)).collect();
        let view = self.orbit.view(self.size());
        let scene = &now.scene.cameras[0];
        let look_at = Some(LookAt { eye: view.eye.to_array(), target: view.target.to_array() });
        // The film has the scene's height and the window's shape; encoders of films want even sides.
        let width = 2 * (scene.height * view.width / view.height / 2).max(8);
        let camera = Camera { look_at, fov: view.fov, width, ..scene.clone() };
        self.ask(Ask::Record(PathBuf::from(&self.out), formats, camera));
    }

    /// Saves what the window shows of the scene.
    pub(crate) fn save_picture(&mut self) {
        let state = self.state();
        let saved = (|| -> Result<String, Refusal> {
            let picture = self.picture.read(&state).map_err(|error| error.to_string())?;
            let Some(picture) = picture else { return Ok(String::new()) };
            let out = PathBuf::from(&self.out);
            make(&out)?;
            let path = free(&out, "picture", ".png");
            write_png(&path, &picture).map_err(|error| error.to_string())?;
            Ok(path.display().to_string())
        })();
        self.say(saved.unwrap_or_else(|refusal| refusal));
    }

    /// Frames drawn in a second of late; 0 while nothing moves.
    pub(crate) fn rate(&self) -> f64 {
        let (Some(first), Some(last)) = (self.frames.front(), self.frames.back()) else { return 0.0 };
        let span = (*last - *first).as_secs_f64();
        if span > 0.0 { (self.frames.len() - 1) as f64 / span } else { 0.0 }
    }

    /// Sliders as the scene has their values.
    fn follow_scene(&mut self, scene: &CheckedScene) {
        let opened = match &self.source {
            Source::Live(worker, _) => worker.opened(),
            Source::Film(_) => return,
        };
        self.dials = DIALS.iter().map(|dial| (dial.get)(scene, opened)).collect();
        let wind = Wind::of(scene);
        // Without a wind it keeps its direction.
        if wind.is_none_or(|wind| wind.speed > 0.0) {
            self.wind = wind;
        } else if let Some(wind) = &mut self.wind {
            wind.speed = 0.0;
        }
    }

    /// Takes over what is new.
    fn hear(&mut self, ctx: &egui::Context) {
        let mut heard = None;
        match &mut self.source {
            Source::Live(worker, now) => {
                **now = worker.now();
                if worker.has_ended() {
                    heard = Some("the simulation ended by a fault of windswept's own: close the window".to_owned());
                } else if now.said.0 != self.heard {
                    (self.heard, heard) = (now.said.0, Some(now.said.1.to_string()));
                }
            }
            Source::Film(playback) => {
                if let Err(error) = playback.advance() {
                    heard = Some(error.to_string());
                    let _ = playback.play(false);
                }
                if playback.is_playing() {
                    ctx.request_repaint_after(Duration::from_millis(8));
                }
            }
        }
        heard.into_iter().for_each(|words| self.say(words));
        if self.asked.is_none_or(|asked| asked.elapsed() > ASKED) {
            self.asked = None;
            let scene = self.scene();
            self.follow_scene(&scene);
        } else {
            ctx.request_repaint_after(ASKED);
        }
    }

    /// Says which parts of a state are needed.
    fn want(&mut self) {
        let shows = self.looks.look == Look::Lines;
        let air = shows && self.looks.air != AirLook::Hidden;
        let want = Want {
            frame: air || self.framing || self.hovered,
            vorticity: air && self.looks.air_colour == AirColour::Vorticity,
            picture: !shows,
            hair: if shows { self.looks.hair } else { HairColour::Hair },
            pointed: self.hovered,
        };
        if want != self.want {
            self.want = want;
            self.ask(Ask::Want(want));
        }
    }

    /// The state that is shown.
    fn state(&self) -> State {
        match &self.source {
            Source::Live(_, now) => State {
                serial: now.serial,
                scene: now.scene.clone(),
                frame: now.frame.clone(),
                values: now.values.clone(),
                positions: Some((now.positions.clone(), now.origin)),
            },
            Source::Film(playback) => {
                let (frame, scene) = (playback.frame().clone(), Arc::new(playback.scene().clone()));
                let values = self.looks.hair.values(&frame, None, &playback.rest);
                State { serial: playback.at() as u64, scene, frame, values: Arc::new(values), positions: None }
            }
        }
    }

    fn keys(&mut self, ctx: &egui::Context) {
        if ctx.egui_wants_keyboard_input() {
            return;
        }
        let pressed = |key| ctx.input_mut(|input| input.consume_key(Modifiers::NONE, key));
        if pressed(Key::Space) {
            self.play(!self.is_playing());
        }
        if pressed(Key::Period) {
            self.step(1);
        }
        if pressed(Key::Comma) {
            self.step(-1);
        }
        if pressed(Key::R) {
            self.restart();
        }
        if pressed(Key::G) {
            self.blow();
        }
        if pressed(Key::F) {
            self.framing = true;
        }
        if pressed(Key::Home) {
            self.orbit = self.cameras[0].1;
        }
        if pressed(Key::L) {
            self.looks.look = if self.looks.look == Look::Lines { Look::Film } else { Look::Lines };
        }
        if pressed(Key::P) {
            self.save_picture();
        }
        if pressed(Key::V) {
            self.film();
        }
        if ctx.input_mut(|input| input.consume_key(Modifiers::COMMAND, Key::Q)) {
            ctx.send_viewport_cmd(egui::ViewportCommand::Close);
        }
        self.panel ^= pressed(Key::H);
        self.help ^= pressed(Key::F1);
    }

    pub(crate) fn frame_hair(&mut self) {
        self.framing = true;
    }

    /// The picture, which the pointer moves the camera and bodies in.
    fn show_picture(&mut self, ui: &mut egui::Ui) {
        let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
        let pixels = ui.ctx().pixels_per_point() * self.looks.sharpness;
        let size = [rect.width(), rect.height()].map(|side| ((side * pixels) as u32).max(16));
        if self.size.replace(size).is_none()
            && let Ok(cameras) = self.picture.cameras(size)
        {
            self.orbit = cameras.first().map_or(self.orbit, |(_, orbit)| *orbit);
            self.cameras = cameras;
        }
        let state = self.state();
        self.move_camera(ui, &response, rect, &state);
        if self.framing && !state.frame.hair.positions.is_empty() {
            self.framing = false;
            self.orbit.frame(&state.frame.hair.positions, size);
        }
        if let Err(error) = self.picture.draw(&state, self.orbit, self.looks, size) {
            self.say(error.to_string());
        }
        ui.painter().extend(self.picture.over(rect).map(egui::Shape::from));
        if let Source::Live(worker, now) = &self.source {
            worker.has_shown(now.serial);
        }
        self.point(ui, &response, rect, &state);
        panel::legends(self, ui, rect);
        if let Some((when, words)) = &self.said
            && when.elapsed() < SAID
        {
            panel::caption(ui, rect, words);
            ui.ctx().request_repaint_after(SAID);
        }
    }
}

impl eframe::App for App {
    fn clear_color(&self, visuals: &egui::Visuals) -> [f32; 4] {
        visuals.panel_fill.to_normalized_gamma_f32()
    }

    fn ui(&mut self, ui: &mut egui::Ui, _: &mut eframe::Frame) {
        let ctx = ui.ctx().clone();
        let now = Instant::now();
        self.frames.retain(|frame| now - *frame < Duration::from_secs(1));
        self.frames.push_back(now);
        self.hear(&ctx);
        self.keys(&ctx);
        if self.panel {
            // The window is cleared in its colour.
            let frame = egui::Frame::side_top_panel(ui.style()).fill(egui::Color32::TRANSPARENT);
            egui::Panel::left("panel").frame(frame).default_size(300.0).show(ui, |ui| panel::show(self, ui));
        }
        if let Source::Film(_) = self.source {
            egui::Panel::bottom("time").show(ui, |ui| panel::time_bar(self, ui));
        }
        egui::CentralPanel::default().frame(egui::Frame::NONE).show(ui, |ui| self.show_picture(ui));
        help::show(&ctx, &mut self.help);
        self.want();
    }
}
