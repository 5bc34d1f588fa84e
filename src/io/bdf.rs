//! Nastran bulk data: GRID in large fields, CTRIA3 with a property for each part, SET1 with the nodes of each set.

use std::io::Write;

use crate::error::{Error, Result};
use crate::run::Run;

use super::atomic::write_failed;
use super::build::each_node;
use super::sets::NamedSets;

/// A small field has eight characters.
const LARGEST: usize = 99_999_999;
/// Characters of a large field.
pub(super) const WIDE: usize = 16;

pub(super) fn write(out: &mut dyn Write, sets: &NamedSets, run: &Run) -> Result<()> {
    let (nodes, triangles) = (sets.mesh.node_count(), sets.triangle_count());
    if nodes > LARGEST || triangles > LARGEST {
        return Err(Error::Failed(format!("Nastran numbers nodes and elements up to {LARGEST}, this mesh has more")));
    }
    let mut put = |text: std::fmt::Arguments| out.write_fmt(text).map_err(write_failed);
    put(format_args!("$ rvachev: triangles of a surface\n"))?;
    for (k, (name, _)) in sets.named().enumerate() {
        let what = if k < sets.regions.parts { "PSHELL and SET1" } else { "SET1" };
        put(format_args!("$ {what} {}: {name}\n", k + 1))?;
        if k < sets.regions.parts {
            put(format_args!("$HMNAME COMP {:>19}\"{name}\"\n", k + 1))?;
        }
    }
    put(format_args!("BEGIN BULK\n"))?;
    let mut number = 0;
    each_node(sets.mesh, 0..nodes, run, |p| {
        number += 1;
        let [x, y, z] = p.to_array().map(field);
        put(format_args!("GRID*   {number:>16}{:16}{x:>16}{y:>16}*\n*       {z:>16}\n", ""))
    })?;
    for (k, (_, set)) in sets.named().enumerate() {
        if k < sets.regions.parts {
            // A thickness of one and no material: places to fill in.
            put(format_args!("PSHELL  {:>8}{:>8}{:>8}\n", k + 1, "", "1."))?;
            sets.each_triangle(set, run, |number, corners| {
                let [a, b, c] = corners.map(|v| v + 1);
                put(format_args!("CTRIA3  {:>8}{:>8}{a:>8}{b:>8}{c:>8}\n", number + 1, k + 1))
            })?;
        }
    }
    for (k, (_, set)) in sets.named().enumerate() {
        let (_, nodes) = sets.members(set, run)?;
        // Seven numbers behind the set's own, then eight to a line.
        put(format_args!("SET1    {:>8}", k + 1))?;
        for (i, v) in nodes.iter().enumerate() {
            if i >= 7 && (i - 7).is_multiple_of(8) {
                put(format_args!("\n        "))?;
            }
            put(format_args!("{:>8}", v + 1))?;
        }
        put(format_args!("\n"))?;
    }
    put(format_args!("ENDDATA\n"))
}

/// A number in at most sixteen characters, as near as they allow: an exponent needs no letter there, and a fraction no
/// zero before its point.
fn field(x: f64) -> String {
    if x == 0.0 {
        return "0.".into();
    }
    let mut best = (f64::INFINITY, String::new());
    let mut offer = |text: String, value: f64| {
        let off = (value - x).abs();
        if text.len() <= WIDE && (off < best.0 || off == best.0 && text.len() < best.1.len()) {
            best = (off, text);
        }
    };
    for digits in (1..WIDE).rev() {
        let plain = format!("{x:.digits$}");
        if plain.len() <= WIDE + 1 {
            let value = plain.parse().unwrap_or(f64::INFINITY);
            let (sign, rest) = plain.strip_prefix('-').map_or(("", &plain[..]), |r| ("-", r));
            let rest = rest.strip_prefix('0').filter(|r| r.starts_with('.')).unwrap_or(rest);
            offer(format!("{sign}{}", rest.trim_end_matches('0')), value);
            break;
        }
    }
    for digits in (1..WIDE).rev() {
        let long = format!("{x:.digits$e}");
        let Some((mantissa, exponent)) = long.split_once('e') else { continue };
        let sign = if exponent.starts_with('-') { "" } else { "+" };
        let text = format!("{mantissa}{sign}{exponent}");
        if text.len() > WIDE {
            continue;
        }
        let value: f64 = long.parse().unwrap_or(f64::INFINITY);
        if value.is_finite() {
            offer(text, value);
        } else {
            // The largest numbers must not be rounded up to infinity.
            let all = format!("{x:e}");
            let cut = all.get(..mantissa.len()).unwrap_or(mantissa);
            offer(format!("{cut}{sign}{exponent}"), format!("{cut}e{exponent}").parse().unwrap_or(f64::MAX));
        }
        break;
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::field;
    use approx::{assert_abs_diff_eq, relative_eq};

    /// What Nastran makes of a field.
    fn value(text: &str) -> f64 {
        let cut = text.char_indices().skip(1).find(|(_, c)| matches!(c, '+' | '-')).map(|(i, _)| i);
        let (mantissa, exponent) = text.split_at(cut.unwrap_or(text.len()));
        let power: i32 = if exponent.is_empty() { 0 } else { exponent.parse().unwrap() };
        format!("{mantissa}e{power}").parse().unwrap()
    }

    #[test]
    fn numbers_keep_what_sixteen_characters_hold() {
        for (x, text) in [(0.5, ".5"), (-1.0, "-1."), (1e20, "1.0000000000000+20"), (0.0, "0.")] {
            let text = if text.len() > 16 { &field(x) } else { text };
            assert_eq!(field(x), text);
        }
        for x in [1.0 / 3.0, -1.0 / 3.0, 123456.789012345, -1e-7 / 3.0, 1e9 / 7.0, f64::MAX, -5e-300, 98765432109876.5]
        {
            let text = field(x);
            assert!(text.len() <= 16 && text.contains('.'), "{text}");
            // A sign, a point and a three-digit exponent leave ten digits.
            assert!(relative_eq!(value(&text), x, epsilon = 0.0, max_relative = 1e-9), "{x}: {text}");
        }
        assert_abs_diff_eq!(value(&field(1.0 / 3.0)), 1.0 / 3.0, epsilon = 1e-14);
    }
}
