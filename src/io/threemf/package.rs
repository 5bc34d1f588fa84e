//! The package around a 3MF model: a zip file whose relationships name the model's part.

use std::io::{Cursor, Read, Write};

use roxmltree::{Document, ParsingOptions};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipArchive, ZipWriter};

use crate::error::{Error, Place, Result};

/// Bytes of the unpacked model: a small package may claim any size.
const MOST_MODEL: u64 = 1 << 30;

/// Bytes of the unpacked relationships.
const MOST_RELATIONS: u64 = 1 << 20;

/// Elements, attributes and texts of a model.
const MOST_NODES: u32 = 100_000_000;

/// Where relationships of the whole package stand.
const RELATIONS: &str = "_rels/.rels";

/// Where our own packages keep the model.
const MODEL: &str = "3D/3dmodel.model";

/// What a relationship with the model is called.
const MODEL_TYPE: &str = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel";

type Archive<'a> = ZipArchive<Cursor<&'a [u8]>>;

/// The text of the model in a package.
pub(crate) fn model_text(bytes: &[u8]) -> Result<String> {
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|e| {
        Error::input(Place::Byte(0), format!("this is no zip file, which a 3MF package is: {e}"))
            .with_help("a 3MF file is written anew by the program it is from")
    })?;
    let relations = part(&mut archive, RELATIONS, MOST_RELATIONS)?;
    let xml = parsed(&relations).map_err(|e| within(RELATIONS, e))?;
    let is_model = |n: &roxmltree::Node| n.attribute("Type").is_some_and(|t| t.ends_with("/3dmodel"));
    let found = xml.descendants().find(|n| n.tag_name().name() == "Relationship" && is_model(n));
    let Some(target) = found.and_then(|n| n.attribute("Target")) else {
        return Err(Error::input(Place::Item(RELATIONS.into()), "no relationship names a 3D model"));
    };
    part(&mut archive, target.trim_start_matches('/'), MOST_MODEL)
}

/// The text of one part. Names of parts do not tell small letters from capitals.
fn part(archive: &mut Archive<'_>, name: &str, most: u64) -> Result<String> {
    let at = || Place::Item(name.into());
    let same = |n: &Result<std::borrow::Cow<'_, str>, _>| n.as_ref().is_ok_and(|n| n.eq_ignore_ascii_case(name));
    let Some(found) = archive.file_names().position(|n| same(&n)) else {
        return Err(Error::input(at(), "the package has no such part"));
    };
    let file = archive.by_index(found).map_err(|e| Error::input(at(), format!("it cannot be unpacked: {e}")))?;
    let mut bytes = Vec::new();
    file.take(most + 1)
        .read_to_end(&mut bytes)
        .map_err(|e| Error::input(at(), format!("it cannot be unpacked: {e}")))?;
    if bytes.len() as u64 > most {
        return Err(Error::input(at(), format!("it unpacks to more than {most} bytes, which is the limit")));
    }
    String::from_utf8(bytes).map_err(|_| Error::input(at(), "it must be UTF-8 text"))
}

/// Names the part in an error that only knows the line.
fn within(part: &str, error: Error) -> Error {
    match error {
        Error::Input { file, place, message, help } => {
            Error::Input { file, place: Place::Item(part.into()), message: format!("{place}{message}"), help }
        }
        other => other,
    }
}

/// The text as a tree of elements; document types are refused, as their entities may grow without end.
pub(crate) fn parsed(text: &str) -> Result<Document<'_>> {
    let options = ParsingOptions { allow_dtd: false, nodes_limit: MOST_NODES, ..ParsingOptions::default() };
    Document::parse_with_options(text, options).map_err(|e| {
        let at = e.pos();
        let place = Place::Text { line: at.row as usize, column: at.col as usize, offset: 0, len: 0 };
        Error::input(place, format!("this is no XML: {e}"))
    })
}

/// The package of a model; its bytes depend on the text alone.
pub(crate) fn packed(model: &str) -> Result<Vec<u8>> {
    let types = r#"<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">
<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>
<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>
</Types>
"#;
    let relations = format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
<Relationship Target="/{MODEL}" Id="rel0" Type="{MODEL_TYPE}"/>
</Relationships>
"#
    );
    let failed = |e: &dyn std::fmt::Display| Error::Failed(format!("the package cannot be made: {e}"));
    // The time would differ from run to run.
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::default());
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, text) in [("[Content_Types].xml", types), (RELATIONS, &relations), (MODEL, model)] {
        zip.start_file(name, options).map_err(|e| failed(&e))?;
        zip.write_all(text.as_bytes()).map_err(|e| failed(&e))?;
    }
    Ok(zip.finish().map_err(|e| failed(&e))?.into_inner())
}
