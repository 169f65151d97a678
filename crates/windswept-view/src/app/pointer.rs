//! What the pointer does in the picture: it moves the camera and bodies, and says what it is over.

use eframe::egui::{self, Color32, PointerButton, Rect, Response, vec2};
use glam::{DQuat, DVec3};
use windswept::Pose;

use super::{App, Source};
use crate::fields::HairColour;
use crate::panel;
use crate::picking::{Grip, body_at, point_at};
use crate::picture::State;
use crate::worker::Ask;

/// Turn of a body by a drag over a pixel \[rad\].
const TURN: f64 = 0.01;

/// A body that is dragged.
pub(super) struct Drag {
    grip: Grip,
    /// Where the pointer gripped it.
    from: egui::Pos2,
    turns: bool,
}

impl App {
    pub(super) fn move_camera(&mut self, ui: &egui::Ui, response: &Response, rect: Rect, state: &State) {
        let shift = ui.input(|input| input.modifiers.shift);
        let started = [PointerButton::Primary, PointerButton::Secondary].map(|button| response.drag_started_by(button));
        if shift && started.contains(&true) {
            let from = ui.input(|input| input.pointer.press_origin()).or(response.interact_pointer_pos());
            let grip = from.and_then(|at| {
                body_at(&state.scene, &state.frame, &self.orbit.view(self.size()), self.pixel(rect, at))
            });
            self.drag = grip.zip(from).map(|(grip, from)| Drag { grip, from, turns: started[1] });
        }
        if response.drag_stopped() {
            self.drag = None;
        }
        let by = response.drag_delta();
        let by = [f64::from(by.x), f64::from(by.y)];
        let height = f64::from(rect.height());
        if let (Some(drag), Some(at)) = (&self.drag, response.interact_pointer_pos()) {
            let way = at - drag.from;
            let way = [f64::from(way.x), f64::from(way.y)];
            let Pose { translation, rotation } = drag.grip.pose;
            let pose = if drag.turns {
                let [right, ..] = self.orbit.view(self.size()).axes();
                let turn = DQuat::from_rotation_y(TURN * way[0]) * DQuat::from_axis_angle(right, TURN * way[1]);
                Pose { translation, rotation: turn * rotation }
            } else {
                Pose { translation: translation + self.orbit.way(way, height, drag.grip.depth), rotation }
            };
            let name = drag.grip.name.clone();
            if by != [0.0; 2] {
                self.ask(Ask::Body(name, pose));
                if !self.is_playing() {
                    self.say("paused: the body follows once time passes");
                }
            }
        } else if response.dragged_by(PointerButton::Primary) {
            self.orbit.turn(by);
        } else if response.dragged_by(PointerButton::Secondary) || response.dragged_by(PointerButton::Middle) {
            self.orbit.pan(by, height);
        }
        if response.hovered() {
            let (scroll, zoom) = ui.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta()));
            self.orbit.zoom(f64::from(scroll) + 500.0 * f64::from(zoom).ln());
        }
    }

    pub(super) fn size(&self) -> [u32; 2] {
        self.size.unwrap_or([16, 16])
    }

    fn size_as_vec(&self) -> egui::Vec2 {
        let [width, height] = self.size();
        vec2(width as f32, height as f32)
    }

    /// A place of the window in the picture \[px\].
    fn pixel(&self, rect: Rect, at: egui::Pos2) -> [f64; 2] {
        let at = (at - rect.min) / rect.size() * self.size_as_vec();
        [f64::from(at.x), f64::from(at.y)]
    }

    /// Says what the pointer is over.
    pub(super) fn point(&mut self, ui: &egui::Ui, response: &Response, rect: Rect, state: &State) {
        let at = response.hover_pos().filter(|_| !response.dragged());
        self.hovered = at.is_some();
        let Some(at) = at else { return };
        let (view, pixel) = (self.orbit.view(self.size()), self.pixel(rect, at));
        let lines = if let Some(point) = point_at(&state.frame, &view, pixel) {
            let hair = &state.frame.hair;
            let [x, y, z] = hair.positions[point.row].map(|x| 1e3 * x);
            let id = hair.ids.get(point.strand).map(|id| format!(" ({id} of its file)")).unwrap_or_default();
            let points = hair.offsets[point.strand + 1] - hair.offsets[point.strand];
            let place = view.project(DVec3::from_array(hair.positions[point.row].map(f64::from)));
            if let Some([u, v]) = place {
                let scale = rect.size() / self.size_as_vec();
                let mark = rect.min + vec2(u as f32, v as f32) * scale;
                ui.painter().with_clip_rect(rect).circle_stroke(mark, 4.0, (1.5, Color32::WHITE));
            }
            let mut lines = vec![
                format!("strand {}{id}, point {} of 0 to {}", point.strand, point.point, points - 1),
                format!("{x:.1}, {y:.1}, {z:.1} mm"),
            ];
            let values = match &self.source {
                Source::Live(_, now) => now.pointed.to_vec(),
                Source::Film(playback) => {
                    let all = HairColour::ALL.iter().skip(1);
                    all.map(|colour| colour.values(&state.frame, None, &playback.rest)).collect()
                }
            };
            for (colour, values) in HairColour::ALL.iter().skip(1).zip(values) {
                if let Some(value) = values.get(point.row) {
                    lines.push(format!("{} {value:.3} {}", colour.name(), colour.unit()));
                }
            }
            lines
        } else if let Some(grip) = body_at(&state.scene, &state.frame, &view, pixel) {
            let live = matches!(self.source, Source::Live(..));
            let hint = if live { "\nShift + drag moves it" } else { "" };
            vec![format!("{}{hint}", grip.name)]
        } else {
            return;
        };
        panel::tip(ui, rect, at, &lines.join("\n"));
    }
}
