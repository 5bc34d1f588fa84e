//! Command line: arguments, exit codes, messages.

mod arguments;
mod bricks;
mod commands;
mod compare;
mod console;
mod gates;
mod http;
mod join;
mod manual;
mod memory;
mod path;
mod progress;
mod remesh;
mod sample;
mod serve;
mod watch;

use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches};
use rvachev::Error;

use arguments::{Cli, Command, Mesh, ViewPage};
pub use memory::Ending;

/// Runs the command. Exit codes: 0 good, 1 the result falls short of what was asked, 2 usage, 3 bad input, 4 failed, 130 cancelled.
pub fn main() -> ExitCode {
    let parsed = Cli::command().try_get_matches().and_then(|m| Ok((Cli::from_arg_matches(&m)?, m)));
    let (cli, matches) = match parsed {
        Ok(both) => both,
        Err(e) => {
            // help and version are not failures
            let code = if e.use_stderr() { 2 } else { 0 };
            let _ = e.print();
            return ExitCode::from(code);
        }
    };
    let run = |command, given| match command {
        Command::Mesh(a) => commands::mesh(&Mesh { given, ..a }),
        Command::View(a) if a.serve => serve::serve(ViewPage { given, ..a }),
        Command::View(a) => commands::mesh(&ViewPage { given, ..a }.into_mesh()),
        Command::Compare(a) => compare::compare(&a),
        Command::Check(a) => commands::check(&a),
        Command::Heal(a) => commands::heal(&a),
        Command::Join(a) => join::join(&a),
        Command::Info(a) => commands::info(&a),
        Command::Path(a) => path::path(&a),
        Command::Eval(a) => sample::eval(&a),
        Command::Grid(a) => sample::grid(&a),
        Command::Convert(a) => commands::convert(&a),
        Command::Render(a) => commands::render(&a),
        Command::Plan(a) => bricks::plan(&a),
        Command::Brick(a) => bricks::brick(&a),
        Command::Merge(a) => bricks::merge(&a),
        Command::Completions(a) => manual::completions(&a),
        Command::Man(a) => manual::manual(&a),
    };
    match gates::check(&matches).and_then(|given| run(cli.command, given)) {
        Ok(good) => ExitCode::from(u8::from(!good)),
        Err(e) => {
            console::explain(&e);
            ExitCode::from(Error::exit_code(&e))
        }
    }
}
