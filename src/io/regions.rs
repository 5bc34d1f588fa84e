//! Which name each triangle carries in a file: faces, the user's groups, or both.

use std::collections::{BTreeMap, BTreeSet};

use crate::mesh::MeshView;
use crate::numeric::NONE;

use super::Format;
use super::layout::{Layout, SolidEntity};
use super::text::escape;

/// What names a mesh file gives to triangles.
///
/// Codes that compute want each triangle in one place: two names on one triangle lose one of them, or double the triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Grouping {
    /// Each triangle carries the name of its face; groups are left out.
    Faces,
    /// Each triangle carries the name of the user's group that holds its face, or else that of the face. Faces in several
    /// groups are a part of their own, called by all of them (`clamped+loaded`). A group that holds whole solids of more
    /// than one face names their volume, and the faces keep their names.
    #[default]
    User,
    /// Each triangle carries its face, and every group that holds it besides, in formats that can say so.
    All,
}

impl std::str::FromStr for Grouping {
    type Err = String;

    fn from_str(s: &str) -> Result<Self, String> {
        match s {
            "faces" => Ok(Self::Faces),
            "user" => Ok(Self::User),
            "all" => Ok(Self::All),
            _ => Err(format!("must be faces, user or all, not {s}")),
        }
    }
}

/// Where a set of triangles has its name from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SetKind {
    Face,
    Group,
    /// Faces that several groups hold.
    Overlap,
}

impl SetKind {
    pub(super) fn word(self) -> &'static str {
        match self {
            Self::Face => "face",
            Self::Group => "group",
            Self::Overlap => "overlap",
        }
    }
}

/// A named set of faces in a file.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct NamedSet {
    pub(super) name: String,
    pub(super) kind: SetKind,
    /// Indices of face names, ascending.
    pub(super) faces: Vec<u32>,
    /// Indices of the groups it stems from.
    pub(super) groups: Vec<u32>,
}

/// The sets of a file. NamedSet `k` has the number `k + 1`. Faces without triangles are in none.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct RegionSets {
    /// First the parts, which share no face, then sets that overlap them.
    pub(super) sets: Vec<NamedSet>,
    /// How many of the sets are parts.
    pub(super) parts: usize,
    /// For each face name its part.
    pub(super) part_of_face: Vec<u32>,
    /// For each solid the number of its volume's name, an index into `volumes`.
    pub(super) volume_of_solid: Vec<u32>,
    /// Names of volumes.
    pub(super) volumes: Vec<String>,
    /// What the user may not expect.
    pub(super) warnings: Vec<String>,
}

impl RegionSets {
    pub(super) fn new(mesh: &dyn MeshView, grouping: Grouping, layout: &Layout) -> Self {
        let names = mesh.face_names();
        let mut out = Self { part_of_face: vec![NONE; names.len()], ..Self::default() };
        let bodies = bodies(mesh, layout);
        out.name_volumes(mesh, &layout.solids, &bodies);
        let mut of_face: Vec<Vec<u32>> = vec![Vec::new(); names.len()];
        if grouping == Grouping::User {
            for (g, group) in mesh.groups().iter().enumerate() {
                if bodies.contains(&(g as u32)) {
                    let what = "it names the volume, and the faces keep their names";
                    out.warnings.push(format!("group {} holds whole solids: {what}", group.name));
                    continue;
                }
                for f in group.faces.iter().filter(|f| layout.is_used(**f)) {
                    let list = &mut of_face[*f as usize];
                    if list.last() != Some(&(g as u32)) {
                        list.push(g as u32);
                    }
                }
            }
        }
        let mut owned: BTreeMap<(bool, &[u32]), Vec<u32>> = BTreeMap::new();
        for (f, groups) in of_face.iter().enumerate().filter(|(_, groups)| !groups.is_empty()) {
            owned.entry((groups.len() > 1, groups)).or_default().push(f as u32);
        }
        for ((several, groups), faces) in owned {
            let called: Vec<&str> = groups.iter().map(|g| &mesh.groups()[*g as usize].name[..]).collect();
            let kind = if several { SetKind::Overlap } else { SetKind::Group };
            out.sets.push(NamedSet { name: called.join("+"), kind, faces, groups: groups.to_vec() });
        }
        for (f, name) in names.iter().enumerate().filter(|(f, _)| of_face[*f].is_empty() && layout.is_used(*f as u32)) {
            out.sets.push(NamedSet {
                name: name.clone(),
                kind: SetKind::Face,
                faces: vec![f as u32],
                groups: Vec::new(),
            });
        }
        for (k, set) in out.sets.iter().enumerate() {
            set.faces.iter().for_each(|f| out.part_of_face[*f as usize] = k as u32);
        }
        out.parts = out.sets.len();
        if grouping == Grouping::All {
            for (g, group) in mesh.groups().iter().enumerate() {
                let faces: BTreeSet<u32> = group.faces.iter().copied().filter(|f| layout.is_used(*f)).collect();
                if faces.is_empty() {
                    continue;
                }
                let faces = faces.into_iter().collect();
                out.sets.push(NamedSet {
                    name: group.name.clone(),
                    kind: SetKind::Group,
                    faces,
                    groups: vec![g as u32],
                });
            }
        }
        out.part_names();
        out
    }

    /// Two sets of one name would be one set to whoever reads the file.
    fn part_names(&mut self) {
        let mut taken = BTreeSet::new();
        for set in &mut self.sets {
            let fresh = unlike(&set.name, &taken);
            if fresh != set.name {
                self.warnings.push(format!(
                    "the {} {} is called {fresh}, as there is another",
                    set.kind.word(),
                    set.name
                ));
                set.name = fresh;
            }
            taken.insert(set.name.clone());
        }
    }

    fn name_volumes(&mut self, mesh: &dyn MeshView, solids: &[SolidEntity], bodies: &[u32]) {
        for (s, solid) in solids.iter().enumerate() {
            let groups = mesh.groups();
            let covers = |g: &&u32| solid.labels.iter().all(|l| groups[**g as usize].faces.contains(l));
            let name = match bodies.iter().filter(covers).min_by_key(|g| groups[**g as usize].faces.len()) {
                Some(g) => groups[*g as usize].name.clone(),
                None if solids.len() == 1 => "solid".into(),
                None => format!("solid {}", s + 1),
            };
            let known = self.volumes.iter().position(|v| *v == name);
            self.volume_of_solid.push(known.unwrap_or(self.volumes.len()) as u32);
            if known.is_none() {
                self.volumes.push(name);
            }
        }
    }
}

impl RegionSets {
    /// The sets' names as the format allows them.
    pub(super) fn clean(&self, format: Format) -> Cleaned {
        let names = self.sets.iter().map(|set| &set.name[..]);
        match format {
            Format::Inp | Format::Su2 => clean(names, super::inp::LONGEST_NAME),
            // MED shortens names itself: those of groups are not all among these.
            Format::Med => Cleaned { names: names.map(str::to_owned).collect(), changed: Vec::new() },
            // Names are comments there: any that stay on their line will do.
            _ => {
                let names = names.map(|name| escape(name).into_owned());
                Cleaned { names: names.collect(), changed: Vec::new() }
            }
        }
    }
}

/// Groups of more than one face that hold all of some solids and nothing of anything else.
fn bodies(mesh: &dyn MeshView, layout: &Layout) -> Vec<u32> {
    let solids = &layout.solids;
    let mut solids_of = vec![Vec::new(); mesh.face_names().len()];
    for (s, solid) in solids.iter().enumerate() {
        solid.labels.iter().for_each(|l| solids_of[*l as usize].push(s));
    }
    let whole = |faces: &[u32]| {
        let faces: BTreeSet<u32> = faces.iter().copied().filter(|f| layout.is_used(*f)).collect();
        faces.len() > 1
            && faces.iter().all(|f| {
                let list = &solids_of[*f as usize];
                !list.is_empty() && list.iter().all(|s| solids[*s].labels.iter().all(|l| faces.contains(l)))
            })
    };
    let groups = mesh.groups().iter().enumerate();
    groups.filter(|(_, g)| whole(&g.faces)).map(|(g, _)| g as u32).collect()
}

/// The name, with a number behind it where it is taken.
fn unlike(name: &str, taken: &BTreeSet<String>) -> String {
    let mut fresh = name.to_owned();
    let mut k = 2;
    while taken.contains(&fresh) {
        fresh = format!("{name} {k}");
        k += 1;
    }
    fresh
}

/// Names as a format allows them, and which were changed.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Cleaned {
    pub(super) names: Vec<String>,
    pub(super) changed: Vec<[String; 2]>,
}

/// Characters that are not letters, digits or `_` become `_`, at most `longest` are kept, and the first is a letter. Names
/// that differ in nothing but case become different, as many codes read capitals only.
pub(super) fn clean<'a>(names: impl IntoIterator<Item = &'a str>, longest: usize) -> Cleaned {
    let (mut out, mut taken) = (Cleaned::default(), BTreeSet::new());
    for name in names {
        let mut plain: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
        if !plain.starts_with(|c: char| c.is_ascii_alphabetic()) {
            plain.insert(0, 'F');
        }
        plain.truncate(longest);
        let (stem, mut k) = (plain.clone(), 2);
        while !taken.insert(plain.to_ascii_uppercase()) {
            let tail = format!("_{k}");
            plain = stem[..stem.len().min(longest - tail.len())].to_owned() + &tail;
            k += 1;
        }
        if plain != name {
            out.changed.push([name.to_owned(), plain.clone()]);
        }
        out.names.push(plain);
    }
    out
}
