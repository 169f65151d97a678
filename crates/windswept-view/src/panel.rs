//! The panel beside the picture, and what is written over the picture.

use eframe::egui::{
    self, Align2, Button, Color32, ComboBox, FontId, Grid, Rect, RichText, ScrollArea, Slider, TextEdit, Ui, pos2, vec2,
};
use windswept_export::Format;

use crate::app::{App, SAID, Source};
use crate::dials::{DIALS, Group, Wind};
use crate::fields::{AirColour, AirLook, HairColour, RAMP};
use crate::picture::Look;
use crate::worker::Ask;

/// Behind words in the picture.
const SHADE: Color32 = Color32::from_rgba_premultiplied(12, 14, 18, 200);
/// Fewest hairs that the film look is asked for.
const FEWEST_HAIRS: u32 = 100;
const WARNING: Color32 = Color32::from_rgb(240, 190, 90);
const RECORDING: Color32 = Color32::from_rgb(235, 90, 80);

/// The panel.
pub(crate) fn show(app: &mut App, ui: &mut Ui) {
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        ui.spacing_mut().slider_width = 130.0;
        ui.add_space(6.0);
        let title = app.scene().title.clone();
        ui.label(RichText::new(if title.is_empty() { "windswept" } else { &title }).heading());
        run(app, ui);
        if matches!(app.source, Source::Live(..)) {
            wind(app, ui);
            dials(app, ui, "Eddies", Group::Eddies);
            dials(app, ui, "Hair", Group::Hair);
        }
        looks(app, ui);
        files(app, ui);
        warnings(app, ui);
    });
}

/// A heading and what belongs to it.
fn section(ui: &mut Ui, name: &str, content: impl FnOnce(&mut Ui)) {
    ui.add_space(4.0);
    egui::CollapsingHeader::new(RichText::new(name).strong()).default_open(true).show(ui, content);
}

fn run(app: &mut App, ui: &mut Ui) {
    let live = matches!(app.source, Source::Live(..));
    ui.add_space(4.0);
    ui.horizontal(|ui| {
        let playing = app.is_playing();
        let size = vec2(64.0, 24.0);
        if ui.add(Button::new(if playing { "Pause" } else { "Play" }).min_size(size)).clicked() {
            app.play(!playing);
        }
        if !live && ui.add(Button::new("Back").min_size(size)).clicked() {
            app.step(-1);
        }
        if ui.add(Button::new("Step").min_size(size)).clicked() {
            app.step(1);
        }
        if ui.add(Button::new("Start over").min_size(vec2(80.0, 24.0))).clicked() {
            app.restart();
        }
    });
    ui.add_space(4.0);
    let (time, count) = app.time();
    let mut rows = vec![("time", format!("{time:.4} s")), (if live { "steps" } else { "frame" }, count.to_string())];
    if let Source::Live(_, now) = &app.source {
        let known = |value: f64, text: String| if value > 0.0 { text } else { "–".to_owned() };
        rows.push(("per step", known(now.step_ms, format!("{:.1} ms", now.step_ms))));
        rows.push(("real time", known(now.real_time, format!("× {:.3}", now.real_time))));
    }
    rows.push(("pictures", format!("{:.0} /s", app.rate())));
    rows.push(("adapter", app.adapter().to_owned()));
    Grid::new("numbers").num_columns(2).spacing([16.0, 2.0]).show(ui, |ui| {
        for (name, value) in rows {
            ui.label(name);
            ui.add(egui::Label::new(RichText::new(value).monospace()).truncate());
            ui.end_row();
        }
    });
    let before = app.pace;
    let pace = Slider::new(&mut app.pace, 0.01..=1.0).logarithmic(true).text("pace, at most").prefix("× ");
    ui.add(pace).on_hover_text("time that passes in the picture over that on the clock");
    if app.pace != before {
        let pace = app.pace;
        match &mut app.source {
            Source::Live(worker, _) => worker.ask(Ask::Pace(pace)),
            Source::Film(playback) => playback.set_pace(pace),
        }
    }
}

fn wind(app: &mut App, ui: &mut Ui) {
    let Some(mut wind) = app.wind else { return };
    section(ui, "Wind", |ui| {
        ui.add(Slider::new(&mut wind.speed, 0.0..=Wind::FASTEST).text("speed").suffix(" m/s"));
        let azimuth = Slider::new(&mut wind.azimuth, -180.0..=180.0).text("direction").suffix("°").max_decimals(0);
        ui.add(azimuth).on_hover_text("where it blows to, from +x toward +z");
        ui.add(Slider::new(&mut wind.elevation, -90.0..=90.0).text("upward").suffix("°").max_decimals(0));
        ui.horizontal(|ui| {
            ui.add(Slider::new(&mut app.gust, 0.5..=Wind::FASTEST).text("gust").suffix(" m/s"));
            if ui.button("Gust now").clicked() {
                app.blow();
            }
        });
        if app.wind != Some(wind) {
            app.wind = Some(wind);
            app.ask(Ask::Wind(wind.velocity()));
        }
    });
}

fn dials(app: &mut App, ui: &mut Ui, name: &str, group: Group) {
    let own = || DIALS.iter().enumerate().filter(move |(_, dial)| dial.group == group);
    if !own().any(|(k, _)| app.dials.get(k).is_some_and(Option::is_some)) {
        return;
    }
    section(ui, name, |ui| {
        for (k, dial) in own() {
            let Some(mut value) = app.dials.get(k).copied().flatten() else { continue };
            let before = value;
            // A scene's value may be beyond the slider's ends.
            let ends = dial.ends.start().min(value)..=dial.ends.end().max(value);
            let suffix = if dial.unit.is_empty() { String::new() } else { format!(" {}", dial.unit) };
            ui.add(Slider::new(&mut value, ends).logarithmic(dial.logarithmic).text(dial.name).suffix(suffix));
            if value != before {
                app.dials[k] = Some(value);
                app.ask(Ask::Dial(k, value));
            }
        }
    });
}

fn looks(app: &mut App, ui: &mut Ui) {
    section(ui, "View", |ui| {
        ui.horizontal(|ui| {
            ui.selectable_value(&mut app.looks.look, Look::Lines, "Lines");
            ui.selectable_value(&mut app.looks.look, Look::Film, "Film");
            if ui.button("Frame hair").clicked() {
                app.frame_hair();
            }
            if app.cameras.len() == 1 {
                if ui.button("Home").clicked() {
                    app.orbit = app.cameras[0].1;
                }
            } else {
                ComboBox::from_id_salt("camera").selected_text("Camera").width(70.0).show_ui(ui, |ui| {
                    for (name, orbit) in &app.cameras {
                        if ui.button(name).clicked() {
                            app.orbit = *orbit;
                        }
                    }
                });
            }
        });
        if app.looks.look == Look::Film {
            let [hairs, most] = app.hairs;
            let ends = FEWEST_HAIRS.min(hairs)..=most;
            let slider = Slider::new(&mut app.hairs[0], ends).logarithmic(true).text("hairs");
            // Other hairs are another groom, which takes a while: it is made once the slider is let go.
            if !ui.add(slider).dragged() {
                app.looks.hairs = app.hairs[0];
            }
        } else {
            choose(ui, "strands by", &mut app.looks.hair, &HairColour::ALL, HairColour::name);
            if app.scene().interaction.model.has_air() && has_air(app) {
                choose(ui, "air", &mut app.looks.air, &AirLook::ALL, AirLook::name);
                if app.looks.air != AirLook::Hidden && has_vorticity(app) {
                    choose(ui, "air by", &mut app.looks.air_colour, &AirColour::ALL, AirColour::name);
                }
            }
        }
        ui.add(Slider::new(&mut app.looks.sharpness, 0.25..=1.0).text("sharpness"));
    });
}

/// Whether the air of the state that is shown can be drawn.
fn has_air(app: &App) -> bool {
    match &app.source {
        Source::Live(..) => true,
        Source::Film(playback) => !playback.frame().air.positions.is_empty(),
    }
}

fn has_vorticity(app: &App) -> bool {
    match &app.source {
        Source::Live(..) => true,
        Source::Film(playback) => playback.has_vorticity(),
    }
}

fn choose<T: Copy + PartialEq>(ui: &mut Ui, label: &str, value: &mut T, all: &[T], name: fn(T) -> &'static str) {
    ComboBox::from_label(label).selected_text(name(*value)).width(110.0).show_ui(ui, |ui| {
        for one in all {
            ui.selectable_value(value, *one, name(*one));
        }
    });
}

fn files(app: &mut App, ui: &mut Ui) {
    section(ui, "Save", |ui| {
        ui.horizontal(|ui| {
            ui.label("into");
            ui.add(TextEdit::singleline(&mut app.out).desired_width(200.0)).on_hover_text("made when it is needed");
        });
        let out = std::path::PathBuf::from(&app.out);
        let film = match &app.source {
            Source::Live(_, now) => Some(now.film.clone()),
            Source::Film(_) => None,
        };
        ui.horizontal(|ui| {
            if ui.button("Picture").clicked() {
                app.save_picture();
            }
            if film.is_some() {
                if ui.button("Scene").on_hover_text("with all that was changed, for `windswept run`").clicked() {
                    app.ask(Ask::SaveScene(out.clone()));
                }
                if ui.button("Checkpoint").on_hover_text("the simulation itself, for `windswept view`").clicked() {
                    app.ask(Ask::SaveCheckpoint(out));
                }
            }
        });
        let Some(film) = film else { return };
        ui.horizontal(|ui| {
            let recording = film.is_some();
            let words =
                if recording { RichText::new("End film").color(RECORDING) } else { RichText::new("Record film") };
            let may = recording || !app.formats.is_empty();
            if ui.add_enabled(may, Button::new(words)).clicked() {
                app.film();
            }
            ui.add_enabled_ui(!recording, |ui| {
                for format in Format::of_runs() {
                    let mut chosen = app.formats.contains(&format.name);
                    if ui.checkbox(&mut chosen, format.name).on_hover_text(format.writes).changed() {
                        app.formats.retain(|name| *name != format.name);
                        app.formats.extend(chosen.then_some(format.name));
                    }
                }
            });
        });
        // The row is there without a film too, so that nothing below it moves.
        let words = film.map(|(folder, frames)| format!("{}: {frames} frames", folder.display())).unwrap_or_default();
        ui.label(RichText::new(words).color(RECORDING));
    });
}

fn warnings(app: &App, ui: &mut Ui) {
    let Source::Live(_, now) = &app.source else { return };
    if !now.warnings.is_empty() {
        section(ui, "Warnings", |ui| {
            for warning in now.warnings.iter() {
                ui.label(RichText::new(warning).color(WARNING).small());
            }
        });
    }
}

/// The frames of a film as a bar that can be dragged along.
pub(crate) fn time_bar(app: &mut App, ui: &mut Ui) {
    ui.add_space(4.0);
    ui.horizontal(|ui| {
        let Source::Film(playback) = &mut app.source else { return };
        let (mut at, times) = (playback.at(), playback.times());
        let (last, end) = (times.len() - 1, times[times.len() - 1]);
        let words = format!("{:.3} of {end:.3} s, frame {at} of {last}", playback.frame().time);
        ui.spacing_mut().slider_width = (ui.available_width() - 340.0).max(100.0);
        ui.add(Slider::new(&mut at, 0..=last).show_value(false).text("time"));
        ui.monospace(words);
        if at != playback.at()
            && let Err(error) = playback.seek(at)
        {
            app.say(error.to_string());
        }
    });
    ui.add_space(2.0);
}

/// The scales of the colours, in the picture's lower right corner, and the key of help in the left one.
pub(crate) fn legends(app: &App, ui: &Ui, rect: Rect) {
    let painter = ui.painter().with_clip_rect(rect);
    let font = FontId::proportional(12.0);
    if app.said.as_ref().is_none_or(|(when, _)| when.elapsed() >= SAID) {
        let at = pos2(rect.left() + 10.0, rect.bottom() - 8.0);
        painter.text(at, Align2::LEFT_BOTTOM, "F1: keys", font.clone(), Color32::from_gray(70));
    }
    if app.looks.look == Look::Film {
        return;
    }
    let [hair, air] = app.picture.ranges();
    let mut rows = Vec::new();
    if app.looks.air != AirLook::Hidden && air > 0.0 {
        let colour = app.looks.air_colour;
        rows.push(format!("air: {} to {} {}", colour.name(), rounded(air), colour.unit()));
    }
    if app.looks.hair != HairColour::Hair && hair > 0.0 {
        let colour = app.looks.hair;
        rows.push(format!("strands: {} to {} {}", colour.name(), rounded(hair), colour.unit()));
    }
    let mut bottom = rect.bottom() - 12.0;
    for words in rows {
        let bar = Rect::from_min_max(pos2(rect.right() - 222.0, bottom - 10.0), pos2(rect.right() - 12.0, bottom));
        painter.rect_filled(bar.expand2(vec2(6.0, 4.0)).with_min_y(bar.top() - 20.0), 4.0, SHADE);
        let slices = 70;
        for k in 0..slices {
            let part = |k: usize| bar.left() + bar.width() * k as f32 / slices as f32;
            let slice = Rect::from_x_y_ranges(part(k)..=part(k + 1) + 0.5, bar.y_range());
            painter.rect_filled(slice, 0.0, ramp((k as f32 + 0.5) / slices as f32));
        }
        let at = pos2(bar.left(), bar.top() - 3.0);
        painter.text(at, Align2::LEFT_BOTTOM, words, font.clone(), Color32::WHITE);
        bottom -= 40.0;
    }
}

/// Colour at a part of the ramp, mixed as the shader mixes it.
fn ramp(part: f32) -> Color32 {
    let at = (RAMP.len() - 1) as f32 * part.clamp(0.0, 1.0);
    let stop = (at as usize).min(RAMP.len() - 2);
    let colour = |stop: usize| egui::Rgba::from_srgba_unmultiplied(RAMP[stop][0], RAMP[stop][1], RAMP[stop][2], 255);
    egui::lerp(colour(stop)..=colour(stop + 1), at - stop as f32).into()
}

/// A number with three digits.
fn rounded(x: f32) -> String {
    let digits = 2 - (x.abs().max(1e-9).log10().floor() as i32);
    format!("{x:.*}", digits.clamp(0, 6) as usize)
}

/// Words in a shaded box at the foot of the picture.
pub(crate) fn caption(ui: &Ui, rect: Rect, words: &str) {
    boxed(ui, rect, words, |size| pos2(rect.left() + 12.0, rect.bottom() - 12.0 - size.y));
}

/// Words in a shaded box beside the pointer.
pub(crate) fn tip(ui: &Ui, rect: Rect, at: egui::Pos2, words: &str) {
    boxed(ui, rect, words, |size| {
        let place = at + vec2(16.0, 16.0);
        place.min(rect.max - size - vec2(14.0, 10.0)).max(rect.min + vec2(8.0, 6.0))
    });
}

fn boxed(ui: &Ui, rect: Rect, words: &str, place: impl FnOnce(egui::Vec2) -> egui::Pos2) {
    let painter = ui.painter().with_clip_rect(rect);
    let width = (rect.width() - 40.0).max(80.0);
    let words = painter.layout(words.to_owned(), FontId::proportional(13.0), Color32::WHITE, width);
    let at = place(words.size());
    painter.rect_filled(Rect::from_min_size(at, words.size()).expand2(vec2(8.0, 5.0)), 4.0, SHADE);
    painter.galley(at, words, Color32::WHITE);
}
