//! The groups a part file asks for: what they hold of a mesh, and which hold nothing of it.

use super::report::Report;
use crate::error::{Error, Result, nearest};
use crate::implicit::part::{Part, glob};
use crate::mesh::{Group, TriMesh};
use crate::quality::Fault;

/// Every pattern of a group must fit some face, whether that has triangles or not: a misspelled one would load nothing.
///
/// Errors: the first pattern that fits none, at its group's place, with the name nearest to it.
pub(super) fn check_groups<'a>(part: &Part, names: impl Iterator<Item = &'a str> + Clone) -> Result<()> {
    for g in &part.groups {
        if let Some(p) = g.patterns.iter().find(|p| !names.clone().any(|n| glob(p, n))) {
            let e = Error::input(g.place.clone(), format!("group {:?}: no face is called {p:?}", g.name));
            return Err(match nearest(p, names.clone()) {
                Some(name) => e.with_help(format!("the nearest name is {name:?}; `rvachev info` lists all")),
                None => e,
            });
        }
    }
    Ok(())
}

/// Drops faces without triangles and makes the part's groups.
pub(super) fn finish_names(part: &Part, mesh: &mut TriMesh, report: &mut Report) {
    let mut used = vec![false; mesh.faces.len()];
    mesh.labels.iter().for_each(|l| used[*l as usize] = true);
    let all = std::mem::take(&mut mesh.faces);
    let mut new = vec![u32::MAX; all.len()];
    for (i, name) in all.iter().enumerate().filter(|(i, _)| used[*i]) {
        new[i] = mesh.faces.len() as u32;
        mesh.faces.push(name.clone());
    }
    mesh.labels.iter_mut().for_each(|l| *l = new[*l as usize]);
    for f in mesh.faces.iter().filter(|f| f.starts_with("domain.")) {
        report.warnings.push(format!("the solid reaches the domain's wall and is capped there: face {f}"));
    }
    for g in &part.groups {
        let faces: Vec<u32> = (0..mesh.faces.len() as u32)
            .filter(|i| g.patterns.iter().any(|p| glob(p, &mesh.faces[*i as usize])))
            .collect();
        mesh.groups.push(Group { name: g.name.clone(), faces });
    }
}

/// Groups whose faces are all without a triangle, where a computation would lose what it holds or loads. `known` are the faces the part
/// has, `used` those of the mesh.
pub(super) fn lost_groups<'a>(
    part: &Part,
    known: impl Iterator<Item = &'a str> + Clone,
    used: &[String],
) -> Vec<Fault> {
    let mut lost = Vec::new();
    for g in &part.groups {
        let fits = |name: &str| g.patterns.iter().any(|p| glob(p, name));
        if used.iter().any(|f| fits(f)) {
            continue;
        }
        let mut faces: Vec<String> = Vec::new();
        for name in known.clone().filter(|name| fits(name)) {
            if !faces.iter().any(|f| f == name) {
                faces.push(name.into());
            }
        }
        lost.push(Fault::EmptyGroup { group: g.name.clone(), faces });
    }
    lost
}
