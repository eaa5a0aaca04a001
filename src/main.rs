//! The `ergopath` program.

use std::process::ExitCode;

fn main() -> ExitCode {
    ergopath::cli::main()
}
