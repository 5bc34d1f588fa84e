//! What is told of a mesh as one HTML file of tables, to be read, printed and kept: no picture, no script.

use super::{PageKind, PageText};

/// How the tables look, on screens and on paper.
const CSS: &str = include_str!("tables.css");

/// No line names more places than this: nobody reads them on paper.
const MOST_PLACES: usize = 20;

/// A column of a table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PageColumn {
    /// What stands above it.
    pub name: String,
    /// Whether it holds numbers, which stand on the right.
    pub number: bool,
}

/// A table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PageTable {
    /// What it holds.
    pub title: String,
    /// Its columns.
    pub columns: Vec<PageColumn>,
    /// Rows of cells, as plain text; a row may end early.
    pub rows: Vec<Vec<String>>,
}

impl PageTable {
    /// A table without rows. The names of columns of numbers begin with `#`, which is not shown.
    pub fn new(title: &str, columns: &[&str]) -> Self {
        let column = |name: &&str| match name.strip_prefix('#') {
            Some(name) => PageColumn { name: name.into(), number: true },
            None => PageColumn { name: (*name).into(), number: false },
        };
        Self { title: title.into(), columns: columns.iter().map(column).collect(), rows: Vec::new() }
    }

    /// Adds a row.
    pub fn row<const N: usize>(&mut self, cells: [String; N]) {
        self.rows.push(cells.into());
    }
}

/// Text as HTML shows it: nothing in it is markup, in elements and in quoted attributes alike. Control characters, and those that
/// turn the direction of writing, are shown as `\u001b`; ends of lines and tabs stay.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        let turns = matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            '\n' | '\t' => out.push(c),
            c if c.is_control() || turns => out.push_str(&format!("\\u{:04x}", u32::from(c))),
            c => out.push(c),
        }
    }
    out
}

fn put_table(out: &mut String, table: &PageTable) {
    out.push_str(&format!("<section>\n<h2>{}</h2>\n<table>\n<thead><tr>", escaped(&table.title)));
    let class = |number: bool| if number { " class=\"number\"" } else { "" };
    for c in &table.columns {
        out.push_str(&format!("<th{}>{}</th>", class(c.number), escaped(&c.name)));
    }
    out.push_str("</tr></thead>\n<tbody>\n");
    for row in &table.rows {
        out.push_str("<tr>");
        for (cell, column) in row.iter().zip(&table.columns) {
            out.push_str(&format!("<td{}>{}</td>", class(column.number), escaped(cell)));
        }
        out.push_str("</tr>\n");
    }
    out.push_str("</tbody>\n</table>\n</section>\n");
}

/// A place, in six digits.
fn shown_place(p: &[f64; 3]) -> String {
    format!("({}, {}, {})", short(p[0]), short(p[1]), short(p[2]))
}

/// A number in six digits, without zeros behind the last one that counts.
fn short(x: f64) -> String {
    let text = format!("{x:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.into() }
}

/// The lines of a page as a table: what each is about, its words, its places.
fn lines_table(text: &PageText) -> PageTable {
    let mut table = PageTable::new("What to look at", &["kind", "what", "places"]);
    for line in &text.lines {
        let kind = match line.kind {
            PageKind::Shortfall => "falls short",
            PageKind::Warning => "warning",
            PageKind::Unproved => "not proved",
            PageKind::Repair => "repaired",
            PageKind::Note => "note",
        };
        let mut places: Vec<String> = line.places.iter().take(MOST_PLACES).map(shown_place).collect();
        if line.places.len() > MOST_PLACES {
            places.push(format!("and {} more", line.places.len() - MOST_PLACES));
        }
        table.row([kind.into(), line.text.clone(), places.join("\n")]);
    }
    table
}

/// What is told of a mesh as an HTML file in UTF-8 with a table for each part of it, that needs nothing else and runs no script.
/// Names and words may be anything. The same text and tables give the same bytes.
pub fn tables(text: &PageText, tables: &[PageTable]) -> String {
    let title = escaped(&text.title);
    let mut out = format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'; img-src data:\">\n\
         <link rel=\"icon\" href=\"data:,\">\n<title>{title}: report</title>\n<style>\n{CSS}</style>\n</head>\n<body>\n<main>\n\
         <h1>{title}</h1>\n"
    );
    let short = text.lines.iter().filter(|l| l.kind == PageKind::Shortfall).count();
    let sound = match text.sound {
        Some(true) => "The mesh is sound",
        Some(false) => "The mesh is not sound",
        None => "Nobody looked whether the mesh is sound",
    };
    let (class, rest) = match (text.sound, short) {
        (Some(true), 0) => ("good", "; it falls short of nothing that was asked for.".to_string()),
        (_, 0) => ("bad", ".".to_string()),
        (_, 1) => ("bad", "; it falls short of what was asked for in one way.".to_string()),
        (_, n) => ("bad", format!("; it falls short of what was asked for in {n} ways.")),
    };
    out.push_str(&format!("<p class=\"verdict {class}\">{sound}{rest}</p>\n"));
    if let Some(units) = &text.units {
        out.push_str(&format!("<p>Lengths are in {}.</p>\n", escaped(units)));
    }
    if !text.lines.is_empty() {
        put_table(&mut out, &lines_table(text));
    }
    if !text.certificate.is_empty() {
        out.push_str("<section>\n<h2>Certificate</h2>\n<ul>\n");
        text.certificate.iter().for_each(|s| out.push_str(&format!("<li>{}</li>\n", escaped(s))));
        out.push_str("</ul>\n</section>\n");
    }
    let mut facts = PageTable::new("Figures", &["", "#"]);
    text.facts.iter().for_each(|f| facts.row([f.name.clone(), f.value.clone()]));
    for table in std::iter::once(&facts).chain(tables).filter(|t| !t.rows.is_empty()) {
        put_table(&mut out, table);
    }
    out.push_str("</main>\n</body>\n</html>\n");
    out
}
