//! Changes that gates make for a mesh that falls short: small models that need them, and whose meshes before that change were worse.

use approx::assert_relative_eq;
use rvachev::implicit::part::parse;
use rvachev::mesh::TriMesh;
use rvachev::pipeline::{
    Attempt, Change, MeshOptions, Meshed, SizeRequest, SoupOptions, Tried, load_step, mesh_part, mesh_soup, mesh_step,
};
use rvachev::quality::Fault;
use rvachev::{DVec3, Run};

mod shapes;
use shapes::revolved;

/// A ball with walls a 50th of its radius thick.
const SHELL: &str = "part(sphere(1) - sphere(0.98))";
/// A ball with needles at its poles.
const NEEDLE: &str = "part(sphere(1) | cylinder(0.0015, height=4))";
/// A fillet of a 150th of the size between a ball and a cube.
const FILLET: &str = "part(blend(sphere(0.98), box(size=(1.2, 1.2, 1.2), at=(0.9, 1.0, 0.25)), 0.003))";
/// A block of which a bore and a sheet leave a corner smaller than the cells, among solids that say where these are.
const CORNER: &str = r#"
s0 = (box(size=(1.662366067, 1.328710558, 1.863791419), at=(-0.341868311, 0.268182053, -0.715219778))).name("p0")
p16 = ((box(size=(1.5, 1.5, 1.5), at=(1.994706221, -1.204348233, 0.924949714)) & half_space((-0.47, -0.1, 1), at=(1.774645539, -0.501755345, 1.737470618)))).name("block")
s16 = s0 | p16
p27 = (torus(1.18315608, 0.169388398, axis="x", at=(-0.368984716, -1.570105644, 1.45631481))).name("p27")
s27 = s16 | p27
p30 = (sphere(0.395032022, at=(1.740637849, -0.792125332, 1.492307879))).name("p30")
s30 = blend(s27, p30, 0.1)
p35 = (cylinder(0.712980864, axis="z", at=(-1.28607111, -1.866913833, 1.829887111), height=2.297500174)).name("p35")
s35 = s30 | p35
p39 = (cylinder(0.576062771, axis="z", at=(1.315138752, -0.320266093, 1.305392359), height=1.708910908)).name("bore")
s39 = s35 - p39
p46 = ((diamond(1.387345791, 0.144) & sphere(0.863408781, at=(0.525544822, -0.402123878, 0.196748542)))).name("sheet")
s46 = s39 - p46
p47 = ((solid(z <= 0.3*sin(2.884285953*x)*cos(2.077834626*y)) & box(size=(2, 2, 2), at=(-0.738270529, -0.337894337, -1.627589924)))).name("p47")
s47 = s46 | p47
part(s47)
"#;
/// A wire a 50th of the size thick in balls.
const WIRE: &str = "
balls = sphere(1) | sphere(1, at=(1.2, 0, 0)) | sphere(1, at=(0, 1.2, 0))
part(balls | cylinder(0.001, height=2.6))
";
/// Balls that run through each other.
const BALLS: &str = "part(sphere(1) | sphere(1, at=(1, 0, 0)))";
/// A tube with walls a 50th of its radius thick.
const TUBE: &str = "part(extrude_edges([circle(1), circle(0.98)], \"z\", 2).name(\"a\"))";

/// A disk with a thin tube on it, whose bore ends where the tube meets the disk.
const DISK: &str = "
profile = polyline([(0, 0, 0), (8, 0, 0), (8, 0, 1), (1, 0, 1), (1, 0, 2.5), (0.995, 0, 2.5), (0.995, 0, 1), (0, 0, 1)])
part(revolve_edges(profile, \"z\").name(\"a\"))
";

/// A plate of some length and thickness with a bore near its round end.
fn plate(length: f64, thickness: f64) -> String {
    let around = format!("polyline([(0, 1, 0), (-{length}, 1, 0), (-{length}, -1, 0), (0, -1, 0)])");
    let outline = format!("chain([arc((0, -1, 0), (1, 0, 0), (0, 1, 0)), {around}])");
    format!("part(extrude_edges([{outline}, circle(0.98)], \"z\", {thickness}).name(\"a\"))")
}

/// Edges of a length, none of them shorter.
fn coarse(size: f64) -> MeshOptions {
    MeshOptions { least: Some(SizeRequest::Length(size)), ..sized(size) }
}

fn sized(size: f64) -> MeshOptions {
    MeshOptions { size: Some(SizeRequest::Length(size)), ..MeshOptions::default() }
}

fn meshed(text: &str, options: &MeshOptions) -> Meshed {
    mesh_part(&parse(text, &[]).unwrap(), options, &Run::new()).unwrap()
}

/// The first attempt of a rung with a change, and the one before it of the same rung.
fn first_with(made: &Meshed, rung: Tried, change: Change) -> [&Attempt; 2] {
    let list: Vec<&Attempt> = made.report.attempts.iter().filter(|a| a.rung == rung).collect();
    let at = list.iter().position(|a| a.change == change);
    let Some(at) = at.filter(|i| *i > 0) else { panic!("no {change} of {rung:?}: {:?}", made.report.attempts) };
    [list[at - 1], list[at]]
}

/// Whether the mesh is made of an attempt with a change, and all is well with it.
fn is_sound_by(made: &Meshed, change: Change) {
    let kept: Vec<Change> = made.report.attempts.iter().filter(|a| a.kept).map(|a| a.change).collect();
    assert!(kept.contains(&change), "{change}: {:?}", made.report.attempts);
    assert_eq!(made.report.shortfalls, Vec::new(), "{change}");
    assert!(made.report.check.as_ref().unwrap().certificate.is_sound(), "{change}");
}

/// Smaller cells find the corner before anything is remeshed: no attempt is spent on it.
#[test]
fn what_an_arrangement_lacks_is_found_before_there_is_an_attempt() {
    let Meshed { mesh, report, .. } = meshed(CORNER, &sized(0.4300553217149606));
    assert_eq!(report.shortfalls, Vec::new());
    assert_eq!(report.attempts.len(), 1, "{:?}", report.attempts);
    let corner = DVec3::new(1.244706221, -0.454348233, 0.450936905);
    assert!(mesh.nodes.iter().any(|p| p.distance(corner) < 1e-9), "no node at the corner");
}

/// The points that are known of the wire are cells apart: what is between them has to be found, too.
#[test]
fn a_wire_thinner_than_the_cells_comes_out_whole() {
    let Meshed { mesh, report, .. } = meshed(WIRE, &sized(0.1));
    assert_eq!(report.shortfalls, Vec::new());
    assert!(report.attempts.len() <= 2, "{:?}", report.attempts);
    let check = report.check.unwrap();
    assert!(check.certificate.is_sound() && (check.components, check.euler) == (1, 2), "{check}");
    let ends = mesh.nodes.iter().filter(|p| p.z.abs() > 1.3 - 1e-9);
    assert!(ends.clone().any(|p| p.z > 0.0) && ends.clone().any(|p| p.z < 0.0));
    assert!(ends.clone().all(|p| p.truncate().length() < 0.001 + 1e-9));
}

#[test]
fn functions_need_smaller_cells_where_triangles_cross_and_everywhere() {
    let made = meshed(FILLET, &sized(0.45));
    let [before, after] = first_with(&made, Tried::Arrange, Change::SmallerCellsHere);
    assert!(before.faults > 0 && after.faults == 0 && after.kept, "{before:?} {after:?}");
    is_sound_by(&made, Change::SmallerCellsHere);
    let made = meshed(NEEDLE, &sized(0.15));
    let [before, after] = first_with(&made, Tried::Arrange, Change::SmallerCells);
    assert!(!before.kept && after.kept, "{before:?} {after:?}");
    is_sound_by(&made, Change::SmallerCells);
}

#[test]
fn functions_need_shorter_edges_at_thin_walls_and_for_small_distances() {
    let made = meshed(SHELL, &sized(0.4));
    let [before, _] = first_with(&made, Tried::Arrange, Change::ShorterEdgesHere);
    assert!(!before.kept, "{before:?}");
    is_sound_by(&made, Change::ShorterEdgesHere);
    let made = meshed(BALLS, &MeshOptions { tolerance: Some(SizeRequest::Length(0.002)), ..sized(0.6) });
    let [before, _] = first_with(&made, Tried::Arrange, Change::ShorterEdges);
    assert!(!before.kept, "{before:?}");
    is_sound_by(&made, Change::ShorterEdges);
    assert!(made.report.check.unwrap().deviation.unwrap().max <= 0.002);
}

#[test]
fn faces_need_shorter_edges_for_small_distances_and_volumes() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("data/troubles/open_pole.step");
    let run = Run::new();
    let model = load_step(&path, &run).unwrap();
    let share = |s: f64| Some(SizeRequest::Share(s));
    let options =
        MeshOptions { size: share(0.25), tolerance: Some(SizeRequest::Share(0.002)), ..MeshOptions::default() };
    let made = mesh_step(model, &options, &run).unwrap();
    let [before, _] = first_with(&made, Tried::Bodies, Change::ShorterEdgesHere);
    assert!(!before.kept, "{before:?}");
    is_sound_by(&made, Change::ShorterEdgesHere);
    let distance = made.report.distance.unwrap();
    assert!(distance.to_surface <= distance.asked.unwrap(), "{distance:?}");

    let rod = "part(extrude_edges([circle(1)], \"z\", 2).name(\"a\"))";
    let made = meshed(rod, &MeshOptions { volume: Some(0.004), ..sized(0.6) });
    let [before, _] = first_with(&made, Tried::Bodies, Change::ShorterEdges);
    assert!(!before.kept, "{before:?}");
    is_sound_by(&made, Change::ShorterEdges);
    assert_relative_eq!(made.mesh.volume(), 2.0 * std::f64::consts::PI, epsilon = 0.0, max_relative = 0.004);
}

#[test]
fn faces_need_shorter_edges_where_their_first_triangles_cross() {
    let made = meshed(&plate(5.0, 1.0), &MeshOptions { least: Some(SizeRequest::Length(0.25)), ..sized(1.0) });
    let [before, after] = first_with(&made, Tried::Faces, Change::ShorterEdgesHere);
    assert!(before.faults > 0 && !before.kept && after.faults == 0 && after.kept, "{before:?} {after:?}");
    is_sound_by(&made, Change::ShorterEdgesHere);
}

#[test]
fn bodies_keep_triangles_or_faces_where_remeshed_ones_cross() {
    let made = meshed(DISK, &coarse(0.6));
    let [before, after] = first_with(&made, Tried::Bodies, Change::KeepHere);
    assert!(before.faults > 0 && !before.kept && after.faults == 0 && after.kept, "{before:?} {after:?}");
    is_sound_by(&made, Change::KeepHere);
    // The disk's is 64 pi, the tube's a 2000th of that.
    let share = made.mesh.volume() / (64.0 * std::f64::consts::PI);
    assert!(share > 0.98 && share < 1.0005, "{share}");
    let made = meshed(TUBE, &coarse(0.6));
    let [before, after] = first_with(&made, Tried::Bodies, Change::KeepParts);
    assert!(before.faults > 0 && !before.kept && after.faults == 0 && after.kept, "{before:?} {after:?}");
    is_sound_by(&made, Change::KeepParts);
    // Both walls keep the polygons of their circles.
    let sides = made.mesh.volume() / (2.0 * std::f64::consts::PI * (1.0 - 0.98 * 0.98));
    assert!(sides > 0.8 && sides < 1.0, "{sides}");
}

#[test]
fn a_face_that_crosses_others_from_the_start_is_left_out() {
    let made = meshed(&plate(40.0, 2.0), &coarse(0.5));
    let [before, after] = first_with(&made, Tried::Bodies, Change::OtherWay);
    assert!(before.faults > 0 && !before.kept && after.faults == 0 && after.kept, "{before:?} {after:?}");
    let [Fault::NoMesh { face, .. }] = &made.report.shortfalls[..] else { panic!("{:?}", made.report.shortfalls) };
    assert_eq!(face, "a.side1");
    assert_eq!(made.report.check.unwrap().self_intersections, 0);
}

/// What a budget counts is what attempts made.
#[test]
fn a_budget_counts_the_triangles_of_all_attempts() {
    for made in [meshed(TUBE, &coarse(0.6)), meshed(&plate(40.0, 2.0), &coarse(0.5)), meshed(SHELL, &sized(0.4))] {
        let spent: usize = made.report.attempts.iter().map(|a| a.triangles).sum();
        let budget = made.report.budget.unwrap();
        assert!(budget.spent == spent && !budget.ended && spent <= budget.most, "{budget:?}");
    }
}

/// A dented ball of radius 1 with a hollow whose dents lie beside those of the ball, nearest to its surface at one side.
fn hollow(radius: f64, wall: f64) -> TriMesh {
    let dented = |radius: f64, aside: f64| {
        let ring = |k: u32| {
            let (s, c) = (std::f64::consts::PI * f64::from(k) / 48.0).sin_cos();
            [if k.is_multiple_of(48) { 0.0 } else { radius * s }, -radius * c]
        };
        let mut ball = revolved(&(0..=48).map(ring).collect::<Vec<_>>(), 96, false);
        for p in &mut ball.nodes {
            p.z += 0.1 * (6.0 * p.x).sin() * (5.0 * p.y).cos();
            p.x += aside;
        }
        ball
    };
    let (TriMesh { mut nodes, mut triangles, .. }, inner) = (dented(1.0, 0.0), dented(radius, 1.0 - radius - wall));
    let first = nodes.len() as u32;
    triangles.extend(inner.triangles.iter().map(|[a, b, c]| [*a, *c, *b].map(|v| v + first)));
    nodes.extend(inner.nodes);
    TriMesh::new(nodes, triangles)
}

#[test]
fn soups_need_shorter_edges_in_thin_walls_and_triangles_of_their_own_in_thinner_ones() {
    let meshed = |input: &TriMesh| mesh_soup(input, &sized(0.5), &SoupOptions::default(), &Run::new()).unwrap();
    let thin = hollow(0.997, 0.003);
    let made = meshed(&thin);
    let [before, after] = first_with(&made, Tried::Soup, Change::ShorterEdgesHere);
    assert!(before.faults > 100 && after.faults == 0, "{before:?} {after:?}");
    is_sound_by(&made, Change::ShorterEdgesHere);
    assert_relative_eq!(made.mesh.volume(), thin.volume(), max_relative = 0.3);
    let made = meshed(&hollow(0.9, 3e-4));
    let [before, after] = first_with(&made, Tried::Soup, Change::KeepHere);
    assert!(before.faults > 0 && !before.kept && after.faults == 0 && after.kept, "{before:?} {after:?}");
    assert!(matches!(made.report.shortfalls[..], [Fault::Kept { .. }]), "{:?}", made.report.shortfalls);
    assert!(made.report.check.unwrap().certificate.is_sound());
}

#[test]
fn soups_need_other_edges_for_a_number_of_nodes() {
    let ring: Vec<[f64; 2]> = (0..24)
        .map(|k| {
            let (s, c) = (std::f64::consts::TAU * f64::from(k) / 24.0).sin_cos();
            [1.5 + 0.5 * c, 0.5 * s]
        })
        .collect();
    let soup = SoupOptions { nodes: Some(100), ..SoupOptions::default() };
    let made = mesh_soup(&revolved(&ring, 64, true), &MeshOptions::default(), &soup, &Run::new()).unwrap();
    let [before, _] = first_with(&made, Tried::Soup, Change::LongerEdges);
    assert!(!before.kept && before.triangles > 240, "{before:?}");
    is_sound_by(&made, Change::LongerEdges);
    let count = made.mesh.nodes.len();
    assert!((90..=110).contains(&count), "{count}");
}
