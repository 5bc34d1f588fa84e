//! What a person sees: progress on a terminal, errors with the place in the source.

use std::collections::BTreeSet;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use miette::{GraphicalReportHandler, GraphicalTheme, LabeledSpan, MietteDiagnostic, NamedSource, Report, Severity};
use rvachev::run::CancelToken;
use rvachev::{Error, Place, Result, Run};

use super::arguments::CommonArguments;
use super::progress::Teller;

/// A run that Ctrl-C cancels and nobody watches. Once a process.
pub fn unwatched(common: &CommonArguments) -> Result<Run> {
    let token = CancelToken::new();
    let handler = token.clone();
    // a second Ctrl-C while the first is being answered is nothing new
    ctrlc::set_handler(move || handler.cancel()).map_err(|e| Error::Failed(format!("cannot watch for Ctrl-C: {e}")))?;
    Run::new().with_cancel(token).with_threads(common.threads)
}

/// The run of a command: Ctrl-C cancels it, and progress is shown unless nobody wants to see it.
pub fn run(common: &CommonArguments, command: &'static str) -> Result<Run> {
    Ok(watched(unwatched(common)?, common, command, false))
}

/// The same run with progress shown until it is dropped; with notes, these are told too, as they come.
pub fn watched(run: Run, common: &CommonArguments, command: &'static str, notes: bool) -> Run {
    if common.quiet && !notes {
        return run;
    }
    run.with_progress(Arc::new(Teller::new(command, !common.quiet, notes)))
}

/// Prints an error to standard error, with the source line where it has one.
pub fn explain(e: &Error) {
    let plainly = || eprintln!("error: {}", visible(&e.to_string()));
    let Error::Input { file, place, message, help } = e else { return plainly() };
    let (message, help) = (visible(message), help.as_deref().map(visible));
    let source = match (file, place) {
        (Some(f), Place::Text { .. }) => std::fs::read_to_string(f).ok().map(|text| (f, text)),
        _ => None,
    };
    let Some((file, text)) = source else {
        plainly();
        if let Some(h) = help {
            eprintln!("  help: {h}");
        }
        return;
    };
    let Place::Text { line, column, offset, len } = place else { return };
    let mut d = MietteDiagnostic::new(&message).with_severity(Severity::Error);
    if let Some(h) = help {
        d = d.with_help(h);
    }
    // The span in the text as it is shown, where control characters are longer.
    let shown = |end: usize| text.get(..end.min(text.len())).map_or(end, |before| visible(before).len());
    let (start, end) = (shown(*offset), shown(offset.saturating_add((*len).max(1))));
    let text = visible(&text);
    d = d.with_label(LabeledSpan::new(Some("here".into()), start, end.min(text.len()).saturating_sub(start)));
    let name = visible(&file.display().to_string());
    let report = Report::new(d).with_source_code(NamedSource::new(&name, text));
    let theme =
        if std::io::stderr().is_terminal() { GraphicalTheme::unicode() } else { GraphicalTheme::unicode_nocolor() };
    let mut out = String::new();
    // the plain line first: what an editor or a script looks for
    eprintln!("error: {name}: line {line}, column {column}: {message}");
    if GraphicalReportHandler::new_themed(theme).with_links(false).render_report(&mut out, report.as_ref()).is_ok() {
        eprint!("{out}");
    }
}

/// Prints to standard output; a closed pipe is not an error.
pub fn say(text: &str) {
    use std::io::Write;
    let _ = writeln!(std::io::stdout(), "{}", visible(text));
}

/// The text with control characters, and those that turn the direction of writing, as `\u001b`: names in files must not
/// command a terminal. Ends of lines and tabs stay. It is how JSON writes them, so JSON stays what it is.
pub fn visible(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut ahead = text.chars().peekable();
    while let Some(c) = ahead.next() {
        let ends_line = c == '\n' || c == '\r' && ahead.peek() == Some(&'\n');
        let turns = matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
        if (c.is_control() || turns) && !ends_line && c != '\t' {
            out.push_str(&format!("\\u{:04x}", u32::from(c)));
        } else {
            out.push(c);
        }
    }
    out
}

/// Warnings and shortfalls, to standard error.
pub fn note(kind: &str, lines: &[impl std::fmt::Display]) {
    for l in lines {
        eprintln!("{kind}: {}", visible(&l.to_string()));
    }
}

/// Refuses names of pictures that promise another format than PNG, and what [`writable`] does.
pub fn picture(path: &Path) -> Result<()> {
    rvachev::pipeline::check_picture_name(path)?;
    writable(path)
}

/// Refuses to write two things to one file.
pub fn distinct<'a>(paths: impl Iterator<Item = &'a PathBuf>) -> Result<()> {
    let mut seen = BTreeSet::new();
    for path in paths {
        if !seen.insert(path) {
            return Err(Error::Usage(format!("{} would be written twice", path.display())));
        }
    }
    Ok(())
}

/// Refuses outputs that could not be written before any work is done.
pub fn writable(path: &Path) -> Result<()> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if folder.is_dir() {
        Ok(())
    } else {
        Err(Error::Usage(format!("cannot write {}: there is no folder {}", path.display(), folder.display())))
    }
}
