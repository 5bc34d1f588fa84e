//! Solids and sheets by program: edges extruded, revolved, lofted and swept (\[KUZ19\] section 3: extrusion by direction, distance and
//! end scale; revolution around any axis), with flat caps where a solid is asked for.
//!
//! Every builder takes [`Wire`]s and gives a [`Brep`] that [`Parametric`](super::Parametric) meshes. Edges are made once and
//! shared by their faces; surfaces are elementary where they can be, NURBS or swept curves where not.
//!
//! *Guarantees*: loops are closed, edges and vertices lie on the surfaces of their faces to rounding; a solid's every edge is
//! used twice, once in each direction, and its faces look outwards.
//! *Does not guarantee*: that a body does not intersect itself: a contour that crosses itself, or sections that lie badly,
//! give what they give. The certificate of the mesh tells.
//! *Errors*: [`Error::Input`](crate::Error::Input) that names the place in space.

mod assembly;
mod conic;
mod extrude;
mod loft;
mod patch;
mod revolve;
mod sew;
mod sweep;
#[cfg(test)]
mod tests;
mod wire;

pub use extrude::{Extrusion, extrude_edges};
pub use loft::{Loft, Section, loft, ruled};
pub use patch::{Across, over_chains, patch, shift_edges};
pub use revolve::{Axis, revolve_edges};
pub use sew::{flat_face, sew};
pub use sweep::sweep_edges;
pub use wire::{Gap, Piece, Wire};

use super::brep::Brep;
use super::frame::Similarity;

impl Brep {
    /// The model moved.
    pub fn moved(&self, m: &Similarity) -> Self {
        let mut out = self.clone();
        out.vertices.iter_mut().for_each(|p| *p = m.point(*p));
        out.edges.iter_mut().for_each(|e| e.curve = e.curve.moved(m));
        out.faces.iter_mut().for_each(|f| f.surface = f.surface.moved(m));
        out
    }

    /// Puts a name before those of all faces, and gives it to the bodies; several bodies are numbered.
    pub fn named(mut self, name: &str) -> Self {
        let several = self.bodies.len() > 1;
        for (i, b) in self.bodies.iter_mut().enumerate() {
            b.name = if several { format!("{name}{}", i + 1) } else { name.to_string() };
        }
        self.faces.iter_mut().for_each(|f| f.name = format!("{name}.{}", f.name));
        self
    }

    /// Several models side by side. Names of bodies and faces that come again get a number.
    pub fn together(models: Vec<Brep>) -> Self {
        let mut out = Brep::default();
        for mut m in models {
            let (v, e, f) = (out.vertices.len() as u32, out.edges.len() as u32, out.faces.len() as u32);
            m.edges.iter_mut().for_each(|x| x.ends.iter_mut().for_each(|k| *k += v));
            m.faces.iter_mut().for_each(|x| x.loops.iter_mut().flatten().for_each(|c| c.edge += e));
            m.bodies.iter_mut().for_each(|x| x.faces.iter_mut().for_each(|k| *k += f));
            out.vertices.append(&mut m.vertices);
            out.edges.append(&mut m.edges);
            out.faces.append(&mut m.faces);
            out.bodies.append(&mut m.bodies);
        }
        let mut used = rustc_hash::FxHashSet::default();
        let names = out.faces.iter_mut().map(|f| &mut f.name);
        for name in names {
            let base = name.clone();
            let mut k = 2;
            while !used.insert(name.clone()) {
                *name = format!("{base}~{k}");
                k += 1;
            }
        }
        out
    }
}
