//! Triangles and quadrilaterals between numbered nodes, in sets that may overlap: what mesh files of solvers come down to.
//!
//! Elements in the same sets are one face, called by the first of them. Every further set is a group, and so is a first one that
//! several faces share: then the faces are told apart by numbers.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;
use rustc_hash::FxHashMap;

use crate::error::{Error, Place, Result};
use crate::mesh::{Group, TriMesh};

use super::build::{UNNAMED, check_node_count};

/// A triangle or a quadrilateral.
pub(super) struct Element {
    pub(super) number: u64,
    /// What it belongs to: a key of [`Numbered::surfaces`].
    pub(super) entity: i32,
    /// Its line in the file; 0 where there are none.
    line: u32,
    /// Numbers of its nodes; those of a triangle end with the last one twice.
    corners: [u64; 4],
}

impl Element {
    pub(super) fn new(number: u64, entity: i32, line: usize, corners: &[u64]) -> Self {
        let mut four = [corners[corners.len() - 1]; 4];
        four[..corners.len()].copy_from_slice(corners);
        Self { number, entity, line: u32::try_from(line).unwrap_or(u32::MAX), corners: four }
    }

    fn error(&self, message: String) -> Error {
        if self.line > 0 {
            return Error::input(Place::Line(self.line as usize), format!("element {}: {message}", self.number));
        }
        Error::input(Place::Item(format!("element {}", self.number)), message)
    }
}

/// What a file holds before faces are made of it.
#[derive(Default)]
pub(super) struct Numbered {
    /// Names of sets by tag.
    pub(super) names: BTreeMap<i32, String>,
    /// Tags of sets by entity.
    pub(super) surfaces: BTreeMap<i32, Vec<i32>>,
    pub(super) nodes: Vec<(u64, DVec3)>,
    pub(super) elements: Vec<Element>,
    /// Whether elements were passed over, whose nodes then belong to nothing here.
    pub(super) partial: bool,
    /// Whether tetrahedra or other volumes are among those.
    pub(super) volumes: bool,
    /// What our own writer left in the comments of a gmsh file.
    pub(super) own: Option<Own>,
    entity_of_sets: FxHashMap<Vec<i32>, i32>,
    set_of_key: FxHashMap<String, i32>,
}

/// Faces and groups as our own writer knows them.
#[derive(Default)]
pub(super) struct Own {
    pub(super) faces: Vec<String>,
    pub(super) groups: Vec<Group>,
    /// Indices of faces by entity.
    pub(super) face_of_entity: BTreeMap<i32, u32>,
}

impl Numbered {
    /// The tag of the set that the file calls `key`, which comes into being, under that name, when it is first asked for.
    pub(super) fn set(&mut self, key: &str, name: impl FnOnce() -> String) -> i32 {
        if let Some(tag) = self.set_of_key.get(key) {
            return *tag;
        }
        let tag = self.set_of_key.len() as i32 + 1;
        self.set_of_key.insert(key.to_owned(), tag);
        self.names.insert(tag, name());
        tag
    }

    /// The entity of what is in these sets and no others.
    pub(super) fn entity(&mut self, sets: &[i32]) -> i32 {
        if let Some(entity) = self.entity_of_sets.get(sets) {
            return *entity;
        }
        let entity = self.entity_of_sets.len() as i32 + 1;
        self.entity_of_sets.insert(sets.to_vec(), entity);
        self.surfaces.insert(entity, sets.to_vec());
        entity
    }

    /// The entity of what is in the sets of `entity` and in one more.
    pub(super) fn within(&mut self, entity: i32, set: i32) -> i32 {
        let mut sets = self.surfaces.get(&entity).cloned().unwrap_or_default();
        if sets.contains(&set) {
            return entity;
        }
        sets.push(set);
        self.entity(&sets)
    }

    /// Adds a volume or another element that is no face.
    pub(super) fn pass_over(&mut self, volume: bool) {
        self.partial = true;
        self.volumes |= volume;
    }

    /// The mesh of a file whose entities were made by [`Self::entity`]. Sets without triangles are left out; faces stand in the
    /// order of their first elements.
    pub(super) fn finish(mut self) -> Result<TriMesh> {
        if self.elements.is_empty() && self.volumes {
            let what = "the file holds volume elements and no triangle";
            return Err(Error::input(Place::Unknown, what)
                .with_help("extract the boundary first, as by ParaView's filter Extract Surface"));
        }
        let mut fresh: FxHashMap<i32, i32> = FxHashMap::default();
        for e in &mut self.elements {
            let next = fresh.len() as i32 + 1;
            e.entity = *fresh.entry(e.entity).or_insert(next);
        }
        let surfaces = std::mem::take(&mut self.surfaces);
        self.surfaces = surfaces.into_iter().filter_map(|(e, sets)| Some((*fresh.get(&e)?, sets))).collect();
        let used: BTreeSet<i32> = self.surfaces.values().flatten().copied().collect();
        self.names.retain(|tag, _| used.contains(tag));
        self.assemble()
    }

    /// Puts nodes and triangles into the order of their numbers and makes faces and groups.
    pub(super) fn assemble(mut self) -> Result<TriMesh> {
        check_node_count(self.nodes.len(), Place::Unknown)?;
        self.nodes.sort_by_key(|n| n.0);
        if let Some(pair) = self.nodes.windows(2).find(|p| p[0].0 == p[1].0) {
            let place = Place::Item(format!("node {}", pair[0].0));
            return Err(Error::input(place, "two nodes have this number"));
        }
        let number: FxHashMap<u64, u32> = self.nodes.iter().enumerate().map(|(i, n)| (n.0, i as u32)).collect();
        self.elements.sort_by_key(|e| e.number);

        let own =
            self.own.take().filter(|own| self.elements.iter().all(|e| own.face_of_entity.contains_key(&e.entity)));
        for e in &self.elements {
            self.surfaces.entry(e.entity).or_default();
        }
        let mut mesh = TriMesh { nodes: self.nodes.iter().map(|n| n.1).collect(), ..Default::default() };
        let face_of_entity = match own {
            Some(own) => {
                (mesh.faces, mesh.groups) = (own.faces, own.groups);
                own.face_of_entity
            }
            None => self.name_faces(&mut mesh),
        };
        for e in &self.elements {
            let mut corners = [0; 4];
            for (slot, v) in corners.iter_mut().zip(&e.corners) {
                *slot =
                    *number.get(v).ok_or_else(|| e.error(format!("it uses node {v}, which the file does not have")))?;
            }
            let (first, second) = split(corners, &mesh.nodes);
            mesh.triangles.push(first);
            mesh.triangles.extend(second);
            mesh.labels.resize(mesh.triangles.len(), face_of_entity[&e.entity]);
        }
        if self.partial {
            mesh.drop_unused_nodes();
        }
        Ok(mesh)
    }

    fn name_faces(&self, mesh: &mut TriMesh) -> BTreeMap<i32, u32> {
        let mut lists: BTreeMap<&[i32], u32> = BTreeMap::new();
        let mut lists_of_first: BTreeMap<i32, usize> = BTreeMap::new();
        for tags in self.surfaces.values() {
            let fresh = lists.len() as u32;
            if !tags.is_empty() && !lists.contains_key(tags.as_slice()) {
                lists.insert(tags, fresh);
                *lists_of_first.entry(tags[0]).or_default() += 1;
            }
        }
        let name = |tag: i32| self.names.get(&tag).cloned().unwrap_or_else(|| format!("physical {tag}"));
        let mut face_of_list: BTreeMap<&[i32], u32> = BTreeMap::new();
        let mut face_of_entity = BTreeMap::new();
        let mut groups: BTreeMap<i32, Vec<u32>> = BTreeMap::new();
        for (entity, tags) in &self.surfaces {
            if let Some(face) = face_of_list.get(tags.as_slice()).filter(|_| !tags.is_empty()) {
                face_of_entity.insert(*entity, *face);
                continue;
            }
            let face = mesh.faces.len() as u32;
            mesh.faces.push(match tags.first() {
                None if self.surfaces.len() == 1 => UNNAMED.into(),
                None => format!("{UNNAMED} {}", entity.unsigned_abs()),
                Some(tag) if lists_of_first[tag] > 1 => format!("{} {entity}", name(*tag)),
                Some(tag) => name(*tag),
            });
            face_of_list.insert(tags, face);
            face_of_entity.insert(*entity, face);
            for (i, tag) in tags.iter().enumerate() {
                if i > 0 || lists_of_first[tag] > 1 {
                    groups.entry(tag.saturating_abs()).or_default().push(face);
                }
            }
        }
        // A named physical surface nobody uses is an empty group.
        for tag in self.names.keys() {
            if !lists_of_first.contains_key(tag) {
                groups.entry(*tag).or_default();
            }
        }
        mesh.groups = groups.into_iter().map(|(tag, faces)| Group { name: name(tag), faces }).collect();
        face_of_entity
    }
}

/// The triangles of a quadrilateral, on both sides of its shorter diagonal. One of which two neighboring corners are the same
/// node is a triangle.
fn split([a, b, c, d]: [u32; 4], nodes: &[DVec3]) -> ([u32; 3], Option<[u32; 3]>) {
    if c == d || d == a {
        return ([a, b, c], None);
    }
    if a == b {
        return ([b, c, d], None);
    }
    if b == c {
        return ([a, c, d], None);
    }
    let length = |p: u32, q: u32| nodes[p as usize].distance_squared(nodes[q as usize]);
    if length(b, d) < length(a, c) { ([a, b, d], Some([b, c, d])) } else { ([a, b, c], Some([a, c, d])) }
}
