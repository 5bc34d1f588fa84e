//! 3MF: packages of objects with placements. Meshes are read and written here; level sets are read by the implicit gate.

mod model;
mod package;
mod text;
mod write;

use glam::DVec3;

use super::build::{MeshBuilder, UNNAMED, check_node_count};
use super::text::unescape;
use crate::error::{Error, Place, Result};
use crate::mesh::TriMesh;
use crate::run::Run;

pub(crate) use model::{
    Model, Placed, Xml, attribute, child, children, corners_of, finite, number, place_of, real, transform, wrong,
};
pub(crate) use package::{model_text, packed, parsed};
pub(crate) use text::{Scaled, escaped, unit_of};
pub(super) use write::write;

/// Triangles of all objects that are built: components repeat them.
const MOST_TRIANGLES: usize = 200_000_000;

/// Whether a package builds a level set, as far as its text tells; what cannot be read at all builds none.
pub(crate) fn has_levelset(bytes: &[u8]) -> bool {
    let read = || -> Result<bool> {
        let text = model_text(bytes)?;
        // Most packages have meshes alone, and are large: a tree of elements is not needed to say so.
        if !text.contains("levelset") {
            return Ok(false);
        }
        let xml = parsed(&text)?;
        Ok(xml.descendants().any(|n| n.tag_name().name() == "levelset"))
    };
    // A model that is no XML is told so by the gate of functions as by the other one.
    read().unwrap_or(false)
}

/// The meshes of all that is built as one, with faces by the names of base materials, else of objects.
pub(super) fn read(bytes: &[u8], run: &Run) -> Result<TriMesh> {
    let text = model_text(bytes)?;
    let xml = parsed(&text)?;
    let model = Model::new(&xml)?;
    let placed = model.placed()?;
    if let Some(other) = placed.iter().find(|p| p.is_levelset()) {
        let what = format!("object {} is a level set, not triangles", other.id);
        return Err(wrong(other.shape, what).with_help("mesh the file as a part: rvachev mesh a.3mf"));
    }
    let mut builder = MeshBuilder::default();
    for one in &placed {
        run.check()?;
        let corners = corners_of(one.shape)?;
        let first = builder.mesh.nodes.len();
        check_node_count(first + corners.nodes.len(), place_of(one.shape))?;
        if builder.mesh.triangles.len() + corners.triangles.len() > MOST_TRIANGLES {
            return Err(wrong(one.shape, format!("more than {MOST_TRIANGLES} triangles are built: that is the limit")));
        }
        let moved: Vec<DVec3> = corners.nodes.iter().map(|p| one.map.transform_point3(*p)).collect();
        if moved.iter().any(|p| !p.is_finite()) {
            return Err(wrong(one.shape, "its transform moves a vertex out of all numbers"));
        }
        builder.mesh.nodes.extend(moved);
        let own = match (one.name(), placed.len()) {
            (Some(name), _) => name,
            (None, 1) => UNNAMED.to_owned(),
            (None, _) => format!("object{}", one.id),
        };
        let mirrored = one.map.matrix3.determinant() < 0.0;
        for (triangle, element) in corners.triangles.iter().zip(&corners.elements) {
            let name = material(&model, one, *element);
            let face = builder.face(&name.map_or_else(|| own.clone(), unescape));
            let mut t = triangle.map(|v| v + first as u32);
            if mirrored {
                t.swap(1, 2);
            }
            builder.fan(&t, face);
        }
    }
    if builder.mesh.triangles.is_empty() {
        return Err(Error::input(Place::Unknown, "the file holds no triangle"));
    }
    Ok(builder.mesh)
}

/// The name of a triangle's base material; whatever else may be wrong with materials does not matter for the shape.
fn material<'a>(model: &Model<'a>, placed: &Placed<'a>, triangle: Xml<'a>) -> Option<&'a str> {
    let own = |name: &str| triangle.attribute(name);
    let group = own("pid").or_else(|| placed.object.attribute("pid"))?.parse().ok()?;
    let index: usize = own("p1").or_else(|| placed.object.attribute("pindex"))?.parse().ok()?;
    let group = model.resource(group, triangle).ok().filter(|g| g.tag_name().name() == "basematerials")?;
    children(group).nth(index)?.attribute("name")
}
