"""Prisms, units, the page of a mesh, and meshes as those of gmsh and Netgen, of a block of 2 by 2 by 1."""

import pickle
import zipfile

import numpy as np
import pytest

import rvachev as rv


@pytest.fixture(scope="module")
def mesh():
    part = rv.Part(rv.box(lo=(0, 0, 0), hi=(2, 2, 1)).name("b"), units="mm")
    part.group("held", "b.x*")
    return part.mesh(size=0.4)


def signed(points, cells):
    """Volumes by three tetrahedra of each prism."""
    p = points[cells]
    tets = [p[:, list(k)] for k in ((0, 1, 2, 3), (1, 2, 3, 4), (2, 3, 4, 5))]
    return sum(np.abs(np.linalg.det(t[:, 1:] - t[:, :1])) / 6 for t in tets)


def volume(points, triangles):
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6


def test_a_face_sweeps_prisms(mesh, tmp_path):
    prisms = mesh.sweep("b.zmax", along=(0, 0, 3), layers=4)
    assert prisms.points.shape[1] == 3 and prisms.cells.shape == (4 * len(mesh.faces["b.zmax"]), 6)
    assert prisms.cells.dtype == np.int64 and prisms.labels.dtype == np.uint32
    assert prisms.volume == pytest.approx(12) and signed(prisms.points, prisms.cells).sum() == pytest.approx(12)
    assert prisms.names[:2] == ["b.zmax", "opposite"] and set(prisms.names[2:]) == {"b.xmin", "b.xmax", "b.ymin", "b.ymax"}
    roof = prisms.sides[prisms.faces["opposite"]]
    assert (roof[:, 2] == roof[:, 3]).all() and (prisms.points[roof][:, :, 2] == 4).all()
    wall = prisms.sides[prisms.faces["b.xmin"]]
    assert (wall[:, 2] != wall[:, 3]).all() and np.abs(prisms.points[wall][:, :, 0]).max() < 1e-12
    # Points of the face are those of the mesh.
    face = prisms.points[np.unique(prisms.sides[prisms.faces["b.zmax"]])]
    assert {p.tobytes() for p in face} == {p.tobytes() for p in mesh.points[mesh.nodes("b.zmax")]}
    with pytest.warns(rv.Told, match="b.zmax is written as b_zmax"):
        prisms.write(tmp_path / "a.vtu", tmp_path / "a.msh", tmp_path / "a.inp")
    assert all((tmp_path / f"a.{e}").stat().st_size > 1000 for e in ("vtu", "msh", "inp"))
    other = prisms.to_meshio()
    assert [(c.type, len(c.data)) for c in other.cells] == [
        ("wedge", len(prisms.cells)),
        ("triangle", 2 * len(mesh.faces["b.zmax"])),
        ("quad", len(prisms.sides) - 2 * len(mesh.faces["b.zmax"])),
    ]
    for name, sides in prisms.faces.items():
        found = [block.data[at] for block, at in zip(other.cells, other.cell_sets[name])]
        assert set(np.concatenate([f.ravel() for f in found])) == set(prisms.sides[sides].ravel())


def test_prisms_between_faces_that_match():
    # A wedge with legs of 2 and a height of 3: floor and roof are one triangle each.
    points = np.array([(x, y, z) for z in (0, 3) for x, y in ((0, 0), (2, 0), (0, 2))], float)
    walls = [t for a, b in ((0, 1), (1, 2), (2, 0)) for t in ((a, b, b + 3), (a, b + 3, a + 3))]
    wedge = rv.remesh(points, np.array([(0, 2, 1), (3, 4, 5), *walls]), size=9.0)
    height = wedge.points[wedge.triangles][:, :, 2]
    low, high = (wedge.face_names[wedge.labels[np.argmin(np.abs(height - z).max(axis=1))]] for z in (0, 3))
    prisms = wedge.sweep(low, to=high, layers=3)
    assert prisms.names[:2] == [low, high] and len(prisms.names) == 5
    assert len(prisms.cells) == 3 * len(wedge.faces[low])
    assert prisms.volume == pytest.approx(6) and signed(prisms.points, prisms.cells).sum() == pytest.approx(6)
    assert np.unique(prisms.points[:, 2]) == pytest.approx([0, 1, 2, 3])


def test_what_cannot_be_swept(mesh):
    with pytest.raises(rv.InputError, match="one of the two"):
        mesh.sweep("b.zmax")
    with pytest.raises(rv.InputError, match="one of the two"):
        mesh.sweep("b.zmax", along=(0, 0, 1), to="b.zmin")
    with pytest.raises(rv.InputError, match="layer"):
        mesh.sweep("b.zmax", along=(0, 0, 1), layers=0)
    with pytest.raises(rv.InputError, match="nothing"):
        mesh.sweep("nothing", along=(0, 0, 1))
    with pytest.raises(rv.InputError):
        mesh.sweep("b.zmax", along=(1, 0, 0))
    with pytest.raises(rv.InputError):
        mesh.sweep("b.zmax", to="b.xmin")
    with pytest.raises(TypeError):
        mesh.sweep("b.zmax", along=(0, 1))
    with pytest.raises(rv.Error, match="vtu, msh or inp"):
        mesh.sweep("b.zmax", along=(0, 0, 1)).write("a.stl")


def test_units_can_be_had_and_said(mesh, tmp_path):
    assert mesh.units == "mm" and rv.heal(*mesh).units is None
    mesh.write(tmp_path / "a.3mf")
    assert b'unit="millimeter"' in zipfile.ZipFile(tmp_path / "a.3mf").read("3D/3dmodel.model")
    (tmp_path / "p.py").write_text("units(\"cm\")\npart(sphere(1))\n")
    part = rv.Part.load(tmp_path / "p.py")
    assert part.units == "cm"
    part.units = "in"
    assert part.units == "in" and pickle.loads(pickle.dumps(part)).units == "in"
    assert part.mesh(size=0.5).units == "in"
    with pytest.raises(rv.InputError, match="furlong"):
        part.units = "furlong"
    part.units = None
    assert part.units is None and pickle.loads(pickle.dumps(part)).units is None


def test_parts_are_written(tmp_path):
    ball = rv.Part(rv.sphere(1) & rv.half_space((0, 0, 1), (0, 0, 0.5)), units="cm")
    ball.write(tmp_path / "a.vm", tmp_path / "a.3mf")
    at = np.array([(0, 0, 0.4), (0, 0, 0.6), (0, 0.9, 0), (0, 1.1, 0)])
    for name in ("a.vm", "a.3mf"):
        again = rv.Part.load(tmp_path / name)
        assert (np.asarray(rv.evaluate(again, at)) > 0).tolist() == [True, False, True, False]
    assert rv.Part.load(tmp_path / "a.3mf").units == "cm"
    with pytest.raises(rv.InputError, match="edges"):
        ball.write(tmp_path / "a.step")
    square = rv.polyline([(0, 0), (1, 0), (1, 1), (0, 1)], closed=True)
    bar = rv.Part(rv.extrude_edges(square, direction="z", distance=2))
    bar.write(tmp_path / "b.step")
    assert volume(*rv.mesh(tmp_path / "b.step", size=0.5)) == pytest.approx(2)
    with pytest.raises(rv.InputError):
        bar.write(tmp_path / "b.vm")
    with pytest.raises(rv.Error, match="docx"):
        ball.write(tmp_path / "a.docx")


def test_a_notebook_shows_the_page(mesh):
    page = mesh.to_html("<script>alert(1)</script>")
    assert page.lower().startswith("<!doctype html>") and "<script>alert(1)</script>" not in page
    frame = mesh._repr_html_()
    assert frame.startswith("<iframe sandbox=\"allow-scripts\"") and frame.endswith("\"></iframe>")
    # Nothing ends the attribute before the page does.
    assert frame.count('"') == 6 and frame.count("<iframe") == 1
    assert rv.heal(*mesh).to_html() and pickle.loads(pickle.dumps(mesh)).to_html()


def test_netgen_gets_the_surface_and_its_names(mesh):
    other = mesh.to_netgen()
    points = np.array([p.p for p in other.Points()])
    triangles = np.array([[v.nr - 1 for v in e.vertices] for e in other.Elements2D()])
    assert points.tobytes() == mesh.points.tobytes() and (triangles == mesh.triangles).all()
    assert [other.GetBCName(i) for i in range(len(mesh.face_names))] == mesh.face_names
    assert [e.index - 1 for e in other.Elements2D()] == mesh.labels.tolist()
    other.GenerateVolumeMesh()
    assert len(other.Elements3D()) > 0


def test_gmsh_gets_the_surface_and_its_names(mesh):
    import gmsh

    name = mesh.to_gmsh("block")
    try:
        assert name == gmsh.model.getCurrent() == "block"
        at = gmsh.model.mesh.getNodes()[1].reshape(-1, 3)
        assert len(at) == len(mesh.points)
        groups = {gmsh.model.getPhysicalName(d, t): gmsh.model.getEntitiesForPhysicalGroup(d, t) for d, t in gmsh.model.getPhysicalGroups(2)}
        assert set(groups) == {*mesh.face_names, "held"} and len(groups["held"]) == 2
        for face, list_ in mesh.faces.items():
            found = gmsh.model.mesh.getElementsByType(2, int(groups[face][0]))[1].reshape(-1, 3) - 1
            assert (found == mesh.triangles[list_]).all(), face
        gmsh.model.mesh.generate(3)
        tets = gmsh.model.mesh.getElementsByType(4)[1].reshape(-1, 4)
        tags, at, _ = gmsh.model.mesh.getNodes()
        where = np.zeros((int(tags.max()) + 1, 3))
        where[tags.astype(int)] = at.reshape(-1, 3)
        p = where[tets.astype(int)]
        assert np.abs(np.linalg.det(p[:, 1:] - p[:, :1])).sum() / 6 == pytest.approx(4)
    finally:
        gmsh.finalize()


def bricks(points, cells):
    """Volumes of hexahedra, by six tetrahedra of each around the diagonal from corner 0 to corner 6."""
    p = points[cells]
    around = (1, 2, 3, 7, 4, 5)
    tets = [p[:, [0, a, b, 6]] for a, b in zip(around, (*around[1:], around[0]))]
    return sum(np.abs(np.linalg.det(t[:, 1:] - t[:, :1])) / 6 for t in tets)


def test_pairs_of_prisms_become_hexahedra(tmp_path):
    # A plate of 8 by 3 squares, each of two triangles.
    points = np.array([(x, y, 0) for x in range(9) for y in range(4)], float)
    corners = [(4 * i + j, 4 * i + j + 4, 4 * i + j + 5, 4 * i + j + 1) for i in range(8) for j in range(3)]
    plate = rv.heal(points, np.array([t for a, b, c, d in corners for t in ((a, b, c), (a, c, d))]), force=True, max_hole=0)
    prisms = plate.sweep(plate.face_names[0], along=(0, 0, 3), layers=2)
    made = prisms.hexahedra()
    assert made.cells.shape == (48, 8) and made.cells.dtype == np.int64 and made.prisms.shape == (0, 6)
    assert bricks(made.points, made.cells) == pytest.approx(np.full(48, 1.5)) and made.volume == pytest.approx(72)
    assert made.points.tobytes() == prisms.points.tobytes() and made.names == prisms.names
    areas = {name: len(list_) for name, list_ in made.faces.items()}
    assert areas == {prisms.names[0]: 24, "opposite": 24, "side": 2 * 22} and len(made.labels) == len(made.sides) == 92
    assert {c.type: len(c.data) for c in made.to_meshio().cells} == {"hexahedron": 48, "wedge": 0, "triangle": 0, "quad": 92}
    made.write(tmp_path / "a.vtu", tmp_path / "a.msh", tmp_path / "a.inp")
    assert (tmp_path / "a.inp").read_text().count("C3D8") == 1
    with pytest.raises(rv.InputError, match="off"):
        prisms.hexahedra(off=float("nan"))
    with pytest.raises(rv.Error, match="vtu, msh or inp"):
        made.write(tmp_path / "a.stl")


def test_what_finds_no_partner_stays_a_prism(mesh, tmp_path):
    prisms = mesh.sweep("b.zmax", along=(0, 0, 3), layers=4)
    made = prisms.hexahedra()
    assert 0 < len(made.prisms) < len(made.cells) and 2 * len(made.cells) + len(made.prisms) == len(prisms.cells)
    both = bricks(made.points, made.cells).sum() + signed(made.points, made.prisms).sum()
    assert both == pytest.approx(12) and made.volume == pytest.approx(12)
    import meshio

    with pytest.warns(rv.Told, match="b.zmax is written as b_zmax"):
        made.write(tmp_path / "a.inp", tmp_path / "a.msh")
    again = meshio.read(tmp_path / "a.msh")
    found = {c.type: len(c.data) for c in again.cells if c.type in ("hexahedron", "wedge")}
    assert found == {"hexahedron": len(made.cells), "wedge": len(made.prisms)}
