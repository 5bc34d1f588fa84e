//! Abaqus and CalculiX input in: shells, membranes and plane elements of three and four nodes, with *ELSET as faces and groups.
//!
//! Keywords and names do not tell small letters from capitals. Sets of nodes, surfaces, materials and steps are passed over.

use rustc_hash::FxHashMap;

use crate::error::{Error, Result};
use crate::mesh::TriMesh;
use crate::run::Run;

use super::CHECK_EVERY;
use super::numbered::{Element, Numbered};
use super::text::{Lines, at, point, quote};

/// Elements of a set: numbers from the first to the second by steps of the third.
type Span = [u64; 3];

/// A set of elements as the file lists it.
struct Listed {
    tag: i32,
    spans: Vec<Span>,
}

/// A line that begins with a keyword.
struct Keyword {
    line: usize,
    /// In capitals, with single blanks.
    name: String,
    /// Names in capitals with their values.
    parameters: Vec<[String; 2]>,
}

impl Keyword {
    fn new(line: usize, text: &str) -> Self {
        let mut parts = text[1..].split(',').map(str::trim);
        let name = parts.next().unwrap_or_default().to_ascii_uppercase();
        let name = name.split_whitespace().collect::<Vec<_>>().join(" ");
        let pair = |part: &str| {
            let (key, value) = part.split_once('=').unwrap_or((part, ""));
            [key.trim().to_ascii_uppercase(), value.trim().trim_matches('"').to_owned()]
        };
        Self { line, name, parameters: parts.filter(|p| !p.is_empty()).map(pair).collect() }
    }

    fn value(&self, key: &str) -> Option<&str> {
        self.parameters.iter().find(|p| p[0] == key).map(|p| &p[1][..])
    }
}

/// What data lines behind a keyword are.
enum DataBlock {
    Nodes,
    /// Faces of so many corners.
    Faces {
        corners: usize,
        entity: i32,
    },
    /// Elements of a set, as a list or as ranges.
    Set {
        listed: usize,
        ranges: bool,
    },
    Nothing,
}

/// What an element type is.
enum Kind {
    Face(usize),
    Quadratic,
    Volume,
    Other,
}

fn kind(name: &str) -> Kind {
    /// Families of elements that are faces: shells, plane ones, membranes and rigid ones.
    const FACES: [&str; 9] = ["S", "STRI", "CPS", "CPE", "M3D", "SFM3D", "R3D", "DS", "CPEG"];
    let stem = name.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let stem = if matches!(name, "S4R5" | "S8R5" | "S9R5") { &name[..2] } else { stem };
    let digits = stem.bytes().rev().take_while(u8::is_ascii_digit).count();
    let (family, nodes) = stem.split_at(stem.len() - digits);
    // The first digit of STRI65 counts nodes, that of 3D belongs to the family.
    match (FACES.contains(&family), nodes) {
        (true, "3") => Kind::Face(3),
        (true, "4") => Kind::Face(4),
        (true, "6" | "8" | "9" | "65") => Kind::Quadratic,
        _ if ["C3D", "DC3D", "AC3D"].contains(&family) => Kind::Volume,
        _ => Kind::Other,
    }
}

struct LineReader<'a> {
    lines: Lines<'a>,
    raw: Numbered,
    sets: Vec<Listed>,
    /// Indices of sets by their names in capitals.
    set_of_name: FxHashMap<String, usize>,
    instances: usize,
}

pub(super) fn read(bytes: &[u8], run: &Run) -> Result<TriMesh> {
    let mut r = LineReader {
        lines: Lines::new(bytes),
        raw: Numbered::default(),
        sets: Vec::new(),
        set_of_name: FxHashMap::default(),
        instances: 0,
    };
    let mut block = DataBlock::Nothing;
    let (mut known, mut looked) = (false, 0);
    while let Some((number, line)) = r.lines.next_filled() {
        looked += 1;
        if looked % CHECK_EVERY == 0 {
            run.check()?;
        }
        let text = line.trim();
        if text.starts_with("**") {
            continue;
        }
        if text.starts_with('*') {
            known = true;
            let keyword = r.keyword(number, text);
            block = r.block(&keyword)?;
            continue;
        }
        if !known {
            return Err(at(
                number,
                format!("an input file begins with a keyword such as `*NODE`, not {}", quote(text)),
            ));
        }
        r.data(&block, number, text)?;
    }
    r.finish(run)
}

impl LineReader<'_> {
    /// The keyword of a line, which goes on behind a comma at its end.
    fn keyword(&mut self, number: usize, text: &str) -> Keyword {
        let mut whole = text.to_owned();
        while whole.ends_with(',') {
            let Some((_, more)) = self.lines.next_line() else { break };
            if !more.starts_with("**") {
                whole += more.trim();
            }
        }
        Keyword::new(number, &whole)
    }

    fn block(&mut self, k: &Keyword) -> Result<DataBlock> {
        let bad = |what: String| Err(at(k.line, what));
        match &k.name[..] {
            "INCLUDE" => bad("*INCLUDE is not read: put the lines of that file in its place".into()),
            "NODE" | "ELEMENT" | "ELSET" if k.value("INPUT").is_some() => {
                bad(format!("*{} with INPUT is not read: put the lines of that file behind it", k.name))
            }
            "INSTANCE" => {
                self.instances += 1;
                match self.instances {
                    1 => Ok(DataBlock::Nothing),
                    _ => bad("assemblies of more than one *INSTANCE are not read".into()),
                }
            }
            "NODE" => match k.value("SYSTEM") {
                None | Some("R" | "r") => Ok(DataBlock::Nodes),
                Some(other) => bad(format!("nodes in the coordinate system {} are not read", quote(other))),
            },
            "ELEMENT" => self.elements(k),
            "ELSET" => {
                let Some(name) = k.value("ELSET").filter(|n| !n.is_empty()) else {
                    return bad("*ELSET has no name: ELSET=name should follow".into());
                };
                Ok(DataBlock::Set { listed: self.set(name), ranges: k.value("GENERATE").is_some() })
            }
            _ => Ok(DataBlock::Nothing),
        }
    }

    fn elements(&mut self, k: &Keyword) -> Result<DataBlock> {
        let Some(name) = k.value("TYPE") else {
            return Err(at(k.line, "*ELEMENT has no type: TYPE=S3 or the like should follow"));
        };
        match kind(&name.to_ascii_uppercase()) {
            Kind::Face(corners) => {
                let tags = match k.value("ELSET").filter(|n| !n.is_empty()) {
                    Some(set) => {
                        let listed = self.set(set);
                        vec![self.sets[listed].tag]
                    }
                    None => Vec::new(),
                };
                return Ok(DataBlock::Faces { corners, entity: self.raw.entity(&tags) });
            }
            Kind::Quadratic => {
                return Err(at(k.line, format!("elements of type {} are not read", quote(name)))
                    .with_help("elements of three and four nodes are, such as S3 and S4"));
            }
            Kind::Volume => self.raw.pass_over(true),
            Kind::Other => self.raw.pass_over(false),
        }
        Ok(DataBlock::Nothing)
    }

    /// The number of the set of that name.
    fn set(&mut self, name: &str) -> usize {
        let key = name.to_ascii_uppercase();
        let tag = self.raw.set(&key, || name.to_owned());
        *self.set_of_name.entry(key).or_insert_with(|| {
            self.sets.push(Listed { tag, spans: Vec::new() });
            self.sets.len() - 1
        })
    }

    fn data(&mut self, block: &DataBlock, number: usize, text: &str) -> Result<()> {
        match block {
            DataBlock::Nothing => Ok(()),
            DataBlock::Nodes => {
                let mut words = text.split(',').map(str::trim);
                let tag = whole(words.next().unwrap_or_default(), number, "the number of a node")?;
                let coordinates: Vec<String> = words.by_ref().take(3).map(|w| w.replace(['d', 'D'], "e")).collect();
                // What is left out is zero.
                let given = |k: usize| coordinates.get(k).map_or("0", |w| if w.is_empty() { "0" } else { w });
                let p = point(&mut (0..3).map(given), number)?;
                self.raw.nodes.push((tag, p));
                Ok(())
            }
            DataBlock::Faces { corners, entity } => self.face(*corners, *entity, number, text),
            DataBlock::Set { listed, ranges } => self.members(*listed, *ranges, number, text),
        }
    }

    /// An element, whose line goes on behind a comma at its end.
    fn face(&mut self, corners: usize, entity: i32, number: usize, text: &str) -> Result<()> {
        let mut numbers = Vec::with_capacity(corners + 1);
        let mut line = text.to_owned();
        loop {
            for word in line.split(',').map(str::trim).filter(|w| !w.is_empty()) {
                numbers.push(whole(word, self.lines.number(), "the number of an element or node")?);
            }
            if numbers.len() > corners || !line.trim_end().ends_with(',') {
                break;
            }
            match self.lines.next_filled() {
                Some((_, more)) => line = more.into_owned(),
                None => break,
            }
        }
        if numbers.len() != corners + 1 {
            let what =
                format!("an element with {corners} nodes has {} numbers here, its own among them", numbers.len());
            return Err(at(number, what));
        }
        self.raw.elements.push(Element::new(numbers[0], entity, number, &numbers[1..]));
        Ok(())
    }

    fn members(&mut self, listed: usize, ranges: bool, number: usize, text: &str) -> Result<()> {
        let words: Vec<&str> = text.split(',').map(str::trim).filter(|w| !w.is_empty()).collect();
        if ranges {
            let of = |k: usize| words.get(k).map(|w| whole(w, number, "the number of an element")).transpose();
            let (first, last, step) = (of(0)?, of(1)?, of(2)?.unwrap_or(1));
            let (Some(first), Some(last)) = (first, last) else {
                return Err(at(number, "a range has a first and a last number"));
            };
            if step == 0 {
                return Err(at(number, "the step of a range is zero"));
            }
            self.sets[listed].spans.push([first, last, step]);
            return Ok(());
        }
        for word in words {
            if let Ok(one) = word.parse::<u64>() {
                self.sets[listed].spans.push([one, one, 1]);
                continue;
            }
            // Sets may consist of others. Names with a point are of an instance.
            let known = word.trim_matches('"').to_ascii_uppercase();
            let Some(other) = self.set_of_name.get(&known).copied().filter(|other| *other != listed) else {
                return Err(at(number, format!("{} is no number of an element and no set above", quote(word))));
            };
            // Only what it has by now: a few sets that name each other would otherwise grow without end.
            let tag = self.sets[other].tag;
            let alike = self.raw.elements.iter().filter(|e| self.raw.surfaces[&e.entity].contains(&tag));
            let mut spans: Vec<Span> = alike.map(|e| [e.number, e.number, 1]).collect();
            spans.extend(&self.sets[other].spans);
            spans.sort_unstable();
            spans.dedup();
            let own = &mut self.sets[listed].spans;
            own.extend(spans);
            own.sort_unstable();
            own.dedup();
        }
        Ok(())
    }

    /// Puts elements into the sets that list them.
    fn finish(mut self, run: &Run) -> Result<TriMesh> {
        let raw = &mut self.raw;
        // By number, with the places in the file, in whose order faces stand.
        let mut order: Vec<u32> = (0..raw.elements.len() as u32).collect();
        order.sort_by_key(|k| raw.elements[*k as usize].number);
        let number = |raw: &Numbered, k: usize| raw.elements[order[k] as usize].number;
        if let Some(k) = (1..order.len()).find(|k| number(raw, k - 1) == number(raw, *k)) {
            let item = format!("element {}", number(raw, k));
            return Err(Error::input(crate::error::Place::Item(item), "two elements have this number"));
        }
        for set in &self.sets {
            run.check()?;
            let mut within: FxHashMap<i32, i32> = FxHashMap::default();
            for [first, last, step] in &set.spans {
                let begin = order.partition_point(|k| raw.elements[*k as usize].number < *first);
                for k in &order[begin..] {
                    let (one, entity) = (raw.elements[*k as usize].number, raw.elements[*k as usize].entity);
                    if one > *last {
                        break;
                    }
                    if (one - first) % step == 0 {
                        let joined = *within.entry(entity).or_insert_with(|| raw.within(entity, set.tag));
                        raw.elements[*k as usize].entity = joined;
                    }
                }
            }
        }
        self.raw.finish()
    }
}

fn whole(word: &str, line: usize, what: &str) -> Result<u64> {
    word.parse().map_err(|_| at(line, format!("{what} is {}, not a whole number ≥ 0", quote(word))))
}
