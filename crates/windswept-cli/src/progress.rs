//! Progress of a run: a bar on a terminal, a line now and then otherwise.

use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::console::Console;

/// Pause between two plain lines.
const PAUSE: Duration = Duration::from_secs(5);

pub(crate) struct Progress {
    bar: Option<ProgressBar>,
    /// Name of what is counted, in the plural.
    what: &'static str,
    all: u64,
    started: Instant,
    last_line: Instant,
}

impl Progress {
    pub(crate) fn new(what: &'static str, all: u64, terminal: bool) -> Self {
        let style = format!("{{bar:32}} {{pos}}/{{len}} {what}  t = {{msg}} s  {{per_sec}}  {{eta}} left");
        let bar = terminal.then(|| {
            let bar = ProgressBar::with_draw_target(Some(all), ProgressDrawTarget::stderr());
            // A template that does not parse leaves the default bar.
            bar.set_style(ProgressStyle::with_template(&style).unwrap_or_else(|_| ProgressStyle::default_bar()));
            bar
        });
        Self { bar, what, all, started: Instant::now(), last_line: Instant::now() }
    }

    /// `time` is the simulated time [s].
    pub(crate) fn show(&mut self, done: u64, time: f64, console: &mut Console<'_>) {
        if let Some(bar) = &self.bar {
            bar.set_message(format!("{time:.3}"));
            bar.set_position(done);
        } else if self.last_line.elapsed() >= PAUSE && done > 0 {
            self.last_line = Instant::now();
            let elapsed = self.started.elapsed().as_secs_f64();
            let left = elapsed / done as f64 * (self.all - done) as f64;
            let speed = done as f64 / elapsed;
            console.note(format_args!(
                "{done} of {} {}, t = {time:.3} s, {speed:.1} a second, {left:.0} s left",
                self.all, self.what
            ));
        }
    }

    /// Clears the bar, so that what follows starts on a clean line.
    pub(crate) fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
