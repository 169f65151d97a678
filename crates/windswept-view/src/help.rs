//! Keys and the pointer, as the window explains them.

use eframe::egui::{self, Align2};

/// What the pointer and keys do.
const KEYS: [(&str, &str); 19] = [
    ("drag", "turn the camera"),
    ("right or middle drag", "move the camera"),
    ("wheel", "come nearer"),
    ("Shift + drag a body", "move it"),
    ("Shift + right drag a body", "turn it"),
    ("point at hair", "strand, point and its values"),
    ("Space", "play, pause"),
    (".", "one step, or one frame of a film"),
    (",", "the frame before, of a film"),
    ("R", "start over, with the dials as they are"),
    ("G", "gust"),
    ("F", "frame the hair"),
    ("Home", "the scene's own camera"),
    ("L", "lines or film look"),
    ("P", "save a picture"),
    ("V", "film: begin or end"),
    ("H", "hide or show the panel"),
    ("F1", "this help"),
    ("Ctrl + Q", "close"),
];

/// Shows the window of help while it is open.
pub(crate) fn show(ctx: &egui::Context, open: &mut bool) {
    let window = egui::Window::new("Keys").open(open).collapsible(false).resizable(false);
    window.anchor(Align2::RIGHT_TOP, [-12.0, 12.0]).show(ctx, |ui| {
        egui::Grid::new("keys").num_columns(2).spacing([16.0, 4.0]).show(ui, |ui| {
            for (key, does) in KEYS {
                ui.strong(key);
                ui.label(does);
                ui.end_row();
            }
        });
    });
}
