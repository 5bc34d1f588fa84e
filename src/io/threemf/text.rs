//! Names and units as they stand in the text of a 3MF model.

use crate::error::{Error, Result};

/// A unit of 3MF, and what the build does where it is not the very unit that is meant.
pub(crate) struct Scaled {
    /// The model's unit.
    pub(crate) unit: &'static str,
    /// An attribute of the item, with a blank before it, or nothing.
    pub(crate) transform: &'static str,
}

/// How a unit of a part file is told; without one it is millimeters.
pub(crate) fn unit_of(unit: Option<&str>) -> Result<Scaled> {
    let unit = match unit.unwrap_or("mm") {
        "um" => "micron",
        "mm" => "millimeter",
        "cm" => "centimeter",
        "m" => "meter",
        "in" => "inch",
        "ft" => "foot",
        // There is no such unit.
        "dm" => return Ok(Scaled { unit: "centimeter", transform: r#" transform="10 0 0 0 10 0 0 0 10 0 0 0""# }),
        other => return Err(Error::Failed(format!("3MF does not know the unit {other:?}"))),
    };
    Ok(Scaled { unit, transform: "" })
}

/// A name as it stands in an attribute.
pub(crate) fn escaped(name: &str) -> String {
    let mut text = String::with_capacity(name.len());
    for c in name.chars() {
        match c {
            '&' => text.push_str("&amp;"),
            '<' => text.push_str("&lt;"),
            '>' => text.push_str("&gt;"),
            '"' => text.push_str("&quot;"),
            // XML holds no other control characters, and turns these into blanks.
            c if c.is_control() || c == '\u{fffe}' || c == '\u{ffff}' => text.push(' '),
            c => text.push(c),
        }
    }
    text
}
