//! MED, which Salome and code_aster read: triangles in an HDF5 file, with a family for each part and the names of its groups.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;

use hdf5_pure::{AttrValue, FileBuilder, LibVer, make_i8_type};

use crate::error::{Error, Result};
use crate::mesh::MeshView;
use crate::run::Run;

use super::atomic::write_failed;
use super::build::each_node;
use super::regions::{NamedSet, SetKind};
use super::sets::NamedSets;

/// Bytes of a group's name: MED_LNAME_SIZE of the format.
const LONGEST_NAME: usize = 80;
/// Bytes of a name that has no end of its own: MED_NAME_SIZE and the zero behind it.
const NAME: u32 = 65;
/// Of a description: MED_COMMENT_SIZE and the zero behind it.
const COMMENT: u32 = 201;
/// Characters of the name of a coordinate: MED_SNAME_SIZE.
const SHORT_NAME: usize = 16;
/// The mesh in the file.
const MESH: &str = "part";
/// The only step of a mesh that does not change: neither a time nor an iteration has a number.
const STEP: &str = "-0000000000000000001-0000000000000000001";
/// That all nodes or elements are meant.
const ALL: &str = "MED_NO_PROFILE_INTERNAL";

/// Writes the triangles of the parts one after the other; names that were cut come back beside what stands in the file.
pub(super) fn write(out: &mut dyn Write, sets: &NamedSets, run: &Run) -> Result<Vec<[String; 2]>> {
    let (nodes, triangles) = (sets.mesh.node_count(), sets.triangle_count());
    let (Ok(node_count), Ok(triangle_count)) = (i32::try_from(nodes), i32::try_from(triangles)) else {
        return Err(Error::Failed(format!("MED numbers nodes and elements up to {}, this mesh has more", i32::MAX)));
    };
    // All numbers of one column, then those of the next.
    let mut places = vec![0.0; 3 * nodes];
    let mut number = 0;
    each_node(sets.mesh, 0..nodes, run, |p| {
        p.to_array().into_iter().enumerate().for_each(|(axis, x)| places[axis * nodes + number] = x);
        number += 1;
        Ok(())
    })?;
    let (mut corners, mut families) = (vec![0; 3 * triangles], Vec::with_capacity(triangles));
    let mut named: Vec<Vec<String>> = Vec::new();
    for (_, part) in sets.parts() {
        // Of elements families have negative numbers, of nodes positive ones.
        let family = -(named.len() as i32) - 1;
        named.push(groups_of(sets, part));
        sets.each_triangle(part, run, |_, triangle| {
            let row = families.len();
            triangle.into_iter().enumerate().for_each(|(k, v)| corners[k * triangles + row] = v as i32 + 1);
            families.push(family);
            Ok(())
        })?;
    }
    run.check()?;
    let (called, renamed) = shortened(&named);
    let content = Content { places, corners, families, counts: [node_count, triangle_count], named, called };
    let bytes = content.file().map_err(|e| Error::Failed(format!("the MED file cannot be made: {e}")))?;
    out.write_all(&bytes).map_err(write_failed)?;
    Ok(renamed)
}

/// Names of the groups that hold a part: MED lets them overlap.
fn groups_of(sets: &NamedSets, part: &NamedSet) -> Vec<String> {
    let mesh: &dyn MeshView = sets.mesh;
    let mut names = match part.kind {
        SetKind::Overlap => part.groups.iter().map(|g| mesh.groups()[*g as usize].name.clone()).collect(),
        SetKind::Face | SetKind::Group => vec![part.name.clone()],
    };
    let further = &sets.regions.sets[sets.regions.parts..];
    names.extend(further.iter().filter(|set| set.faces.contains(&part.faces[0])).map(|set| set.name.clone()));
    names
}

/// Names as they stand in the file, and those among them that are not what they were.
fn shortened(named: &[Vec<String>]) -> (BTreeMap<String, String>, Vec<[String; 2]>) {
    let (mut called, mut taken) = (BTreeMap::new(), BTreeSet::new());
    let mut renamed = Vec::new();
    for name in named.iter().flatten() {
        if called.contains_key(name) {
            continue;
        }
        // A zero ends a name, and blanks at its end are filling.
        let plain: String = name.chars().map(|c| if c.is_control() { '_' } else { c }).collect();
        let cut = |longest: usize, tail: &str| {
            let end = (0..=plain.len().min(longest - tail.len())).rev().find(|k| plain.is_char_boundary(*k));
            plain[..end.unwrap_or(0)].trim().to_owned() + tail
        };
        let (mut short, mut k) = (cut(LONGEST_NAME, ""), 2);
        while short.is_empty() || !taken.insert(short.clone()) {
            short = cut(LONGEST_NAME, &format!("_{k}"));
            k += 1;
        }
        if short != *name {
            renamed.push([name.clone(), short.clone()]);
        }
        called.insert(name.clone(), short);
    }
    (called, renamed)
}

/// What stands in the file.
struct Content {
    places: Vec<f64>,
    corners: Vec<i32>,
    families: Vec<i32>,
    /// Of nodes, of triangles.
    counts: [i32; 2],
    /// For each family the groups it is in.
    named: Vec<Vec<String>>,
    called: BTreeMap<String, String>,
}

impl Content {
    fn file(self) -> std::result::Result<Vec<u8>, hdf5_pure::Error> {
        let [nodes, triangles] = self.counts.map(AttrValue::I32);
        let whole = AttrValue::I32;
        let text = |value: &str, width: u32| AttrValue::ascii_string_sized(value, width);
        let mut file = FileBuilder::new();
        // The library of MED 4 is built on HDF5 1.10, which reads files of 1.8.
        file.with_libver_bounds(LibVer::V18, LibVer::V18);
        let mut version = file.create_group("INFOS_GENERALES");
        // Versions of Salome before 9 refuse later ones; the library of MED 4.1 reads this one.
        for (key, value) in [("MAJ", 3), ("MIN", 0), ("REL", 0)] {
            version.set_attr(key, whole(value));
        }
        file.add_group(version.finish());

        let mut meshes = file.create_group("ENS_MAA");
        let mut mesh = meshes.create_group(MESH);
        // Dimensions of mesh and space, Cartesian coordinates, sorted by step, unstructured.
        for (key, value) in [("DIM", 2), ("ESP", 3), ("REP", 0), ("SRT", 1), ("TYP", 0)] {
            mesh.set_attr(key, whole(value));
        }
        let axes: String = ["X", "Y", "Z"].iter().map(|axis| format!("{axis:<SHORT_NAME$}")).collect();
        let three = 3 * SHORT_NAME as u32 + 1;
        mesh.set_attr("NOM", text(&axes, three)?);
        mesh.set_attr("UNI", text("", three)?);
        mesh.set_attr("UNT", text("", SHORT_NAME as u32 + 1)?);
        mesh.set_attr("DES", text("rvachev", COMMENT)?);
        let mut step = mesh.create_group(STEP);
        for (key, value) in [("CGT", 1), ("NDT", -1), ("NOR", -1)] {
            step.set_attr(key, whole(value));
        }
        step.set_attr("PDT", AttrValue::F64(-1.0));

        let mut points = step.create_group("NOE");
        let mut cells = step.create_group("MAI");
        cells.set_attr("CGT", whole(1));
        let mut faces = cells.create_group("TR3");
        for group in [&mut points, &mut faces] {
            group.set_attr("CGT", whole(1));
            group.set_attr("CGS", whole(1));
            group.set_attr("PFL", text(ALL, NAME)?);
        }
        let places = points.create_dataset("COO").with_f64_data(&self.places);
        places.set_attr("CGT", whole(1)).set_attr("NBR", nodes);
        step.add_group(points.finish());
        for (key, numbers) in [("NOD", &self.corners), ("FAM", &self.families)] {
            let numbers = faces.create_dataset(key).with_i32_data(numbers);
            numbers.set_attr("CGT", whole(1)).set_attr("NBR", triangles.clone());
        }
        cells.add_group(faces.finish());
        step.add_group(cells.finish());
        mesh.add_group(step.finish());
        meshes.add_group(mesh.finish());
        file.add_group(meshes.finish());

        let mut all = file.create_group("FAS");
        let mut of_mesh = all.create_group(MESH);
        let mut zero = of_mesh.create_group("FAMILLE_ZERO");
        zero.set_attr("NUM", whole(0));
        of_mesh.add_group(zero.finish());
        let mut of_cells = of_mesh.create_group("ELEME");
        for (k, groups) in (1..).zip(&self.named) {
            let mut family = of_cells.create_group(&format!("FAM_-{k}"));
            family.set_attr("NUM", whole(-k));
            let mut list = family.create_group("GRO");
            list.set_attr("NBR", whole(groups.len() as i32));
            let mut names = Vec::with_capacity(LONGEST_NAME * groups.len());
            for group in groups {
                let mut name = self.called[group].clone().into_bytes();
                name.resize(LONGEST_NAME, 0);
                names.extend(name);
            }
            let count = groups.len() as u64;
            list.create_dataset("NOM").with_array_data(make_i8_type(), &[LONGEST_NAME as u32], names, count);
            family.add_group(list.finish());
            of_cells.add_group(family.finish());
        }
        of_mesh.add_group(of_cells.finish());
        all.add_group(of_mesh.finish());
        file.add_group(all.finish());
        file.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::shortened;

    #[test]
    fn names_are_cut_at_letters_and_stay_apart() {
        let long = "é".repeat(60);
        let named =
            vec![vec![long.clone() + "a", long.clone() + "b"], vec!["bore\0".into(), String::new(), "bore_".into()]];
        let (called, renamed) = shortened(&named);
        assert_eq!(called[&(long.clone() + "a")], "é".repeat(40));
        assert_eq!(called[&(long + "b")], "é".repeat(39) + "_2");
        assert_eq!([&called["bore\0"], &called[""], &called["bore_"]], ["bore_", "_2", "bore__2"]);
        assert_eq!(renamed.len(), 5);
    }
}
