//! The two streams: results to the first, everything about the run to the second.

use std::fmt::Display;
use std::io::{self, ErrorKind, Write};

use windswept_scene::spelled;

use crate::failure::Failure;

pub(crate) struct Console<'a> {
    out: &'a mut dyn Write,
    err: &'a mut dyn Write,
    /// Whether `err` is a terminal.
    pub(crate) terminal: bool,
    /// The first error of `out`.
    failed: Option<io::Error>,
}

impl<'a> Console<'a> {
    pub(crate) fn new(out: &'a mut dyn Write, err: &'a mut dyn Write, terminal: bool) -> Self {
        Self { out, err, terminal, failed: None }
    }

    /// Writes a line of the result, with its control characters spelled, since it may quote the user's names. After a
    /// line that could not be written no other is written; [`Self::end`] says why.
    pub(crate) fn print(&mut self, line: impl Display) {
        self.put(format_args!("{}\n", spelled(&line.to_string())));
    }

    /// Lines of the result that the program made itself.
    pub(crate) fn print_lines(&mut self, lines: impl Display) {
        self.put(format_args!("{lines}\n"));
    }

    /// Hands out what is left in memory.
    ///
    /// # Errors
    /// [`Failure::Run`] if the result could not be written. A reader that has gone away (`| head`) has seen what it
    /// wanted.
    pub(crate) fn end(&mut self) -> Result<(), Failure> {
        let failed = self.failed.take().map_or_else(|| self.out.flush(), Err);
        match failed {
            Err(e) if e.kind() != ErrorKind::BrokenPipe => Err(Failure::Run(format!("standard output: {e}"))),
            _ => Ok(()),
        }
    }

    fn put(&mut self, text: impl Display) {
        if self.failed.is_none() {
            self.failed = write!(self.out, "{text}").err();
        }
    }

    /// Writes a line about the run, with its control characters spelled; an error of writing it has no other channel,
    /// and is dropped.
    pub(crate) fn note(&mut self, line: impl Display) {
        let _ = writeln!(self.err, "{}", spelled(&line.to_string()));
    }

    pub(crate) fn warn(&mut self, what: impl Display) {
        self.note(format_args!("warning: {what}"));
    }

    pub(crate) fn failure(&mut self, failure: &Failure) {
        let _ = writeln!(self.err, "{}", failure.render(self.terminal).trim_end());
    }

    /// Help, version or a mistyped command, as clap words them; returns the exit status.
    pub(crate) fn usage(&mut self, usage: &clap::Error) -> u8 {
        let text = usage.render();
        if usage.use_stderr() {
            let _ = if self.terminal { write!(self.err, "{}", text.ansi()) } else { write!(self.err, "{text}") };
        } else {
            self.put(text);
        }
        u8::try_from(usage.exit_code()).unwrap_or(2)
    }
}

/// A number of frames as a sentence has it: "1 frame", "2 frames".
pub(crate) fn counted_frames(count: u64) -> String {
    format!("{count} frame{}", if count == 1 { "" } else { "s" })
}
