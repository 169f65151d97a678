//! The `windswept` command; everything is in the library, so that the Python wheel can carry it too.
fn main() -> std::process::ExitCode {
    windswept_cli::run(std::env::args_os())
}
