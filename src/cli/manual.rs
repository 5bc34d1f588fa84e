//! Shell completions and man pages, made from the options.

use std::io::Write;
use std::path::PathBuf;

use clap::{Args, CommandFactory};
use clap_complete::Shell;
use clap_mangen::Man;
use rvachev::{Error, Result, io};

use super::arguments::Cli;

#[derive(Debug, Args)]
pub struct Completions {
    /// The shell that shall know the options
    #[arg(value_enum, value_name = "SHELL")]
    pub shell: Shell,
}

#[derive(Debug, Args)]
pub struct Manual {
    /// Folder to write a page for each command to, made if it is not there [default: all pages to standard output, to be read with
    /// `man -l -`]
    #[arg(short, long, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
}

/// Writes to standard output; a closed pipe is not an error.
fn put(bytes: &[u8]) -> Result<()> {
    let mut out = std::io::stdout().lock();
    match out.write_all(bytes).and_then(|()| out.flush()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(Error::io("write", "standard output", e)),
        _ => Ok(()),
    }
}

pub fn completions(a: &Completions) -> Result<bool> {
    let mut script = Vec::new();
    clap_complete::generate(a.shell, &mut Cli::command(), "rvachev", &mut script);
    put(&script)?;
    Ok(true)
}

pub fn manual(a: &Manual) -> Result<bool> {
    let pages = pages()?;
    let Some(folder) = &a.output else {
        put(&pages.into_iter().flat_map(|p| p.1).collect::<Vec<_>>())?;
        return Ok(true);
    };
    std::fs::create_dir_all(folder).map_err(|e| Error::io("create", folder, e))?;
    for (name, page) in pages {
        let path = folder.join(name);
        io::write_atomic(&path, |out| out.write_all(&page).map_err(|e| Error::io("write", &path, e)))?;
    }
    Ok(true)
}

/// File names and texts of all pages: the command's, then one for each of its commands.
fn pages() -> Result<Vec<(String, Vec<u8>)>> {
    let mut all = Cli::command().disable_help_subcommand(true);
    // Only then commands know their full names.
    all.build();
    let commands = std::iter::once(all.clone()).chain(all.get_subcommands().filter(|c| !c.is_hide_set()).cloned());
    commands
        .map(|c| {
            let page = Man::new(c).source(concat!("rvachev ", env!("CARGO_PKG_VERSION"))).manual("rvachev");
            let mut text = Vec::new();
            page.render(&mut text).map_err(|e| Error::Failed(format!("cannot make a man page: {e}")))?;
            Ok((page.get_filename(), text))
        })
        .collect()
}
