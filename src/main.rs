use std::{process::ExitCode, time::Instant};

fn main() -> ExitCode {
    firstlight::cli::main(std::env::args_os(), Instant::now())
}
