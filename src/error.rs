//! The crate's error: what went wrong, where, and what the caller may do about it.

use std::fmt;
use std::path::PathBuf;

use glam::DVec3;

/// Result with the crate's [`Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Where in an input something was found.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Place {
    /// Nothing more precise is known.
    #[default]
    Unknown,
    /// A span of a text: 1-based line and column, byte offset and byte length.
    Text {
        /// 1-based line.
        line: usize,
        /// 1-based column, in characters.
        column: usize,
        /// Byte offset from the start of the text.
        offset: usize,
        /// Length in bytes.
        len: usize,
    },
    /// A line of a text file, 1-based.
    Line(usize),
    /// A byte of a binary file.
    Byte(u64),
    /// A point in space.
    Point(DVec3),
    /// A named or numbered thing, such as `triangle 12`.
    Item(String),
    /// A whole solid that is no body.
    Solid(NoBody),
}

/// What a solid is instead of a body with an end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoBody {
    /// Nothing is inside anywhere.
    Empty,
    /// It has no end, or none that can be proved.
    Endless,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::Unknown | Place::Solid(_) => Ok(()),
            Place::Text { line, column, .. } => write!(f, "line {line}, column {column}: "),
            Place::Line(line) => write!(f, "line {line}: "),
            Place::Byte(byte) => write!(f, "byte {byte}: "),
            Place::Point(p) => write!(f, "at ({:.6}, {:.6}, {:.6}): ", p.x, p.y, p.z),
            Place::Item(item) => write!(f, "{item}: "),
        }
    }
}

/// Everything that can stop a run. No input makes the library panic.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The caller asked to stop through [`Run`](crate::Run).
    #[error("cancelled")]
    Cancelled,
    /// The request itself makes no sense (a negative size, an unknown method or format).
    #[error("{0}")]
    Usage(String),
    /// The input cannot be used as it is.
    #[error("{}{place}{message}", file.as_ref().map(|f| format!("{}: ", f.display())).unwrap_or_default())]
    Input {
        /// The file, where there is one.
        file: Option<PathBuf>,
        /// Where in the input.
        place: Place,
        /// What is wrong.
        message: String,
        /// What would be right, where that is known.
        help: Option<String>,
    },
    /// The input is good, but no mesh of the asked kind was reached.
    #[error("{0}")]
    Failed(String),
    /// The operating system refused a file.
    #[error("cannot {action} {}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// `read`, `write`, `create`.
        action: &'static str,
        /// The system's own word.
        source: std::io::Error,
    },
}

impl Error {
    /// An [`Error::Input`] without file and help.
    pub fn input(place: Place, message: impl Into<String>) -> Self {
        Error::Input { file: None, place, message: message.into(), help: None }
    }

    /// Adds what would be right to an [`Error::Input`]; other errors stay as they are.
    pub fn with_help(mut self, text: impl Into<String>) -> Self {
        if let Error::Input { help, .. } = &mut self {
            *help = Some(text.into());
        }
        self
    }

    /// Adds the file to an [`Error::Input`] that has none yet; other errors stay as they are.
    pub fn in_file(mut self, path: impl Into<PathBuf>) -> Self {
        if let Error::Input { file: file @ None, .. } = &mut self {
            *file = Some(path.into());
        }
        self
    }

    /// An [`Error::Io`].
    pub fn io(action: &'static str, path: impl Into<PathBuf>, source: std::io::Error) -> Self {
        Error::Io { path: path.into(), action, source }
    }

    /// The exit code a command line reports: 2 usage, 3 bad input, 4 failed, 130 cancelled.
    pub fn exit_code(&self) -> u8 {
        match self {
            Error::Usage(_) => 2,
            Error::Input { .. } => 3,
            Error::Io { action: "read", .. } => 3,
            Error::Io { .. } | Error::Failed(_) => 4,
            Error::Cancelled => 130,
        }
    }
}

/// The name that takes the fewest edits to be this one.
pub(crate) fn nearest<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    known.map(|k| (edit_distance(k, name), k)).min().map(|(_, k)| k)
}

/// Insertions, deletions and exchanges from one word to the other.
pub(crate) fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().take(64).collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, c) in a.chars().take(64).enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for j in 0..b.len() {
            let next = (diagonal + usize::from(c != b[j])).min(row[j] + 1).min(row[j + 1] + 1);
            diagonal = row[j + 1];
            row[j + 1] = next;
        }
    }
    row[b.len()]
}
