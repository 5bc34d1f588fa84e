//! Arrays of numbers in VTK's XML files: text, base64 within the tree or behind it, raw bytes behind it, packed by zlib or not.

use std::io::Read;

use flate2::read::ZlibDecoder;
use roxmltree::Document;

use crate::error::{Error, Place, Result};

use super::threemf::{Xml, attribute, parsed, wrong};

/// Bytes that one array may unpack to: zlib packs a thousand to one, so a small file may claim any size.
const MOST_BYTES: u64 = 1 << 32;

/// A file taken apart: its tree, and what stands behind that.
pub(super) struct Source<'a> {
    /// Text of the tree, closed where data begin.
    pub(super) text: String,
    /// Data behind the tree, without the `_` they begin with.
    behind: &'a [u8],
    /// Whether those are base64.
    coded: bool,
}

impl<'a> Source<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Result<Self> {
        let find = |bytes: &[u8], what: &[u8]| bytes.windows(what.len()).position(|w| w == what);
        let not_text =
            |e: std::str::Utf8Error| Error::input(Place::Byte(e.valid_up_to() as u64), "this is no UTF-8 text");
        let Some(at) = find(bytes, b"<AppendedData") else {
            let text = std::str::from_utf8(bytes).map_err(not_text)?.to_owned();
            return Ok(Self { text, behind: &[], coded: false });
        };
        let (head, tail) = bytes.split_at(at);
        let end = tail.iter().position(|b| *b == b'>').unwrap_or(tail.len());
        let coded = find(&tail[..end], b"base64").is_some();
        let begin = tail[end..].iter().position(|b| *b == b'_').map(|k| end + k + 1);
        let begin = begin.ok_or_else(|| Error::input(Place::Byte(at as u64), "no data follow <AppendedData>"))?;
        let text = std::str::from_utf8(head).map_err(not_text)?;
        Ok(Self { text: format!("{text}</VTKFile>"), behind: &tail[begin..], coded })
    }
}

/// How arrays of one file are kept.
pub(super) struct Arrays<'a> {
    source: &'a Source<'a>,
    big: bool,
    /// Bytes of a number in headers.
    header: usize,
    packed: bool,
}

/// The tree of a file.
pub(super) fn tree<'a>(source: &'a Source<'_>) -> Result<Document<'a>> {
    parsed(&source.text)
}

impl<'a> Arrays<'a> {
    /// The arrays of a file of a kind, such as `PolyData`.
    pub(super) fn new(source: &'a Source<'a>, root: Xml<'_>, kind: &str) -> Result<Self> {
        if root.tag_name().name() != "VTKFile" || root.attribute("type") != Some(kind) {
            return Err(wrong(root, format!("a file of this extension begins with <VTKFile type=\"{kind}\">")));
        }
        let packed = match root.attribute("compressor") {
            None | Some("") => false,
            Some("vtkZLibDataCompressor") => true,
            Some(other) => {
                return Err(wrong(root, format!("data packed by {other} are not read"))
                    .with_help("write without compression, or packed by vtkZLibDataCompressor"));
            }
        };
        let header = match root.attribute("header_type") {
            None | Some("UInt32") => 4,
            Some("UInt64") => 8,
            Some(other) => return Err(wrong(root, format!("header_type={other:?} is neither UInt32 nor UInt64"))),
        };
        Ok(Self { source, big: root.attribute("byte_order") == Some("BigEndian"), header, packed })
    }

    /// Whole numbers, or none where the array has reals.
    pub(super) fn wholes(&self, array: Xml<'_>) -> Result<Option<Vec<i64>>> {
        let kind = attribute(array, "type")?;
        if matches!(kind, "Float32" | "Float64" | "String") {
            return Ok(None);
        }
        let too_large = || wrong(array, "a number is larger than any that is read");
        Ok(Some(match self.bytes(array)? {
            Data::Text(text) => {
                let read = |w: &str| w.parse().map_err(|_| wrong(array, format!("{w:?} is no whole number")));
                text.split_whitespace().map(read).collect::<Result<_>>()?
            }
            Data::Bytes(bytes) => match kind {
                "Int8" => self.each(array, &bytes, |b| i64::from(i8::from_le_bytes(b)))?,
                "UInt8" => self.each(array, &bytes, |b| i64::from(u8::from_le_bytes(b)))?,
                "Int16" => self.each(array, &bytes, |b| i64::from(i16::from_le_bytes(b)))?,
                "UInt16" => self.each(array, &bytes, |b| i64::from(u16::from_le_bytes(b)))?,
                "Int32" => self.each(array, &bytes, |b| i64::from(i32::from_le_bytes(b)))?,
                "UInt32" => self.each(array, &bytes, |b| i64::from(u32::from_le_bytes(b)))?,
                "Int64" => self.each(array, &bytes, i64::from_le_bytes)?,
                "UInt64" => {
                    let all = self.each(array, &bytes, |b| i64::try_from(u64::from_le_bytes(b)).ok())?;
                    all.into_iter().collect::<Option<_>>().ok_or_else(too_large)?
                }
                other => return Err(wrong(array, format!("type={other:?} is no type of numbers"))),
            },
        }))
    }

    /// Reals, also of an array of whole numbers.
    pub(super) fn reals(&self, array: Xml<'_>) -> Result<Vec<f64>> {
        let kind = attribute(array, "type")?;
        if !matches!(kind, "Float32" | "Float64") {
            let wholes = self.wholes(array)?.unwrap_or_default();
            return Ok(wholes.into_iter().map(|n| n as f64).collect());
        }
        match self.bytes(array)? {
            Data::Text(text) => {
                let read = |w: &str| w.parse().map_err(|_| wrong(array, format!("{w:?} is no number")));
                text.split_whitespace().map(read).collect()
            }
            Data::Bytes(bytes) if kind == "Float32" => self.each(array, &bytes, |b| f64::from(f32::from_le_bytes(b))),
            Data::Bytes(bytes) => self.each(array, &bytes, f64::from_le_bytes),
        }
    }

    fn each<T, const N: usize>(&self, array: Xml<'_>, bytes: &[u8], read: impl Fn([u8; N]) -> T) -> Result<Vec<T>> {
        let (numbers, rest) = bytes.as_chunks::<N>();
        if !rest.is_empty() {
            return Err(wrong(array, format!("{} bytes are no multiple of {N}", bytes.len())));
        }
        let turned = |mut b: [u8; N]| {
            if self.big {
                b.reverse();
            }
            read(b)
        };
        Ok(numbers.iter().map(|b| turned(*b)).collect())
    }

    fn bytes<'x>(&self, array: Xml<'x>) -> Result<Data<'x>> {
        let text = || array.text().unwrap_or_default();
        let coded = match array.attribute("format").unwrap_or("ascii") {
            "ascii" => return Ok(Data::Text(text())),
            "binary" => decoded(text().as_bytes()),
            "appended" => {
                let offset = attribute(array, "offset")?;
                let offset: Option<usize> = offset.trim().parse().ok();
                let data = offset.and_then(|o| self.source.behind.get(o..));
                let data = data.ok_or_else(|| wrong(array, "its offset is outside the data behind the tree"))?;
                match self.source.coded {
                    true => decoded(&data[..self.coded_end(array, data)?]),
                    false => return self.unpacked(array, data).map(Data::Bytes),
                }
            }
            other => return Err(wrong(array, format!("format={other:?} is not read"))),
        };
        let coded = coded.ok_or_else(|| wrong(array, "its data are no base64"))?;
        self.unpacked(array, &coded).map(Data::Bytes)
    }

    /// Where base64 behind the tree may end at the latest: at the offset of the array that is next.
    fn coded_end(&self, array: Xml<'_>, data: &[u8]) -> Result<usize> {
        let offset = |n: Xml<'_>| n.attribute("offset").and_then(|o| o.trim().parse::<usize>().ok());
        let own = offset(array).unwrap_or_default();
        let others = array.document().descendants().filter(|n| n.tag_name().name() == "DataArray").filter_map(offset);
        let next = others.filter(|o| *o > own).min().map_or(data.len(), |o| (o - own).min(data.len()));
        Ok(data[..next].iter().position(|b| *b == b'<').unwrap_or(next))
    }

    /// What stands behind a header that tells how much there is.
    fn unpacked(&self, array: Xml<'_>, data: &[u8]) -> Result<Vec<u8>> {
        let cut = || wrong(array, "its data are cut off");
        let word = |k: usize| -> Result<u64> {
            let bytes = data.get(k * self.header..(k + 1) * self.header).ok_or_else(cut)?;
            let fold = |n: u64, b: &u8| n << 8 | u64::from(*b);
            Ok(if self.big { bytes.iter().fold(0, fold) } else { bytes.iter().rev().fold(0, fold) })
        };
        if !self.packed {
            let length = usize::try_from(word(0)?).map_err(|_| cut())?;
            let rest = &data[self.header..];
            return rest.get(..length).map(<[u8]>::to_vec).ok_or_else(cut);
        }
        let (blocks, size) = (word(0)?, word(1)?);
        if blocks == 0 {
            return Ok(Vec::new());
        }
        // The header itself must hold a number for each block.
        let blocks = usize::try_from(blocks).ok().filter(|n| *n < data.len() / self.header).ok_or_else(cut)?;
        let mut rest = data.get((3 + blocks) * self.header..).ok_or_else(cut)?;
        let mut out = Vec::new();
        for k in 0..blocks {
            let length = usize::try_from(word(3 + k)?).ok().filter(|n| *n <= rest.len()).ok_or_else(cut)?;
            let (block, behind) = rest.split_at(length);
            let before = out.len() as u64;
            let most = size.min(MOST_BYTES.saturating_sub(before));
            let read = ZlibDecoder::new(block).take(most.saturating_add(1)).read_to_end(&mut out);
            read.map_err(|e| wrong(array, format!("its data cannot be unpacked: {e}")))?;
            if out.len() as u64 - before > most {
                return Err(wrong(array, "its data unpack to more than their header says, or than 4 GiB"));
            }
            rest = behind;
        }
        Ok(out)
    }
}

enum Data<'a> {
    Text(&'a str),
    Bytes(Vec<u8>),
}

/// Bytes of base64, whose pieces may each end in `=`: writers code headers and data by themselves or together.
fn decoded(text: &[u8]) -> Option<Vec<u8>> {
    let mut out = Vec::with_capacity(text.len() / 4 * 3);
    let (mut bits, mut digits, mut pads) = (0u32, 0, 0);
    for b in text.iter().filter(|b| !b.is_ascii_whitespace()) {
        let digit = match b {
            b'A'..=b'Z' => b - b'A',
            b'a'..=b'z' => b - b'a' + 26,
            b'0'..=b'9' => b - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            b'=' if digits >= 2 => {
                pads += 1;
                0
            }
            _ => return None,
        };
        if pads > 0 && *b != b'=' {
            return None;
        }
        bits = bits << 6 | u32::from(digit);
        digits += 1;
        if digits == 4 {
            out.extend(&bits.to_be_bytes()[1..4 - pads]);
            (bits, digits, pads) = (0, 0, 0);
        }
    }
    (digits == 0).then_some(out)
}
