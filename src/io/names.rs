//! The list of names that goes beside a mesh file: which part of the file is which face and group.

use serde::Serialize;

use super::layout::Layout;
use super::regions::{Grouping, RegionSets};
use crate::mesh::MeshView;
use crate::numeric::NONE;

/// A set of triangles with one name.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NamedPart {
    /// Its name, as far as the format allows; [`Names::renamed`] tells what a format made of it.
    pub name: String,
    /// Its number: physical tag, property or reference.
    pub number: usize,
    /// `face`, `group` or `overlap`.
    pub from: String,
    /// The faces in it.
    pub faces: Vec<String>,
    /// The groups that hold it.
    pub groups: Vec<String>,
    /// How many triangles it has.
    pub triangles: usize,
    /// Their area.
    pub area: f64,
}

/// A face or a group of the mesh, and the parts it is written as.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NamedWhole {
    /// Its name in the part or model.
    pub name: String,
    /// Names of parts that make it up; a part of a face may be larger than the face.
    pub parts: Vec<String>,
    /// The faces in it.
    pub faces: Vec<String>,
    /// How many triangles it has.
    pub triangles: usize,
    /// Their area.
    pub area: f64,
}

/// A volume to be filled.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NamedVolume {
    /// Its name.
    pub name: String,
    /// Its physical tag in a gmsh script.
    pub number: usize,
    /// Names of the faces around it.
    pub faces: Vec<String>,
    /// How many closed shells bound it: those of voids count.
    pub shells: usize,
    /// Its volume.
    pub volume: f64,
}

/// All names of a mesh file.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Names {
    /// What triangles are named by: `faces`, `user` or `all`.
    pub grouping: String,
    /// Sets in the file. Each triangle is in one, except with `all`.
    pub parts: Vec<NamedPart>,
    /// The mesh's faces.
    pub faces: Vec<NamedWhole>,
    /// The mesh's groups.
    pub groups: Vec<NamedWhole>,
    /// Solids.
    pub solids: Vec<NamedVolume>,
    /// Per file the names it could not hold, with what stands there instead.
    pub renamed: Vec<Renamed>,
}

/// A name that a format could not hold.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Renamed {
    /// The file.
    pub file: String,
    /// The name in [`Names`].
    pub name: String,
    /// The name in the file.
    pub written: String,
}

impl Names {
    pub(super) fn new(mesh: &dyn MeshView, grouping: Grouping, layout: &Layout, regions: &RegionSets) -> Self {
        let face = |f: &u32| mesh.face_names()[*f as usize].clone();
        let size = |faces: &[u32]| {
            let sizes = faces.iter().map(|f| layout.sizes[*f as usize]);
            sizes.fold((0, 0.0), |sum, s| (sum.0 + s.0, sum.1 + s.1))
        };
        let grouping = match grouping {
            Grouping::Faces => "faces",
            Grouping::User => "user",
            Grouping::All => "all",
        };
        let parts = regions.sets.iter().enumerate().map(|(k, set)| {
            let (triangles, area) = size(&set.faces);
            let groups = set.groups.iter().map(|g| mesh.groups()[*g as usize].name.clone()).collect();
            let (name, from, faces) = (set.name.clone(), set.kind.word().into(), set.faces.iter().map(face).collect());
            NamedPart { name, number: k + 1, from, faces, groups, triangles, area }
        });
        let whole = |name: &str, faces: &[u32]| {
            let mut faces = faces.to_vec();
            faces.sort_unstable();
            faces.dedup();
            let mut parts: Vec<u32> = faces.iter().map(|f| regions.part_of_face[*f as usize]).collect();
            parts.retain(|p| *p != NONE);
            parts.sort_unstable();
            parts.dedup();
            let parts = parts.into_iter().map(|p| regions.sets[p as usize].name.clone()).collect();
            let (triangles, area) = size(&faces);
            NamedWhole { name: name.into(), parts, faces: faces.iter().map(face).collect(), triangles, area }
        };
        let solids = layout.solids.iter().zip(&regions.volume_of_solid).map(|(solid, v)| NamedVolume {
            name: regions.volumes[*v as usize].clone(),
            number: *v as usize + 1,
            faces: solid.labels.iter().map(face).collect(),
            shells: solid.shells.len(),
            volume: solid.volume,
        });
        Self {
            grouping: grouping.into(),
            parts: parts.collect(),
            faces: (0u32..).zip(mesh.face_names()).map(|(f, name)| whole(name, &[f])).collect(),
            groups: mesh.groups().iter().map(|g| whole(&g.name, &g.faces)).collect(),
            solids: solids.collect(),
            renamed: Vec::new(),
        }
    }
}
