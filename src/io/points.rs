//! Points as rows of text, read a block at a time, and rows of what was found at them.

use std::io::{BufRead, Read, Write};
use std::path::{Path, PathBuf};

use glam::DVec3;

use super::atomic::write_failed;
use super::text::{at, quote};
use crate::error::{Error, Place, Result};

/// Bytes a row may have: more is no table of points.
const LONGEST: u64 = 1 << 16;

/// Which fields of a row are x, y and z, and how many fields it has.
#[derive(Debug, Clone, Copy)]
struct Columns {
    at: [usize; 3],
    count: usize,
}

/// Rows `x y z` of a text, with commas, semicolons, tabs or blanks between the numbers.
///
/// Blank lines and lines that begin with `#` are skipped. The first row may name the columns; then x, y and z are found by name,
/// with or without a unit in brackets behind, and other columns are passed over. Without names there are three numbers in a row.
pub struct PointRows<R> {
    from: R,
    name: PathBuf,
    line: usize,
    columns: Option<Columns>,
}

impl<R: BufRead> PointRows<R> {
    /// Rows from `from`, of which nothing is read yet; errors call it `name`.
    pub fn new(from: R, name: impl Into<PathBuf>) -> Self {
        PointRows { from, name: name.into(), line: 0, columns: None }
    }

    /// What errors call the table.
    pub fn name(&self) -> &Path {
        &self.name
    }

    /// Replaces what is in `points` and `lines` by up to `most` further points and the numbers of their lines. No points are the end
    /// of the text.
    ///
    /// Errors: [`Error::Input`] with the line of a row that is not three finite numbers; [`Error::Io`].
    pub fn read(&mut self, most: usize, points: &mut Vec<DVec3>, lines: &mut Vec<usize>) -> Result<()> {
        points.clear();
        lines.clear();
        self.fill(most, points, lines).map_err(|e| e.in_file(&self.name))
    }

    fn fill(&mut self, most: usize, points: &mut Vec<DVec3>, lines: &mut Vec<usize>) -> Result<()> {
        let mut bytes = Vec::new();
        while points.len() < most && self.next_line(&mut bytes)? {
            let text = String::from_utf8_lossy(&bytes);
            let text = text.trim();
            if text.is_empty() || text.starts_with('#') {
                continue;
            }
            let fields = Fields::new(text);
            let columns = match self.columns {
                Some(known) => known,
                None => {
                    let named = names(&fields);
                    let columns = named.unwrap_or(Columns { at: [0, 1, 2], count: 3 });
                    self.columns = Some(columns);
                    if named.is_some() {
                        continue;
                    }
                    columns
                }
            };
            points.push(self.point(&fields, columns)?);
            lines.push(self.line);
        }
        Ok(())
    }

    fn point(&self, fields: &Fields<'_>, columns: Columns) -> Result<DVec3> {
        let mut p = DVec3::ZERO;
        let mut count = 0;
        for field in fields.iter() {
            let axis = columns.at.iter().position(|c| *c == count);
            count += 1;
            let Some(axis) = axis else { continue };
            let name = ["x", "y", "z"][axis];
            let x: f64 =
                field.parse().map_err(|_| at(self.line, format!("{name} is {}, not a number", quote(field))))?;
            if !x.is_finite() {
                return Err(at(self.line, format!("{name} is {x}, not a finite number")));
            }
            p[axis] = x;
        }
        if count != columns.count {
            let e = at(self.line, format!("the row has {count} fields, not {}", columns.count));
            return Err(e.with_help("a row is x, y, z; a first row that names x, y and z allows other columns"));
        }
        Ok(p)
    }

    /// The next line without its end; false at the end of the text.
    fn next_line(&mut self, bytes: &mut Vec<u8>) -> Result<bool> {
        bytes.clear();
        let failed = |e| Error::io("read", &self.name, e);
        let n = self.from.by_ref().take(LONGEST).read_until(b'\n', bytes).map_err(failed)?;
        if n == 0 {
            return Ok(false);
        }
        self.line += 1;
        if n as u64 == LONGEST && bytes.last() != Some(&b'\n') {
            return Err(at(self.line, format!("the line is longer than {LONGEST} bytes: this is no table of points")));
        }
        if self.line == 1 && bytes.starts_with(b"\xef\xbb\xbf") {
            bytes.drain(..3);
        }
        Ok(true)
    }
}

/// The fields of a row, told apart by the strongest separator in it.
struct Fields<'a> {
    text: &'a str,
    separator: Option<char>,
}

impl<'a> Fields<'a> {
    fn new(text: &'a str) -> Self {
        Fields { text, separator: [';', ','].into_iter().find(|c| text.contains(*c)) }
    }

    fn iter(&self) -> impl Iterator<Item = &'a str> {
        let (by_sign, by_blank) = match self.separator {
            Some(c) => (Some(self.text.split(c).map(str::trim)), None),
            None => (None, Some(self.text.split_whitespace())),
        };
        by_sign.into_iter().flatten().chain(by_blank.into_iter().flatten())
    }
}

/// The columns by the names in a row; `None` if it does not name x, y and z, each once.
fn names(fields: &Fields<'_>) -> Option<Columns> {
    let plain = |field: &str| {
        let name = field.trim_matches('"').split(['[', '(']).next().unwrap_or_default().trim().to_ascii_lowercase();
        // As ParaView names the columns of points.
        match name.as_str() {
            "points:0" => "x".to_string(),
            "points:1" => "y".to_string(),
            "points:2" => "z".to_string(),
            _ => name,
        }
    };
    let all: Vec<String> = fields.iter().map(plain).collect();
    let find = |name: &str| {
        let mut found = (0..all.len()).filter(|i| all[*i] == name);
        found.next().filter(|_| found.next().is_none())
    };
    Some(Columns { at: [find("x")?, find("y")?, find("z")?], count: all.len() })
}

/// What is told of one point.
#[derive(Debug, Clone, Copy)]
pub struct PointSample<'a> {
    /// The point.
    pub point: DVec3,
    /// The function's value there.
    pub value: f64,
    /// Its gradient.
    pub gradient: DVec3,
    /// Whether the point is inside.
    pub inside: bool,
    /// The name of the face that decides; empty where none does.
    pub face: &'a str,
    /// The number of the leaf that decides; none where none does.
    pub leaf: Option<u32>,
}

impl PointSample<'_> {
    /// The names of the columns, as the first row of a file.
    pub const HEADER: &'static str = "x,y,z,value,gx,gy,gz,inside,face,leaf\n";

    /// Writes the row. Numbers are the shortest that read back as the same; inside is 1 or 0; a name with a comma or a quotation mark
    /// is quoted, and its control characters are as JSON writes them.
    pub fn write(&self, out: &mut Vec<u8>) {
        let mut buffer = zmij::Buffer::new();
        let numbers = self.point.to_array().into_iter().chain([self.value]).chain(self.gradient.to_array());
        for x in numbers {
            out.extend(buffer.format(x).as_bytes());
            out.push(b',');
        }
        out.extend([b'0' + u8::from(self.inside), b',']);
        let quoted = self.face.contains([',', '"', ';']);
        out.extend(quoted.then_some(b'"'));
        for c in self.face.chars() {
            match c {
                '"' => out.extend(b"\"\""),
                c if c.is_control() => out.extend(format!("\\u{:04x}", u32::from(c)).as_bytes()),
                c => out.extend(c.encode_utf8(&mut [0; 4]).as_bytes()),
            }
        }
        out.extend(quoted.then_some(b'"'));
        out.push(b',');
        if let Some(leaf) = self.leaf {
            out.extend(itoa::Buffer::new().format(leaf).as_bytes());
        }
        out.push(b'\n');
    }
}

/// Writes bytes; a reader that has closed the other end of a pipe has seen enough, and false is returned.
///
/// Errors: [`Error::Io`] without a path.
pub fn write_rows(out: &mut dyn Write, bytes: &[u8]) -> Result<bool> {
    match out.write_all(bytes) {
        Ok(()) => Ok(true),
        Err(e) if e.kind() == std::io::ErrorKind::BrokenPipe => Ok(false),
        Err(e) => Err(write_failed(e)),
    }
}

/// The error of a table without points.
pub fn no_rows() -> Error {
    Error::input(Place::Unknown, "there are no points: a row is x, y, z")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<(Vec<DVec3>, Vec<usize>)> {
        let (mut points, mut lines) = (Vec::new(), Vec::new());
        PointRows::new(text.as_bytes(), "points.csv").read(100, &mut points, &mut lines)?;
        Ok((points, lines))
    }

    #[test]
    fn every_separator_and_named_columns_are_read() {
        let truth = vec![DVec3::new(1.0, -2.5, 3e-3), DVec3::new(4.0, 5.0, 6.0)];
        for text in [
            "1,-2.5,3e-3\n4,5,6\n",
            "1 ; -2.5;3e-3\r\n4;5;6",
            "\u{feff}1\t-2.5\t3e-3\n\n4\t5\t6\n",
            "# a table\n  1   -2.5 3e-3\n4 5 6\n",
            "X,Y,Z\n1,-2.5,3e-3\n4,5,6\n",
            "id;z [mm];y [mm];x [mm]\na;3e-3;-2.5;1\nb;6;5;4\n",
            "\"Points:0\",\"Points:1\",\"Points:2\",\"t\"\n1,-2.5,3e-3,nan\n4,5,6,\n",
        ] {
            assert_eq!(read(text).unwrap().0, truth, "{text:?}");
        }
        assert_eq!(read("x y z\n\n1 2 3\n#\n4 5 6\n").unwrap().1, [3, 5]);
    }

    #[test]
    fn bad_rows_name_their_line() {
        for (text, wanted) in [
            ("1,2,3\n4,5\n", "line 2: the row has 2 fields, not 3"),
            ("1,2,3,4\n", "line 1: the row has 4 fields, not 3"),
            ("x,y,z\n1,2,3\n1,two,3\n", "line 3: y is `two`, not a number"),
            ("1,2,nan\n", "line 1: z is NaN, not a finite number"),
            ("1 2 3\n-inf 2 3\n", "line 2: x is -inf, not a finite number"),
            ("1,,3\n", "line 1: y is ``, not a number"),
            ("a,b,c\n1,2,3\n", "line 1: x is `a`, not a number"),
            ("x,y,x\n1,2,3\n", "line 1: x is `x`, not a number"),
            ("0,5;1,5;2,5\n", "line 1: x is `0,5`, not a number"),
        ] {
            assert_eq!(read(text).unwrap_err().to_string(), format!("points.csv: {wanted}"), "{text:?}");
        }
        let long = "1".repeat(1 << 17);
        assert!(read(&long).unwrap_err().to_string().contains("longer"));
    }
}
