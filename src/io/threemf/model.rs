//! A 3MF model: resources by number, and what is built of them, with placements.

use glam::{DAffine3, DVec3};
use roxmltree::{Document, Node};
use rustc_hash::FxHashMap;

use crate::error::{Error, Place, Result};
use crate::run::DEEPEST;

/// An element of the model.
pub(crate) type Xml<'a> = Node<'a, 'a>;

/// Objects of the build, counted through all components.
const MOST_PLACED: usize = 100_000;

/// A model whose resources are found by number.
pub(crate) struct Model<'a> {
    /// The unit of length, as a part file calls it.
    pub(crate) unit: &'static str,
    resources: FxHashMap<u64, Xml<'a>>,
    items: Vec<Xml<'a>>,
}

/// A mesh or a level set, and where it stands in the build.
#[derive(Clone, Copy)]
pub(crate) struct Placed<'a> {
    /// The object's number.
    pub(crate) id: u64,
    pub(crate) object: Xml<'a>,
    /// The element `mesh` or `levelset` in it.
    pub(crate) shape: Xml<'a>,
    /// From the object's coordinates to those of the build.
    pub(crate) map: DAffine3,
}

impl Placed<'_> {
    /// Whether a level set tells its surface.
    pub(crate) fn is_levelset(&self) -> bool {
        self.shape.tag_name().name() == "levelset"
    }

    /// The object's own name, if it has one.
    pub(crate) fn name(&self) -> Option<String> {
        let name = self.object.attribute("name")?;
        let name: String = name.chars().filter(|c| !c.is_control()).collect();
        Some(name.trim().to_owned()).filter(|n| !n.is_empty())
    }
}

/// The corners and triangles of one `mesh`.
pub(crate) struct MeshResource<'a> {
    pub(crate) nodes: Vec<DVec3>,
    pub(crate) triangles: Vec<[u32; 3]>,
    /// The element of each triangle.
    pub(crate) elements: Vec<Xml<'a>>,
}

/// Where an element stands.
pub(crate) fn place_of(node: Xml<'_>) -> Place {
    let start = node.range().start;
    let at = node.document().text_pos_at(start);
    let len = 1 + node.tag_name().name().len();
    Place::Text { line: at.row as usize, column: at.col as usize, offset: start, len }
}

/// An error about an element.
pub(crate) fn wrong(node: Xml<'_>, what: impl Into<String>) -> Error {
    Error::input(place_of(node), what)
}

/// The attribute of that name.
pub(crate) fn attribute<'a>(node: Xml<'a>, name: &str) -> Result<&'a str> {
    node.attribute(name).ok_or_else(|| wrong(node, format!("<{}> has no attribute {name:?}", node.tag_name().name())))
}

/// An attribute that is the number of a resource.
pub(crate) fn number(node: Xml<'_>, name: &str) -> Result<u64> {
    let text = attribute(node, name)?;
    text.trim().parse().map_err(|_| wrong(node, format!("{name}={text:?} is no number of a resource")))
}

/// An attribute that is a finite number.
pub(crate) fn real(node: Xml<'_>, name: &str) -> Result<f64> {
    let text = attribute(node, name)?;
    finite(text).ok_or_else(|| wrong(node, format!("{name}={text:?} is no finite number")))
}

/// A finite number.
pub(crate) fn finite(text: &str) -> Option<f64> {
    text.trim().parse::<f64>().ok().filter(|v| v.is_finite())
}

/// An attribute that is a map; the identity if there is none.
pub(crate) fn transform(node: Xml<'_>) -> Result<DAffine3> {
    let Some(text) = node.attribute("transform") else { return Ok(DAffine3::IDENTITY) };
    let numbers: Vec<f64> = text.split_whitespace().filter_map(finite).collect();
    match (<[f64; 12]>::try_from(numbers), text.split_whitespace().count()) {
        (Ok(all), 12) => Ok(DAffine3::from_cols_array(&all)),
        _ => Err(wrong(node, "transform is no list of 12 finite numbers")),
    }
}

/// The elements in an element.
pub(crate) fn children<'a>(node: Xml<'a>) -> impl Iterator<Item = Xml<'a>> {
    node.children().filter(Node::is_element)
}

/// The first element of that name in an element.
pub(crate) fn child<'a>(node: Xml<'a>, name: &str) -> Option<Xml<'a>> {
    children(node).find(|n| n.tag_name().name() == name)
}

impl<'a> Model<'a> {
    /// The model in a tree of elements.
    pub(crate) fn new(xml: &'a Document<'a>) -> Result<Self> {
        let root = xml.root_element();
        if root.tag_name().name() != "model" {
            return Err(wrong(root, format!("a model should stand here, not <{}>", root.tag_name().name())));
        }
        let unit = match root.attribute("unit").unwrap_or("millimeter") {
            "micron" => "um",
            "millimeter" => "mm",
            "centimeter" => "cm",
            "inch" => "in",
            "foot" => "ft",
            "meter" => "m",
            other => return Err(wrong(root, format!("the unit {other:?} is not known"))),
        };
        let mut resources = FxHashMap::default();
        for node in child(root, "resources").into_iter().flat_map(children) {
            // Resources of other extensions may be without a number.
            if node.attribute("id").is_none() {
                continue;
            }
            let id = number(node, "id")?;
            if resources.insert(id, node).is_some() {
                return Err(wrong(node, format!("two resources have the number {id}")));
            }
        }
        let items: Vec<_> = child(root, "build").into_iter().flat_map(children).collect();
        let items: Vec<_> = items.into_iter().filter(|n| n.tag_name().name() == "item").collect();
        if items.is_empty() {
            return Err(wrong(root, "nothing is built: the model has no <build> with an <item>"));
        }
        Ok(Model { unit, resources, items })
    }

    /// The resource of a number, which an element names.
    pub(crate) fn resource(&self, id: u64, from: Xml<'_>) -> Result<Xml<'a>> {
        self.resources.get(&id).copied().ok_or_else(|| wrong(from, format!("there is no resource {id}")))
    }

    /// All that is built, in the order of the file, through all components.
    pub(crate) fn placed(&self) -> Result<Vec<Placed<'a>>> {
        let mut found = Vec::new();
        let mut steps = 0usize;
        let mut stack: Vec<_> = self.items.iter().rev().map(|n| (*n, DAffine3::IDENTITY, 0)).collect();
        while let Some((node, outer, depth)) = stack.pop() {
            steps += 1;
            if depth > DEEPEST {
                let what = format!("components are inside each other more than {DEEPEST} times, or in a circle");
                return Err(wrong(node, what));
            }
            if found.len() >= MOST_PLACED || steps > 2 * MOST_PLACED {
                return Err(wrong(node, format!("more than {MOST_PLACED} objects are built: that is the limit")));
            }
            if node.attributes().any(|a| a.name() == "path") {
                return Err(wrong(node, "objects in other parts of the package are not read"));
            }
            let id = number(node, "objectid")?;
            let map = outer * transform(node)?;
            if !map.is_finite() || map.matrix3.determinant() == 0.0 {
                return Err(wrong(node, "its transform is flat or overflows"));
            }
            let object = self.resource(id, node)?;
            if object.tag_name().name() != "object" {
                return Err(wrong(node, format!("resource {id} is <{}>, not an object", object.tag_name().name())));
            }
            if let Some(components) = child(object, "components") {
                let inner: Vec<_> = children(components).collect();
                stack.extend(inner.into_iter().rev().map(|n| (n, map, depth + 1)));
                continue;
            }
            let shape = children(object).find(|n| matches!(n.tag_name().name(), "mesh" | "levelset"));
            let Some(shape) = shape else {
                let what = match children(object).next() {
                    Some(other) => format!("object {id} is made of <{}>, which is not read", other.tag_name().name()),
                    None => format!("object {id} is empty"),
                };
                return Err(wrong(object, what).with_help("meshes, level sets and components of them are read"));
            };
            found.push(Placed { id, object, shape, map });
        }
        Ok(found)
    }
}

/// The corners and triangles of a `mesh`, in the object's coordinates.
pub(crate) fn corners_of(mesh: Xml<'_>) -> Result<MeshResource<'_>> {
    if let Some(lattice) = child(mesh, "beamlattice") {
        return Err(wrong(lattice, "beam lattices are not read"));
    }
    let mut nodes = Vec::new();
    for v in child(mesh, "vertices").into_iter().flat_map(children) {
        nodes.push(DVec3::new(real(v, "x")?, real(v, "y")?, real(v, "z")?));
    }
    let (mut triangles, mut elements) = (Vec::new(), Vec::new());
    for t in child(mesh, "triangles").into_iter().flat_map(children).filter(|n| n.tag_name().name() == "triangle") {
        let mut corners = [0; 3];
        for (corner, name) in corners.iter_mut().zip(["v1", "v2", "v3"]) {
            let v = number(t, name)?;
            if v >= nodes.len() as u64 {
                return Err(wrong(t, format!("{name} is vertex {v}, but there are {}", nodes.len())));
            }
            *corner = v as u32;
        }
        triangles.push(corners);
        elements.push(t);
    }
    Ok(MeshResource { nodes, triangles, elements })
}
