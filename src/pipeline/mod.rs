//! The only room that sees everything: from a part to a mesh with its report, and the questions a command asks.

mod attempts;
mod bodies;
mod brep;
mod brep_info;
mod brep_oracle;
mod built;
mod compare;
mod compare_soup;
mod crowded;
mod discrete;
mod distance;
mod faults;
mod heal;
mod hidden;
mod history;
mod leaf;
mod mesh;
mod refine;
mod report;
mod shown;
mod soup_sizes;
mod touching;

pub use crate::implicit::part::{Part, SizeRequest};
pub use brep::{is_step, load_step, mesh_step};
pub use brep_info::{BodyReport, BoxInfo, BrepInfo, FaceReport, against_step, brep_info};
pub use built::{build, save_step};
pub use compare::{Comparison, Row, compare};
pub use compare_soup::compare_soup;
pub use discrete::{FaceInfo, SoupInfo, SoupOptions, is_mesh, load_mesh, mesh_soup, soup_info};
pub use distance::Distance;
pub use heal::{Action, Defect, HealOptions, HealReport, Healed, Repair, heal};
pub use history::{Attempt, Proof, Stage, Tried, UnprovedPlace};
pub use mesh::{MeshOptions, Meshed, Method, against, load_part, mesh_part};
pub use refine::{Place, Refinement};
pub use report::{FaceStep, Info, LeafInfo, Report, Rung, SCHEMA, info};
pub use shown::{shown, shown_healed};
