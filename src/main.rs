//! The `rvachev` command: parses the command line and calls the pipeline. No algorithm lives here.

mod cli;

fn main() -> std::process::ExitCode {
    cli::main()
}
