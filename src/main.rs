//! The program: see the library for what it does.

fn main() -> std::process::ExitCode {
    soilsig::cli::run(std::env::args_os()).into()
}
