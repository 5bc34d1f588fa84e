//! The only room that sees everything: from a part to a mesh with its report, and the questions a command asks.

mod bodies;
mod body_ladder;
mod boolean;
mod brep;
mod brep_check;
mod brep_info;
mod brep_oracle;
mod bricks;
mod budget;
mod built;
mod cells;
mod compare;
mod compare_soup;
mod discrete;
mod distance;
mod faults;
mod figure;
mod first_faces;
mod heal;
mod hidden;
mod history;
mod join;
mod ladder;
mod leaf;
mod lengths;
mod load;
mod mesh;
mod method;
mod missed;
mod options;
mod picture;
mod refine;
mod remesh_face;
mod report;
mod report_tables;
mod rsystems;
mod sampled;
mod samples;
mod sheet;
mod shown;
mod soup_info;
mod soup_ladder;
mod soup_patches;
mod soup_sizes;
mod touching;
mod volume;
mod wish;

pub use crate::implicit::RSystem;
pub use crate::implicit::part::{Part, SizeRequest};
pub use crate::optimize::Sequence;
pub use crate::parametric::mesh::Remedy;
pub use brep::{is_step, load_step, mesh_step};
pub use brep_check::{BodyDiagnosis, BrepDiagnosis, ModelFault, diagnose_brep, diagnose_step};
pub use brep_info::{
    BodyReport, BoxInfo, BrepInfo, FaceReport, PartInfo, against_step, brep_info, distances_to_step, part_info,
};
pub use bricks::{
    BrickPlan, MergedBricks, PiecewiseMesh, PlanOptions, PlanSource, ROUNDS, Share, make_bricks, make_piece,
    merge_bricks, merge_on_disk, merge_pieces,
};
pub use budget::expected_triangles;
pub use built::{build, save_step};
pub use compare::{Comparison, Row, compare, node_classes};
pub use compare_soup::compare_soup;
pub use discrete::{SoupOptions, is_mesh, load_mesh, mesh_soup};
pub use distance::Distance;
pub use figure::{BorderLength, FigureReport};
pub use heal::{Action, Defect, HealOptions, HealReport, Healed, Repair, heal};
pub use history::{Attempt, Proof, Stage, Tried, UnprovedBrick, UnprovedPlace};
pub use join::{JoinReport, Joined, join, join_files};
pub use ladder::{Budget, Change};
pub use load::{files_read, is_3mf, is_vm, levelset_bytes, load_part, parse_part, part_text, vm_text};
pub use mesh::{Meshed, against, distances_to, mesh_part};
pub use method::Method;
pub use options::MeshOptions;
pub use picture::{Coloring, PictureOptions, TrueSurface, check_picture_name, picture, pixels, write_picture};
pub use refine::{Place, Refinement};
pub use report::{FaceStep, Info, LeafInfo, Report, Rung, SCHEMA, info};
pub use report_tables::report_tables;
pub use rsystems::{Depth, Spread, SystemComparison, SystemRow, compare_rsystems};
pub use sampled::{EvalSummary, GridOptions, GridSpacing, eval_points, function, sample_grid};
pub use samples::{Sample, SampleComparison, SampleRow, compare_samples};
pub use sheet::Sheet;
pub use shown::{shown, shown_healed};
pub use soup_info::{EdgeInfo, FaceInfo, SoupInfo, soup_info};
pub use volume::VolumeLoss;
