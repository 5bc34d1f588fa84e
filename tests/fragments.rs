//! What every gate hands over: a model with a fragment for each of its entities, and the mesh read out of them, which is the
//! mesh itself.

use rvachev::implicit::part::parse;
use rvachev::mesh::{MeshView, TriMesh};
use rvachev::pipeline::{
    MeshOptions, Meshed, Method, PartKind, SizeRequest, SoupOptions, build, load_part, mesh_part, mesh_soup, mesh_step,
    part_kind,
};
use rvachev::{Run, io};

const TREE: &str = "part(box((2, 2, 2)) - cylinder(0.5, \"z\"))\nmesh(size=0.2)\n";
const EDGES: &str =
    "part(revolve_edges(polyline([(1, 0, 0), (2, 0, 0), (2, 0, 1), (1, 0, 1)], closed=True), \"z\").name(\"ring\"))\n";

/// A ball of triangles with a bore of functions.
fn joined(ball: &TriMesh, options: &MeshOptions, run: &Run) -> Meshed {
    let folder = tempfile::tempdir().unwrap();
    io::write(&folder.path().join("ball.off"), ball, &io::WriteOptions::default(), run).unwrap();
    let path = folder.path().join("part.py");
    std::fs::write(&path, "part(mesh('ball.off').name('ball') - cylinder(0.4, 'z').name('bore'))\n").unwrap();
    let part = load_part(&path, &[]).unwrap();
    assert_eq!(part_kind(&part), PartKind::JoinedFunctions);
    mesh_part(&part, options, run).unwrap()
}

fn by_every_gate() -> [(&'static str, Meshed); 5] {
    let run = Run::new();
    let (tree, edges) = (parse(TREE, &[]).unwrap(), parse(EDGES, &[]).unwrap());
    let options = MeshOptions { size: Some(SizeRequest::Length(0.25)), ..MeshOptions::default() };
    let functions = mesh_part(&tree, &options, &run).unwrap();
    let cubes = MeshOptions { method: Method::MarchingCubes, ..options.clone() };
    let brep = build(&edges, &run).unwrap().unwrap();
    // only the places of the triangles are handed on: the gate finds the faces itself
    let soup = TriMesh::new(functions.mesh.nodes.clone(), functions.mesh.triangles.clone());
    let ball = mesh_part(&parse("part(sphere(1))\n", &[]).unwrap(), &options, &run).unwrap().mesh;
    [
        ("set operations", joined(&ball, &options, &run)),
        ("marching cubes", mesh_part(&tree, &cubes, &run).unwrap()),
        ("faces between edges", mesh_step(brep.into(), &options, &run).unwrap()),
        ("triangles", mesh_soup(&soup, &options, &SoupOptions::default(), &run).unwrap()),
        ("functions", functions),
    ]
}

#[test]
fn the_mesh_of_every_gate_is_read_out_of_its_fragments() {
    for (gate, made) in by_every_gate() {
        let cut = made.model().unwrap();
        let faces = made.mesh.faces.len();
        assert_eq!(cut.model.check(), [], "{gate}");
        assert!(cut.model.faces.len() >= faces && cut.fragments.counts()[2] == cut.model.faces.len(), "{gate}");
        let view = made.merged().unwrap();
        assert_eq!(view.merged().node_count(), made.mesh.nodes.len(), "{gate}");
        assert_eq!(TriMesh::from_view(&view), made.mesh, "{gate}");
    }
}

#[test]
fn files_written_from_fragments_are_those_of_the_mesh() {
    let folder = tempfile::tempdir().unwrap();
    for (gate, made) in by_every_gate() {
        let view = made.merged().unwrap();
        for ending in ["stl", "ply", "off", "obj", "vtu", "msh"] {
            let paths = ["view", "arrays"].map(|name| folder.path().join(format!("{name}.{ending}")));
            let meshes: [&dyn MeshView; 2] = [&view, &made.mesh];
            for (path, mesh) in paths.iter().zip(meshes) {
                io::write(path, mesh, &io::WriteOptions::default(), &Run::new()).unwrap();
            }
            let [a, b] = paths.map(|path| std::fs::read(path).unwrap());
            assert!(a == b, "{gate}, {ending}");
        }
    }
}
