"""Figures that users may count on: what a traced function is, how an untraced one is asked, what is found in it, angles of tetrahedra."""

import numpy as np
import pytest

import rvachev as rv
from rvachev import box, cylinder, solid

R = 0.4
PART = f"""
bores = union(cylinder({R}, axis="x"), cylinder({R}, axis="z")).name("bores")
dent = solid(0.7**2 - x**2 - y**2 - (z - 1.4)**2).name("dent")
part(box(size=(2, 2, 2)).name("body") - bores - dent)
"""


def test_a_traced_function_is_what_the_part_file_has(tmp_path):
    path = tmp_path / "part.py"
    path.write_text(PART)

    bores = rv.union(cylinder(R, axis=a) for a in "xz").name("bores")
    dent = solid(lambda x, y, z: 0.7**2 - x**2 - y**2 - (z - 1.4) ** 2).name("dent")
    traced = rv.Part(box(size=(2, 2, 2)).name("body") - bores - dent)
    one, two = rv.mesh(path, size="4%", threads=1), traced.mesh(size="4%", threads=1)
    assert one.points.tobytes() == two.points.tobytes() and one.triangles.tobytes() == two.triangles.tobytes()


def test_smooth_untraced_functions_are_asked_for_many_points_at_once():
    asked = []

    def ball(p):
        asked.append(len(p))
        return 1 - np.linalg.norm(p, axis=1)

    made = rv.Part(rv.field(ball, lipschitz=1, bounds=((-2, -2, -2), (2, 2, 2)))).mesh(size="4%")
    assert len(made.triangles) > 1000 and np.mean(asked) >= 512


def test_edges_of_an_untraced_function_are_found():
    def cube(p):
        body = 1 - np.abs(p).max(axis=1)
        along_x, along_z = np.hypot(p[:, 1], p[:, 2]) - R, np.hypot(p[:, 0], p[:, 1]) - R
        return np.minimum(body, np.minimum(along_x, along_z))

    made = rv.Part(rv.field(cube, lipschitz=1, bounds=((-1.5, -1.5, -1.5), (1.5, 1.5, 1.5)))).mesh(size="4%")
    known = rv.Part(box(size=(2, 2, 2)) - cylinder(R, axis="x") - cylinder(R, axis="z"))
    features = rv.check(made, against=known)["features"]
    assert features["recall"] >= 0.99 and features["corners_true"] == features["corners_found"] == 8


def least_dihedral(points, tets):
    least = np.full(len(tets), np.inf)
    for i, j, k, m in ((0, 1, 2, 3), (0, 2, 1, 3), (0, 3, 1, 2), (1, 2, 0, 3), (1, 3, 0, 2), (2, 3, 0, 1)):
        a, b, c, d = (points[tets[:, n]] for n in (i, j, k, m))
        edge = (b - a) / np.linalg.norm(b - a, axis=1)[:, None]
        sides = [v - np.einsum("ij,ij->i", v, edge)[:, None] * edge for v in (c - a, d - a)]
        cosine = np.einsum("ij,ij->i", *sides) / np.prod([np.linalg.norm(s, axis=1) for s in sides], axis=0)
        least = np.minimum(least, np.degrees(np.arccos(np.clip(cosine, -1, 1))))
    return least.min()


def test_tetrahedra_of_gmsh_have_no_flat_angles():
    # All angles of a regular tetrahedron are acos(1/3).
    regular = np.array([(1.0, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)])
    assert least_dihedral(regular, np.array([[0, 1, 2, 3]])) == pytest.approx(np.degrees(np.arccos(1 / 3)))
    part = rv.Part((box(size=(2, 2, 2)) - cylinder(R, axis="x") - cylinder(R, axis="z")).name("cube"))
    filled = part.mesh(size=0.0575).fill("gmsh", size=0.0575)
    assert len(filled.tets) > 100_000 and least_dihedral(filled.points, filled.tets) >= 10
