//! The `rvachev` command: parses the command line and calls the pipeline. No algorithm lives here.

mod cli;

#[global_allocator]
static MEMORY: cli::Ending = cli::Ending;

fn main() -> std::process::ExitCode {
    cli::main()
}
