//! How a bench ends.

use std::{error::Error, process::ExitCode};

/// The exit status of a bench; an error is printed as a user reads it.
pub(crate) fn status(result: Result<(), Box<dyn Error>>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
