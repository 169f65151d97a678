//! The `windswept` command: `run`, `view`, `render`, `export`, `measure`, `spectrum`, `check`, `plan`, `groom`,
//! `validate`, `adapters`. `spectrum`, `validate` and `view` are features of the crate, the first two on by default.
//!
//! [`run`] is the whole command. Its help names the exit statuses.

mod arguments;
mod console;
mod export;
mod failure;
mod finished;
mod groom;
mod inspect;
mod interrupt;
mod measure;
mod output;
mod progress;
mod render;
mod run;
#[cfg(feature = "spectrum")]
mod spectrum;
mod trial;
#[cfg(feature = "validate")]
mod validate;
#[cfg(feature = "view")]
mod view;

use std::ffi::OsString;
use std::io::{IsTerminal, Write, stderr, stdout};
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook};
use std::process::ExitCode;

use clap::Parser;

use crate::arguments::{Arguments, Command};
use crate::console::Console;
use crate::failure::Failure;

/// Runs the command with these arguments, the program's name first, on the standard streams.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    ExitCode::from(status(arguments))
}

/// Runs the command with these arguments on the standard streams, and returns the exit status.
pub fn status(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    // A defect of ours still ends in a sentence and a status, not in a backtrace.
    set_hook(Box::new(|defect| {
        let _ = writeln!(stderr(), "error: windswept has a defect, please report this: {defect}");
    }));
    // A file that would grow beyond the limit of the shell cannot be written, as on a full disk; else the system would
    // end the process.
    #[cfg(unix)]
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, std::sync::Arc::default());
    let terminal = stderr().is_terminal();
    catch_unwind(AssertUnwindSafe(|| run_on(arguments, &mut stdout(), &mut stderr(), terminal))).unwrap_or(1)
}

/// Runs the command on streams of the caller's, and returns the exit status.
///
/// `terminal` says whether `err` is one: a progress bar and drawn diagnostics then, else plain lines. The bar always
/// goes to the process's own standard error.
pub fn run_on(
    arguments: impl IntoIterator<Item = OsString>,
    out: &mut dyn Write,
    err: &mut dyn Write,
    terminal: bool,
) -> u8 {
    let mut console = Console::new(out, err, terminal);
    let done = match Arguments::try_parse_from(arguments) {
        Ok(arguments) => dispatch(&arguments.command, &mut console).map(|()| 0),
        Err(usage) => Ok(console.usage(&usage)),
    };
    let written = console.end();
    match done.and_then(|status| written.map(|()| status)) {
        Ok(status) => status,
        Err(failure) => {
            console.failure(&failure);
            failure.status()
        }
    }
}

fn dispatch(command: &Command, console: &mut Console<'_>) -> Result<(), Failure> {
    match command {
        Command::Run(options) => run::run(options, console),
        #[cfg(feature = "view")]
        Command::View(options) => view::view(options),
        #[cfg(not(feature = "view"))]
        Command::View { .. } => Err(Failure::Input(
            "this windswept is built without its window; in a clone `cargo build --release --package windswept-cli \
             --features view` builds one with it"
                .to_owned(),
        )),
        Command::Render(options) => render::render(options, console),
        Command::Export(options) => export::export(options, console),
        Command::Check { schema: true, .. } => inspect::schema(console),
        Command::Check { path, changes, adapter, formats, explain, .. } => {
            let pictures = formats.is_empty() || formats.iter().any(|format| format == "png");
            inspect::check(path.as_deref(), changes, adapter.as_deref(), pictures, *explain, console)
        }
        Command::Plan { scene, buffers } => inspect::plan(scene, *buffers, console),
        Command::Measure(arguments) => measure::measure(arguments, console),
        #[cfg(feature = "spectrum")]
        Command::Spectrum(options) => spectrum::spectrum(options, console),
        #[cfg(feature = "validate")]
        Command::Validate(options) => validate::validate(options, console),
        Command::Groom(command) => groom::groom(command, console),
        Command::Adapters => inspect::adapters(console),
    }
}
