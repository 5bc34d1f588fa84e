//! Volumes swept by one face of a finished surface mesh, as layers of prisms over its triangles.
//!
//! *Reference.* \[LAZ\], conclusion: "extended to structured volume meshes"; the extension itself is not described there. Prisms are
//! structured across the layers, and as the face is along them.

use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};

use super::sides::{TriangleSide, sides};
use super::trimesh::TriMesh;
use crate::error::{Error, Place, Result};
use crate::numeric::{NONE, ROUNDING};
use crate::spatial::Aabb;

/// By which share the volume between the surface's walls may differ from that of the prisms: walls may bend between their rims as
/// chords of a bore do.
const WALLS: f64 = 0.01;
/// Corners of a prism's sides, counterclockwise as seen from outside: bottom, top, walls in the order of the bottom's edges.
const CORNERS: [&[usize]; 5] = [&[0, 2, 1], &[3, 4, 5], &[0, 1, 4, 3], &[1, 2, 5, 4], &[2, 0, 3, 5]];

/// What to do about faces that do not match.
const HELP: &str = "one of the faces alone can be swept along a vector";

/// A side of a prism that no other prism has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OuterSide {
    /// The prism.
    pub cell: u32,
    /// Which of its sides: 0 the bottom, 1 the top, 2 the wall over corners 0 and 1, 3 over 1 and 2, 4 over 2 and 0.
    pub side: u8,
    /// The name it goes by, an index into [`Prisms::names`].
    pub label: u32,
}

/// A volume mesh of prisms over triangles, with the names of the surface it fills or starts from.
///
/// The first three corners of a prism run counterclockwise as seen from the other three, as gmsh and Abaqus have them. Corner 3 is
/// across from corner 0. Nodes and prisms come layer by layer from the bottom, in each layer in the order of the face's triangles.
///
/// ```
/// use rvachev::mesh::{Prisms, TriMesh};
/// use rvachev::{DVec3, Result};
///
/// fn main() -> Result<()> {
///     let square = vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
///     let mut face = TriMesh::new(square, vec![[0, 1, 2], [0, 2, 3]]);
///     face.faces = vec!["floor".into()];
///     let prisms = Prisms::swept(&face, "floor", DVec3::new(0.0, 0.0, 3.0), 4)?;
///     assert_eq!((prisms.cells.len(), prisms.volume()), (8, 3.0));
///     assert_eq!(prisms.names, ["floor", "opposite", "side"]);
///     Ok(())
/// }
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Prisms {
    /// Places, in the unit of the surface.
    pub nodes: Vec<DVec3>,
    /// Corners of each prism.
    pub cells: Vec<[u32; 6]>,
    /// The boundary: the bottom, the top, then the walls, layer by layer.
    pub outer: Vec<OuterSide>,
    /// Names of the boundary: that of the bottom, that of the top, then those of walls.
    pub names: Vec<String>,
}

impl Prisms {
    /// Fills the room between two faces of a mesh by as many layers of prisms, all equally thick. Nodes and triangles of the top must be
    /// those of the bottom, moved along one vector; their numbers do not matter. A merged surface comes by [`TriMesh::from_view`].
    ///
    /// The boundary has the names of the two faces, and on its walls those of the faces beside them; a wall with no face beside it is
    /// called `side`.
    ///
    /// *Guarantees*: every prism has a positive volume. A side of a prism has two prisms, or is in [`outer`](Self::outer) once. Nodes
    /// of the bottom and of the top have the surface's places bit by bit. Where faces are beside all walls, they close the room, and
    /// what they hold differs from the prisms' volume by less than a hundredth.
    /// *Does not guarantee*: that nodes of walls between the two faces are those of the surface, or that prisms over a bent face
    /// keep apart. Groups of faces are not taken over. Faces that were meshed one by one hardly ever match; [`swept`](Self::swept)
    /// fills the room from one of them.
    ///
    /// # Errors
    /// [`Error::Usage`] for no layer, a name no face has, or one face twice. [`Error::Input`] with the place where the faces do not match,
    /// where their walls have other names at the bottom than at the top, are open or not straight, where a face is no sheet, and where a
    /// prism is flat or turned over. [`Error::Failed`] for more than 32 bits can number.
    pub fn between(mesh: &TriMesh, bottom: &str, top: &str, layers: u32) -> Result<Self> {
        mesh.validate()?;
        if bottom == top {
            return Err(Error::Usage(format!("prisms lie between two faces, and {bottom:?} is one")));
        }
        let all = sides(mesh);
        let low = Lid::new(mesh, &all, bottom)?;
        let high = Lid::new(mesh, &all, top)?;
        let partners = low.matched(mesh, &high)?;
        let walls = low.walls(mesh, &high, &partners)?;
        let opposite = partners.iter().map(|v| mesh.nodes[*v as usize]).collect();
        let out = low.fill(mesh, opposite, layers, top)?;
        if !walls.contains(&None) {
            let mut shell = vec![false; mesh.faces.len()];
            walls.iter().flatten().chain([&low.label, &high.label]).for_each(|l| shell[*l as usize] = true);
            check_shell(mesh, &all, &shell, out.volume())?;
        }
        Ok(out)
    }

    /// The prisms that a face of a mesh sweeps when it moves along a vector, in the mesh's unit.
    ///
    /// The boundary has the name of the face, `opposite` across from it, and on its walls the names of the faces that border on the
    /// face there, or `side`. Where the mesh has a face of the name `opposite` or `side`, a number goes behind ours. The rest of
    /// the mesh is not looked at: the face may sweep into the solid, or away from it. Whoever fills a plate from its top may
    /// change the second of the [`names`](Self::names) to that of the plate's bottom.
    ///
    /// *Guarantees*, *does not guarantee*: as [`between`](Self::between), without what is said of walls and the top.
    ///
    /// # Errors
    /// As [`between`](Self::between); [`Error::Usage`] for a vector that is zero or not finite.
    pub fn swept(mesh: &TriMesh, face: &str, along: DVec3, layers: u32) -> Result<Self> {
        mesh.validate()?;
        if !along.is_finite() || along == DVec3::ZERO {
            return Err(Error::Usage(format!("no face is swept along {along}")));
        }
        let low = Lid::new(mesh, &sides(mesh), face)?;
        let opposite = low.nodes.iter().map(|v| mesh.nodes[*v as usize] + along).collect();
        low.fill(mesh, opposite, layers, &unlike("opposite", &mesh.faces))
    }

    /// The corners of an outer side, three or four, counterclockwise as seen from outside.
    ///
    /// # Panics
    /// Where there is no such side or prism.
    pub fn corners(&self, outer: &OuterSide) -> impl ExactSizeIterator<Item = u32> + use<> {
        let cell = self.cells[outer.cell as usize];
        Self::side(outer.side).iter().map(move |k| cell[*k])
    }

    /// The corners of a side, by their places in a prism.
    ///
    /// # Panics
    /// Where there is no such side.
    pub(super) fn side(side: u8) -> &'static [usize] {
        CORNERS[usize::from(side)]
    }

    /// The volume of a prism: that of the map which is linear along its triangles and across, for bent walls, too.
    ///
    /// # Panics
    /// Where there is no such prism.
    pub fn volume_of(&self, prism: usize) -> f64 {
        let p = self.cells[prism].map(|v| self.nodes[v as usize]);
        let across = (p[3] - p[0] + p[4] - p[1] + p[5] - p[2]) / 3.0;
        let area = |t: f64| {
            let [a, b, c] = [0, 1, 2].map(|k| p[k].lerp(p[k + 3], t));
            0.5 * (b - a).cross(c - a)
        };
        // Areas change by the square of the way, which Simpson's rule integrates exactly.
        ((area(0.0) + 4.0 * area(0.5) + area(1.0)) / 6.0).dot(across)
    }

    /// The volume of all prisms, in the cubed unit of the nodes.
    pub fn volume(&self) -> f64 {
        (0..self.cells.len()).map(|j| self.volume_of(j)).sum()
    }

    /// The number of a name, which is added if it is not there.
    fn label(&mut self, name: &str) -> u32 {
        let found = self.names.iter().position(|n| n == name);
        found.unwrap_or_else(|| {
            self.names.push(name.into());
            self.names.len() - 1
        }) as u32
    }
}

/// One edge of a face's border.
struct RimEdge {
    /// A triangle of the face, by its number there.
    triangle: u32,
    /// The edge from this corner to the next.
    corner: u8,
    /// The face beside it.
    beside: Option<u32>,
}

/// One face of a mesh by itself.
struct Lid {
    label: u32,
    /// The mesh's nodes in it, in the order its triangles name them.
    nodes: Vec<u32>,
    /// Corners by their places in `nodes`.
    triangles: Vec<[u32; 3]>,
    rim: Vec<RimEdge>,
}

impl Lid {
    fn new(mesh: &TriMesh, all: &[TriangleSide], name: &str) -> Result<Self> {
        let Some(label) = mesh.faces.iter().position(|f| f == name).map(|l| l as u32) else {
            let names = mesh.faces.join(", ");
            return Err(Error::Usage(format!("no face is called {name:?}; there are {names}")));
        };
        let own: Vec<u32> = (0..mesh.triangles.len() as u32).filter(|t| mesh.labels[*t as usize] == label).collect();
        if own.is_empty() {
            return Err(Error::input(Place::Item(format!("face {name:?}")), "it has no triangle"));
        }
        let (mut number, mut nodes) = (vec![NONE; mesh.nodes.len()], Vec::new());
        let triangles = own.iter().map(|t| {
            mesh.triangles[*t as usize].map(|v| {
                let own = &mut number[v as usize];
                if *own == NONE {
                    *own = nodes.len() as u32;
                    nodes.push(v);
                }
                *own
            })
        });
        let triangles = triangles.collect();
        let mut rim = Vec::new();
        for edge in all.chunk_by(|a, b| a.key == b.key) {
            let label_of = |side: &TriangleSide| mesh.labels[side.triangle() as usize];
            let mine: Vec<&TriangleSide> = edge.iter().filter(|s| label_of(s) == label).collect();
            match mine[..] {
                [] => {}
                [one] => {
                    let triangle = own.partition_point(|t| *t < one.triangle()) as u32;
                    let beside = edge.iter().map(label_of).filter(|l| *l != label).min();
                    rim.push(RimEdge { triangle, corner: (one.number % 3) as u8, beside });
                }
                [a, b] if a.forward != b.forward => {}
                _ => {
                    let what = format!("triangles of the face {name:?} do not form a sheet that looks one way");
                    return Err(Error::input(middle(mesh, edge[0].edge()), what));
                }
            }
        }
        // Prisms of one triangle stand together.
        rim.sort_unstable_by_key(|e| [e.triangle, u32::from(e.corner)]);
        Ok(Self { label, nodes, triangles, rim })
    }

    /// The nodes at the ends of an edge of the border, by their places in `nodes`.
    fn ends(&self, edge: &RimEdge) -> [u32; 2] {
        let [k, corners] = [usize::from(edge.corner), 3];
        [k, (k + 1) % corners].map(|k| self.triangles[edge.triangle as usize][k])
    }

    /// For each node of this face the mesh's node across from it on the other one.
    fn matched(&self, mesh: &TriMesh, high: &Self) -> Result<Vec<u32>> {
        let name = |lid: &Self| &mesh.faces[lid.label as usize];
        let counts = [self, high].map(|lid| [lid.nodes.len(), lid.triangles.len()]);
        if counts[0] != counts[1] {
            let told = [0, 1].map(|k| {
                format!("{:?} has {} nodes and {} triangles", name([self, high][k]), counts[k][0], counts[k][1])
            });
            let what = format!("the faces do not match: {}", told.join(", "));
            return Err(Error::input(Place::Unknown, what).with_help(HELP));
        }
        let places = |lid: &Self| lid.nodes.iter().map(|v| mesh.nodes[*v as usize]).collect::<Vec<_>>();
        let [from, to] = [self, high].map(places);
        let along = Aabb::around(to.iter().copied()).lo - Aabb::around(from.iter().copied()).lo;
        // Nodes match if they are nearer to each other than this, once a face is moved onto the other.
        let near = ROUNDING * mesh.bounds().diagonal();
        // Ordered along a direction in which hardly any mesh has rows, few nodes are to be compared.
        let askew = DVec3::new(0.5418, 0.6373, 0.5479);
        let mut order: Vec<u32> = (0..to.len() as u32).collect();
        let height = |v: &u32| to[*v as usize].dot(askew);
        order.sort_by(|a, b| height(a).total_cmp(&height(b)));
        let mut taken = vec![false; to.len()];
        let mut partners = Vec::with_capacity(from.len());
        for p in &from {
            let q = *p + along;
            let first = order.partition_point(|v| height(v) < q.dot(askew) - near);
            let level = order[first..].iter().take_while(|v| height(v) <= q.dot(askew) + near);
            let found = level.copied().find(|v| !taken[*v as usize] && to[*v as usize].distance(q) <= near);
            let Some(v) = found else {
                let what = format!(
                    "the faces do not match: no node of {:?} is across from this one of {:?}",
                    name(high),
                    name(self)
                );
                return Err(Error::input(Place::Point(*p), what).with_help(HELP));
            };
            taken[v as usize] = true;
            partners.push(v);
        }
        let key = |mut t: [u32; 3]| {
            t.sort_unstable();
            t
        };
        let mut theirs: FxHashSet<[u32; 3]> = high.triangles.iter().copied().map(key).collect();
        for t in &self.triangles {
            if !theirs.remove(&key(t.map(|v| partners[v as usize]))) {
                let at = t.iter().map(|v| from[*v as usize]).sum::<DVec3>() / 3.0;
                let what = format!(
                    "the faces do not match: no triangle of {:?} is across from this one of {:?}",
                    name(high),
                    name(self)
                );
                return Err(Error::input(Place::Point(at), what).with_help(HELP));
            }
        }
        Ok(partners.into_iter().map(|v| high.nodes[v as usize]).collect())
    }

    /// The faces beside the border, which must be the same on both faces.
    fn walls(&self, mesh: &TriMesh, high: &Self, partners: &[u32]) -> Result<Vec<Option<u32>>> {
        let key = |[a, b]: [u32; 2]| [a.min(b), a.max(b)];
        let on_high = |e: &RimEdge| (key(high.ends(e).map(|v| high.nodes[v as usize])), e.beside);
        let beside: FxHashMap<[u32; 2], Option<u32>> = high.rim.iter().map(on_high).collect();
        let name = |l: Option<u32>| l.map_or("no face".into(), |l| format!("the face {:?}", mesh.faces[l as usize]));
        let check = |e: &RimEdge| {
            let across = beside.get(&key(self.ends(e).map(|v| partners[v as usize]))).copied().flatten();
            if across == e.beside {
                return Ok(e.beside);
            }
            let at = middle(mesh, self.ends(e).map(|v| self.nodes[v as usize]));
            let what = format!("{} is beside the bottom here, and {} beside the top", name(e.beside), name(across));
            Err(Error::input(at, what))
        };
        self.rim.iter().map(check).collect()
    }

    /// Layers of prisms from this face to the places across.
    fn fill(&self, mesh: &TriMesh, opposite: Vec<DVec3>, layers: u32, top: &str) -> Result<Prisms> {
        if layers == 0 {
            return Err(Error::Usage("prisms need at least one layer".into()));
        }
        let [n, m, rim] = [self.nodes.len(), self.triangles.len(), self.rim.len()].map(|x| x as u64);
        let (way, most) = (u64::from(layers), u64::from(u32::MAX - 1));
        if n * (way + 1) > most || m * way + 2 * m + rim * way > most {
            return Err(Error::Failed(format!("{layers} layers have more nodes or prisms than 32 bits can number")));
        }
        let mut out = Prisms::default();
        for k in 0..=layers {
            let share = f64::from(k) / f64::from(layers);
            out.nodes.extend(self.nodes.iter().zip(&opposite).map(|(v, q)| mesh.nodes[*v as usize].lerp(*q, share)));
        }
        for k in 0..layers {
            let [low, high] = [k, k + 1].map(|k| k * n as u32);
            let over = |t: &[u32; 3]| [t[0] + low, t[1] + low, t[2] + low, t[0] + high, t[1] + high, t[2] + high];
            out.cells.extend(self.triangles.iter().map(over));
        }
        // A face of a solid looks away from the room behind it.
        let turned = out.volume() < 0.0;
        if turned {
            out.cells.iter_mut().for_each(|[_, b, c, _, e, f]| {
                std::mem::swap(b, c);
                std::mem::swap(e, f);
            });
        }
        for j in 0..out.cells.len() {
            let [a, b, c, d, ..] = out.cells[j].map(|v| out.nodes[v as usize]);
            let full = 0.5 * (b - a).cross(c - a).length() * a.distance(d);
            // A prism is flat if its volume is less than this share of its triangle's area times the way.
            if !(out.volume_of(j) > ROUNDING * full) {
                let what = "the prism over this triangle is flat, or turned over against others";
                return Err(Error::input(Place::Point(bottom_center(&out, j % self.triangles.len())), what));
            }
        }
        self.name_sides(mesh, &mut out, turned, top);
        Ok(out)
    }

    /// Lists the boundary of prisms with its names.
    fn name_sides(&self, mesh: &TriMesh, out: &mut Prisms, turned: bool, top: &str) {
        let (m, count) = (self.triangles.len() as u32, out.cells.len() as u32);
        let label = out.label(&mesh.faces[self.label as usize]);
        out.outer.extend((0..m).map(|cell| OuterSide { cell, side: 0, label }));
        let label = out.label(top);
        out.outer.extend((count - m..count).map(|cell| OuterSide { cell, side: 1, label }));
        let open = unlike("side", &mesh.faces);
        let mut known: FxHashMap<Option<u32>, u32> = FxHashMap::default();
        let labels: Vec<u32> = (self.rim.iter())
            .map(|e| {
                *known.entry(e.beside).or_insert_with(|| out.label(e.beside.map_or(&open, |l| &mesh.faces[l as usize])))
            })
            .collect();
        for layer in 0..count / m {
            let wall = |(e, label): (&RimEdge, &u32)| {
                // With corners 1 and 2 exchanged, edges run the other way and in the other order.
                let side = 2 + if turned { 2 - e.corner } else { e.corner };
                OuterSide { cell: layer * m + e.triangle, side, label: *label }
            };
            out.outer.extend(self.rim.iter().zip(&labels).map(wall));
        }
    }
}

/// The middle of a prism's bottom.
fn bottom_center(prisms: &Prisms, prism: usize) -> DVec3 {
    prisms.cells[prism][..3].iter().map(|v| prisms.nodes[*v as usize]).sum::<DVec3>() / 3.0
}

fn middle(mesh: &TriMesh, edge: [u32; 2]) -> Place {
    let [a, b] = edge.map(|v| mesh.nodes[v as usize]);
    Place::Point(a.midpoint(b))
}

/// The name, with a number behind it where it is taken.
fn unlike(name: &str, taken: &[String]) -> String {
    let numbered = (2..).map(|k| format!("{name} {k}"));
    let mut names = std::iter::once(name.to_owned()).chain(numbered);
    names.find(|n| !taken.contains(n)).unwrap_or_default()
}

/// Refuses faces that do not close a room, or hold another volume than the prisms between them.
fn check_shell(mesh: &TriMesh, all: &[TriangleSide], shell: &[bool], volume: f64) -> Result<()> {
    let of_shell = |t: u32| shell[mesh.labels[t as usize] as usize];
    for edge in all.chunk_by(|a, b| a.key == b.key) {
        if edge.iter().filter(|s| of_shell(s.triangle())).count() % 2 == 1 {
            let what = "the walls between the two faces are open here, or go on beyond them";
            return Err(Error::input(middle(mesh, edge[0].edge()), what));
        }
    }
    let o = mesh.bounds().center();
    let six = |t: u32| {
        let [a, b, c] = mesh.corners(t as usize).map(|p| p - o);
        a.dot(b.cross(c))
    };
    let held = ((0..mesh.triangles.len() as u32).filter(|t| of_shell(*t)).map(six).sum::<f64>() / 6.0).abs();
    if (held - volume).abs() > WALLS * volume {
        let what = format!(
            "the walls between the two faces are not straight: they hold a volume of {held}, and prisms one of {volume}"
        );
        return Err(Error::input(Place::Unknown, what));
    }
    Ok(())
}
