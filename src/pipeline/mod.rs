//! The only room that sees everything: from a part to a mesh with its report, and the questions a command asks.

mod attempts;
mod bodies;
mod boolean;
mod brep;
mod brep_check;
mod brep_info;
mod brep_oracle;
mod bricks;
mod budget;
mod built;
mod compare;
mod compare_soup;
mod crowded;
mod discrete;
mod distance;
mod faults;
mod figure;
mod heal;
mod hidden;
mod history;
mod leaf;
mod load;
mod mesh;
mod method;
mod refine;
mod remesh_face;
mod report;
mod report_tables;
mod rsystems;
mod sampled;
mod samples;
mod shown;
mod soup_sizes;
mod touching;
mod wish;

pub use crate::implicit::RSystem;
pub use crate::implicit::part::{Part, SizeRequest};
pub use crate::optimize::Sequence;
pub use brep::{is_step, load_step, mesh_step};
pub use brep_check::{BodyDiagnosis, BrepDiagnosis, ModelFault, diagnose_brep, diagnose_step};
pub use brep_info::{BodyReport, BoxInfo, BrepInfo, FaceReport, against_step, brep_info, distances_to_step};
pub use bricks::{
    BrickPlan, PlanOptions, PlanSource, ROUNDS, Share, make_bricks, make_piece, merge_bricks, merge_pieces,
    mesh_in_bricks,
};
pub use budget::expected_triangles;
pub use built::{build, save_step};
pub use compare::{Comparison, Row, compare, node_classes};
pub use compare_soup::compare_soup;
pub use discrete::{FaceInfo, SoupInfo, SoupOptions, is_mesh, load_mesh, mesh_soup, soup_info};
pub use distance::Distance;
pub use figure::{BorderLength, FigureReport};
pub use heal::{Action, Defect, HealOptions, HealReport, Healed, Repair, heal};
pub use history::{Attempt, Proof, Stage, Tried, UnprovedPlace};
pub use load::{files_read, is_3mf, is_vm, levelset_bytes, load_part, parse_part, part_text, vm_text};
pub use mesh::{MeshOptions, Meshed, against, distances_to, mesh_part};
pub use method::Method;
pub use refine::{Place, Refinement};
pub use report::{FaceStep, Info, LeafInfo, Report, Rung, SCHEMA, info};
pub use report_tables::report_tables;
pub use rsystems::{Depth, Spread, SystemComparison, SystemRow, compare_rsystems};
pub use sampled::{EvalSummary, GridOptions, GridSpacing, eval_points, function, sample_grid};
pub use samples::{Sample, SampleComparison, SampleRow, compare_samples};
pub use shown::{shown, shown_healed};
