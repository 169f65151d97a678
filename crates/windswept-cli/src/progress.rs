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
    /// How many were done at the start, and how many there are in all.
    from: u64,
    all: u64,
    started: Instant,
    last_line: Instant,
}

impl Progress {
    /// Progress from `from` of `all`.
    pub(crate) fn new(what: &'static str, from: u64, all: u64, terminal: bool) -> Self {
        let style = format!("{{bar:32}} {{pos}}/{{len}} {what}  t = {{msg}} s  {{per_sec}}  {{eta}} left");
        let bar = terminal.then(|| {
            let bar = ProgressBar::with_draw_target(Some(all), ProgressDrawTarget::stderr());
            // A template that does not parse leaves the default bar.
            bar.set_style(ProgressStyle::with_template(&style).unwrap_or_else(|_| ProgressStyle::default_bar()));
            // The part that was done before is not counted in the speed.
            bar.set_position(from);
            bar.reset_eta();
            bar
        });
        Self { bar, what, from, all, started: Instant::now(), last_line: Instant::now() }
    }

    /// `time` is the simulated time [s].
    pub(crate) fn show(&mut self, done: u64, time: f64, console: &mut Console<'_>) {
        if done == self.from {
            // Before the first step there was the picture of the start.
            self.started = Instant::now();
            self.bar.iter().for_each(ProgressBar::reset_eta);
        }
        if let Some(bar) = &self.bar {
            bar.set_message(format!("{time:.3}"));
            bar.set_position(done);
        } else if self.last_line.elapsed() >= PAUSE && done > self.from {
            self.last_line = Instant::now();
            console.note(self.line(done, time, self.started.elapsed().as_secs_f64()));
        }
    }

    /// The line after so many seconds.
    fn line(&self, done: u64, time: f64, elapsed: f64) -> String {
        let speed = (done - self.from) as f64 / elapsed;
        let left = (self.all - done) as f64 / speed;
        let Self { what, all, .. } = self;
        format!("{done} of {all} {what}, t = {time:.3} s, {speed:.1} a second, {left:.0} s left")
    }

    /// Clears the bar, so that what follows starts on a clean line.
    pub(crate) fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::thread::sleep;

    use super::*;

    /// The speed of a run that goes on from its middle does not count the steps that were done before.
    #[test]
    fn what_was_done_before_does_not_count() {
        let lines = Progress::new("steps", 1000, 1100, false);
        assert_eq!(lines.line(1050, 0.5, 10.0), "1050 of 1100 steps, t = 0.500 s, 5.0 a second, 10 s left");
        let (mut out, mut err) = (Vec::new(), Vec::new());
        let mut console = Console::new(&mut out, &mut err, true);
        let mut progress = Progress::new("steps", 1_000_000_000, 2_000_000_000, true);
        sleep(Duration::from_millis(2));
        progress.show(1_000_000_001, 0.0, &mut console);
        // One step in 2 ms at least.
        let speed = progress.bar.as_ref().map(ProgressBar::per_sec);
        assert!(speed.is_some_and(|speed| speed > 0.0 && speed < 501.0), "{speed:?}");
    }
}
