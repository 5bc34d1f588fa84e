"""Codes that compute on our meshes by the names of faces: bempp-cl, NGSolve, MFEM. Truths are solutions in closed form.

The bracket, which four codes compute, is in test_fill.py; what users read is in examples/python.
"""

import math
from pathlib import Path

import numpy as np
import pytest

import rvachev as rv

EXAMPLES = Path(__file__).parents[2] / "examples" / "python"
# In units of 4 pi epsilon times the side.
UNIT_CUBE = 0.66067815


@pytest.fixture
def examples(monkeypatch):
    monkeypatch.syspath_prepend(str(EXAMPLES))
    return __import__


@pytest.fixture(scope="module")
def surface():
    """A plate of 2 by 2 by 1 with a bore of radius a half along z."""
    part = rv.Part(rv.box(size=(2, 2, 1)).name("plate") - rv.cylinder(0.5).name("bore"))
    part.group("ends", "plate.z*")
    return part.mesh(size=0.2)


@pytest.fixture(scope="module")
def filled(surface):
    return surface.fill("gmsh")


def area(filled, face):
    a, b, c = (filled.points[filled.triangles[filled.faces[face], k]] for k in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2


# Of the solid; triangles lie in the bore, so theirs are a little off.
AREAS = {
    **{f"plate.{side}": 2.0 for side in ("xmin", "xmax", "ymin", "ymax")},
    **dict.fromkeys(("plate.zmin", "plate.zmax"), 4 - math.pi / 4),
    "bore": math.pi,
    "ends": 8 - math.pi / 2,
}


def test_bempp_finds_the_capacitance_of_the_unit_cube(examples):
    own, code = examples("capacitance"), examples("capacitance_bempp")
    found = own.series(rv.box(size=(1, 1, 1)), (0.5, 0.25, 0.125), code.capacitance)
    # Galerkin's energies come from below.
    off = 1 - found[:, 1] / UNIT_CUBE
    assert (off > 0).all() and (np.diff(off) < 0).all() and off[-1] < 2e-3
    assert own.limit(found, 4 / 3) == pytest.approx(UNIT_CUBE, abs=2e-4)
    # The same elements as our own code, which integrates in another way.
    other = own.capacitance(rv.mesh(rv.box(size=(1, 1, 1)), size=0.25))
    assert found[1, 1] == pytest.approx(other, rel=1e-3)


def test_bempp_finds_the_capacitance_of_a_ball(examples):
    own, code = examples("capacitance"), examples("capacitance_bempp")
    found = own.series(rv.sphere(1), (0.8, 0.4), code.capacitance)
    assert (np.diff(1 - found[:, 1]) < 0).all() and found[-1, 1] == pytest.approx(1, abs=8e-3)
    assert own.limit(found, 2) == pytest.approx(1, abs=5e-4)


def test_bempp_takes_faces_for_domains(examples):
    import bempp_cl.api as bem

    cube = rv.mesh(rv.box(size=(1, 1, 1)).name("cube"), size=0.25)
    grid = examples("capacitance_bempp").grid_of(cube)
    for i, face in enumerate(cube.face_names):
        space = bem.function_space(grid, "DP", 0, segments=[i + 1])
        assert space.global_dof_count == len(cube.faces[face])
        # A side of the cube, and its normal points out of it.
        assert grid.volumes[grid.domain_indices == i + 1].sum() == pytest.approx(1, rel=1e-12)
        axis, sign = "xyz".index(face[-4]), 1 if face.endswith("max") else -1
        assert grid.normals[cube.faces[face], axis] == pytest.approx(sign, abs=1e-12)


def test_ngsolve_solves_poisson_between_faces_by_name(filled):
    import ngsolve as ng

    mesh = ng.Mesh(filled.to_netgen())
    assert set(mesh.GetBoundaries()) == {"plate.xmin", "plate.xmax", "plate.ymin", "plate.ymax", "ends", "bore"}
    assert ng.Integrate(1, mesh) == pytest.approx(filled.volumes.sum(), rel=1e-12)
    sizes = {name: ng.Integrate(1, mesh, definedon=mesh.Boundaries(name)) for name in ("plate.xmin", "ends", "bore")}
    assert sizes["plate.xmin"] == pytest.approx(2, rel=1e-12)
    assert sizes["ends"] == pytest.approx(8 - math.pi / 2, rel=1e-2) and sizes["bore"] == pytest.approx(math.pi, rel=1e-2)

    # A polynomial of third degree is in the space of third order, so only rounding is left: known on the bore and one side, while its
    # flux is known on all others.
    x, y, z = ng.x, ng.y, ng.z
    truth = x**3 - 2 * x * y * z + y**2 + z
    slope = ng.CoefficientFunction((3 * x**2 - 2 * y * z, 2 * y - 2 * x * z, 1 - 2 * x * y))
    space = ng.H1(mesh, order=3, dirichlet="bore|plate.xmin")
    u, v = space.TnT()
    stiffness = ng.BilinearForm(ng.grad(u) * ng.grad(v) * ng.dx).Assemble()
    normal = ng.specialcf.normal(3)
    flux = ng.LinearForm(-(6 * x + 2) * v * ng.dx + slope * normal * v * ng.ds("plate.xmax|plate.y...|ends")).Assemble()
    found = ng.GridFunction(space)
    found.Set(truth, definedon=mesh.Boundaries("bore|plate.xmin"))
    rest = (flux.vec - stiffness.mat * found.vec).Evaluate()
    found.vec.data += stiffness.mat.Inverse(space.FreeDofs(), "sparsecholesky") * rest
    assert math.sqrt(ng.Integrate((found - truth) ** 2, mesh)) < 1e-9


def measured_by_mfem(mesh, attribute, on_boundary):
    """Length or area of what has an attribute: the sum of a linear form of one."""
    import mfem.ser as mfem

    # Named, as a space does not keep what it is made of.
    elements = mfem.H1_FECollection(1, 3)
    space = mfem.FiniteElementSpace(mesh, elements)
    one = mfem.ConstantCoefficient(1.0)
    form = mfem.LinearForm(space)
    most = (mesh.bdr_attributes if on_boundary else mesh.attributes).Max()
    marker = mfem.intArray([int(k + 1 == attribute) for k in range(most)])
    if on_boundary:
        form.AddBoundaryIntegrator(mfem.BoundaryLFIntegrator(one), marker)
    else:
        form.AddDomainIntegrator(mfem.DomainLFIntegrator(one), marker)
    form.Assemble()
    return form.Sum()


def test_mfem_reads_the_filled_mesh_with_boundary_attributes_by_name(filled, tmp_path):
    import mfem.ser as mfem

    filled.write(tmp_path / "plate.msh")
    mesh = mfem.Mesh(str(tmp_path / "plate.msh"))
    assert (mesh.GetNE(), mesh.GetNBE(), mesh.GetNV()) == (len(filled.tets), len(filled.triangles), len(filled.points))
    assert set(mesh.bdr_attribute_sets.GetAttributeSetNames()) == set(filled.face_names)
    found = np.array([mesh.GetBdrAttribute(i) for i in range(mesh.GetNBE())])
    for face in filled.face_names:
        (attribute,) = mesh.bdr_attribute_sets.GetAttributeSet(face).ToList()
        assert np.array_equal(np.flatnonzero(found == attribute), filled.faces[face])
        theirs = measured_by_mfem(mesh, attribute, True)
        assert theirs == pytest.approx(area(filled, face), rel=1e-12) and theirs == pytest.approx(AREAS[face], rel=1e-2)
    assert set(mesh.attribute_sets.GetAttributeSetNames()) == {"solid"}
    assert sum(mesh.GetElementVolume(i) for i in range(mesh.GetNE())) == pytest.approx(filled.volumes.sum(), rel=1e-12)


def test_mfem_reads_the_surface_with_faces_and_edges_by_name(surface, tmp_path):
    import mfem.ser as mfem

    surface.write(tmp_path / "plate.msh", groups="user", msh_version="2.2")
    mesh = mfem.Mesh(str(tmp_path / "plate.msh"))
    assert (mesh.Dimension(), mesh.SpaceDimension(), mesh.GetNE()) == (2, 3, len(surface.triangles))
    assert mesh.GetNBE() == len(surface.feature_edges)
    faces = {"ends", "bore", "plate.xmin", "plate.xmax", "plate.ymin", "plate.ymax"}
    assert set(mesh.attribute_sets.GetAttributeSetNames()) == faces
    for face in faces:
        (attribute,) = mesh.attribute_sets.GetAttributeSet(face).ToList()
        assert measured_by_mfem(mesh, attribute, False) == pytest.approx(AREAS[face], rel=1e-2)
    # Curves lie between faces, and are called after both.
    for curve, truth in [("plate.zmax|bore", math.pi), ("plate.xmax|plate.ymin", 1), ("plate.xmin|plate.zmax", 2)]:
        (attribute,) = mesh.bdr_attribute_sets.GetAttributeSet(curve).ToList()
        assert measured_by_mfem(mesh, attribute, True) == pytest.approx(truth, rel=1e-2)
