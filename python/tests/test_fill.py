"""Tetrahedra inside meshes: volume, facets, names, cavities, files; and codes that compute on them agree."""

import math
import sys
from pathlib import Path

import meshio
import numpy as np
import pytest

import rvachev as rv
from rvachev._fill import boundary, volumes

EXAMPLES = Path(__file__).parents[2] / "examples" / "python"
ALL = ["gmsh", "tetgen", "netgen", "pytetwild"]


def volume(points, triangles):
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return np.einsum("ij,ij->", a, np.cross(b, c)) / 6


def area(filled, group):
    a, b, c = (filled.points[filled.triangles[filled.groups[group], k]] for k in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2


@pytest.fixture(scope="module")
def mesh():
    part = rv.Part(rv.box(size=(2, 2, 1)).name("body") - rv.cylinder(0.5).name("bore"), units="mm")
    part.group("clamped", "body.xmin")
    part.group("loaded", "bore", "body.zmax")
    return part.mesh(size=0.3)


@pytest.mark.parametrize("by", ALL)
def test_the_solid_is_filled_and_names_stay(mesh, by):
    filled = mesh.fill(by)
    assert filled.by == by and filled.keeps_surface == (by != "pytetwild") and filled.points.dtype == np.float64 and filled.tets.dtype == np.int64
    assert (filled.volumes > 0).all()
    # Facets of one tetrahedron only are the surface, seen from outside.
    assert np.array_equal(np.unique(np.sort(boundary(filled.tets)), axis=0), np.unique(np.sort(filled.triangles), axis=0))
    assert filled.volumes.sum() == pytest.approx(volume(filled.points, filled.triangles), rel=1e-9)
    if by != "pytetwild":
        n = len(mesh.points)
        assert filled.points[:n].tobytes() == mesh.points.tobytes()
        assert np.array_equal(filled.triangles, mesh.triangles) and np.array_equal(filled.labels, mesh.labels)
        assert {k: v.tolist() for k, v in filled.groups.items()} == {k: v.tolist() for k, v in mesh.groups.items()}
        assert np.array_equal(filled.nodes("loaded"), mesh.nodes("loaded"))
        assert filled.volumes.sum() == pytest.approx(volume(*mesh), rel=1e-12)
    else:
        # It moves the surface by its tolerance, a thousandth of the diagonal.
        assert filled.volumes.sum() == pytest.approx(4 - math.pi * 0.25, rel=2e-2)
    near = 1e-2 if by == "pytetwild" else 1e-12
    assert filled.points[filled.nodes("clamped")][:, 0] == pytest.approx(-1, abs=near)
    radius = np.hypot(*filled.points[filled.nodes("bor?")][:, :2].T)
    assert radius == pytest.approx(0.5, abs=near)
    assert area(filled, "clamped") == pytest.approx(2, rel=1e-2)
    assert area(filled, "loaded") == pytest.approx(math.pi + 4 - math.pi / 4, rel=2e-2)
    with pytest.raises(KeyError):
        filled.nodes("nothing")


def test_sizes_are_heeded(mesh):
    coarse, fine = mesh.fill(), mesh.fill(size=0.1)
    assert len(fine.tets) > 1.5 * len(coarse.tets)
    assert np.array_equal(fine.triangles, mesh.triangles)


@pytest.mark.parametrize("by", ALL)
def test_cavities_stay_empty_and_solids_apart(by):
    # A ball with a cavity in which another ball floats, and one more beside it.
    shell = (rv.sphere(1) - rv.sphere(0.7)).name("shell")
    made = rv.Part(rv.union(shell, rv.sphere(0.3).name("core"), rv.sphere(0.5, at=(2, 0, 0)).name("far"))).mesh(size=0.4)
    filled = made.fill(by)
    truth = volume(*made)
    assert filled.volumes.sum() == pytest.approx(truth, rel=1e-2 if by == "pytetwild" else 1e-9)
    middle = np.linalg.norm(filled.points[filled.tets].mean(axis=1), axis=1)
    assert not ((middle > 0.32) & (middle < 0.62)).any()


def test_files_have_the_names(mesh, tmp_path):
    filled = mesh.fill()
    filled.write(tmp_path / "a.inp", tmp_path / "a.msh", tmp_path / "a.vtu")
    inp, msh, vtu = (meshio.read(tmp_path / f"a.{e}") for e in ("inp", "msh", "vtu"))
    for read in (inp, msh, vtu):
        assert np.array_equal(read.points, filled.points)
        assert np.array_equal(read.cells_dict["tetra"], filled.tets)
    # Solvers would take triangles for elements: their files have tetrahedra, and names of nodes.
    assert set(inp.cells_dict) == {"tetra"}
    assert np.array_equal(np.sort(inp.point_sets["loaded"]), filled.nodes("loaded"))
    names = {number: name for name, (number, dimension) in msh.field_data.items() if dimension == 2}
    found = [names[i] for i in msh.cell_data_dict["gmsh:physical"]["triangle"]]
    assert found == [filled.face_names[i] for i in filled.labels]
    on = vtu.cell_data_dict["clamped"]["triangle"].astype(bool)
    assert np.array_equal(np.flatnonzero(on), filled.groups["clamped"])
    sets = filled.to_meshio().cell_sets
    assert np.array_equal(sets["loaded"][1], filled.groups["loaded"]) and len(sets["loaded"][0]) == 0


def test_what_cannot_be_filled(mesh, monkeypatch):
    with pytest.raises(rv.InputError, match="no generator"):
        mesh.fill("nothing")
    with pytest.raises(rv.InputError, match="size"):
        mesh.fill(size=-1)
    monkeypatch.setitem(sys.modules, "netgen", None)
    with pytest.raises(rv.InputError, match="pip install netgen-mesher") as caught:
        mesh.fill("netgen")
    assert caught.value.help == "pip install netgen-mesher"


def test_gmsh_in_use_stays_as_it_was(mesh):
    import gmsh

    gmsh.initialize(interruptible=False)
    try:
        gmsh.model.add("mine")
        gmsh.option.setNumber("Mesh.MeshSizeMax", 0.7)
        filled = mesh.fill(size=0.4)
        assert len(filled.tets) > 0
        assert gmsh.isInitialized() and gmsh.model.getCurrent() == "mine" and "rvachev.fill" not in gmsh.model.list()
        assert gmsh.option.getNumber("Mesh.MeshSizeMax") == 0.7
    finally:
        gmsh.finalize()
    assert np.array_equal(mesh.fill(size=0.4).tets, filled.tets)


# ------------------------------------------------------------------------------------------------------- codes that compute


@pytest.fixture
def examples(monkeypatch):
    monkeypatch.syspath_prepend(str(EXAMPLES))
    return __import__


def test_four_codes_agree_on_a_bracket(examples):
    model = examples("bracket_model").bracket(size=5.0)
    assert (model.points[model.clamped][:, 0] == 0).all() and len(model.clamped) > 20
    assert model.forces.sum(axis=0) == pytest.approx([0, 300, -1000])
    found = {code: examples(f"bracket_{code}").displacements(model) for code in ("skfem", "ccx", "mystran", "ngsolve")}
    most = np.abs(found["skfem"]).max()
    # A cantilever of the arm's section, 30 mm long, bends by F L^3 / (3 E I) = 0.042 mm; coarse linear elements are stiffer.
    assert 0.005 < most < 0.06
    # The same elements and the same mesh: six digits, which is what the solvers write.
    assert np.abs(found["ccx"] - found["skfem"]).max() < 1e-6 * most
    assert np.abs(found["mystran"] - found["skfem"]).max() < 1e-6 * most
    # NGSolve hands its numbers over as they are: only rounding is left.
    assert np.abs(found["ngsolve"] - found["skfem"]).max() < 1e-9 * most
    # And that is an equilibrium: the force moves the pin down and aside.
    pin = found["skfem"][model.forces[:, 2] < 0].mean(axis=0)
    assert pin[2] < 0 < pin[1]


def test_capacitance_of_the_unit_cube_and_a_ball(examples):
    code = examples("capacitance")
    truth = 0.66067815
    found = code.series(rv.box(size=(1, 1, 1)), (0.5, 0.25, 0.125))
    # Galerkin's energies come from below.
    off = 1 - found[:, 1] / truth
    assert (off > 0).all() and (np.diff(off) < 0).all() and off[-1] < 3e-3
    assert code.limit(found, 4 / 3) == pytest.approx(truth, abs=3e-4)
    found = code.series(rv.sphere(1), (0.8, 0.4))
    assert (np.diff(1 - found[:, 1]) < 0).all() and found[-1, 1] == pytest.approx(1, abs=8e-3)
    assert code.limit(found, 2) == pytest.approx(1, abs=5e-4)


def test_the_examples_run(examples, monkeypatch, capsys):
    import runpy

    for code in ("skfem", "ccx", "mystran", "ngsolve"):
        runpy.run_path(str(EXAMPLES / f"bracket_{code}.py"), run_name="__main__")
    *told, quadratic = [float(line.rsplit(" ", 2)[1]) for line in capsys.readouterr().out.splitlines()]
    assert len(told) == 4 and told[0] > 0
    assert told == pytest.approx([told[0]] * 4, rel=2e-6)
    # Elements of second order are softer, and nearer to the beam's 0.042 mm with what the wall gives.
    assert told[0] < quadratic and quadratic == pytest.approx(0.046, rel=0.05)


def test_volumes_have_signs():
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    assert volumes(points, np.array([[0, 1, 2, 3], [0, 2, 1, 3]])) == pytest.approx([1 / 6, -1 / 6])
