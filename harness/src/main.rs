//! The command line of tracebench.

use std::process::ExitCode;

fn main() -> ExitCode {
    tracebench_harness::cli::main()
}
