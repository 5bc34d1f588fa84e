"""Pictures, curvatures, classes and distances of meshes; what triangles are made of; comparisons."""

import math
import struct

import numpy as np
import pytest

import rvachev as rv

# A picture of a ball of radius 2 within one of radius 4, which fills the height but for margins of 5 pixels.
LOOK = {"pixels": (120, 100), "transparent": True, "legend": False, "edges": "none", "focus": (0, 0, 0, 4), "view": "front"}
CIRCLE = math.pi * 22.5**2

CUBE = np.array([[x, y, z] for z in (0, 2) for x, y in ((0, 0), (2, 0), (2, 2), (0, 2))], dtype=float)
SIDES = [[0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7], [0, 1, 5], [0, 5, 4], [1, 2, 6], [1, 6, 5], [2, 3, 7], [2, 7, 6], [3, 0, 4], [3, 4, 7]]


@pytest.fixture(scope="module")
def part():
    return rv.Part(rv.sphere(2).name("ball"))


@pytest.fixture(scope="module")
def ball(part):
    return part.mesh(size=0.3)


def covered(pixels):
    return pixels[:, :, 3].sum() / 255


def test_a_mesh_is_drawn(ball, part, tmp_path):
    path = tmp_path / "ball.png"
    pixels = rv.picture(ball, path=path, **LOOK)
    assert pixels.shape == (100, 120, 4) and pixels.dtype == np.uint8
    assert covered(pixels) == pytest.approx(CIRCLE, rel=0.03)
    data = path.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n" and struct.unpack(">II", data[16:24]) == (120, 100)
    assert covered(rv.picture(ball, clip="x=0,above", **LOOK)) == pytest.approx(CIRCLE / 2, rel=0.05)
    assert covered(rv.picture(ball, clip=["x=0,above", "z=0,below"], **LOOK)) == pytest.approx(CIRCLE / 4, rel=0.1)
    # As text, as the command has it; and arrays in place of a mesh.
    text = {**LOOK, "pixels": "120x100", "focus": "0,0,0,4", "view": "0,0"}
    again = rv.picture(ball.points, ball.triangles, **text)
    assert (again[:, :, 3] == pixels[:, :, 3]).all()
    opaque = rv.picture(ball)
    assert opaque.shape == (900, 1200, 4) and (opaque[:, :, 3] == 255).all()
    far = rv.picture(ball, color="distance", against=part, **LOOK)
    assert (far[:, :, 3] == pixels[:, :, 3]).all() and (far != pixels).any()


def test_pictures_that_make_no_sense_are_refused(ball, part, tmp_path):
    for wrong, match in [
        ({"view": "up"}, "up"), ({"pixels": (4, 4)}, "WIDTHxHEIGHT"), ({"color": "distance"}, "surface of a part"),
        ({"against": part}, "distance alone"),
        ({"clip": "x=9"}, "x"), ({"path": "a.jpg"}, "a.jpg"), ({"color": "distance", "against": tmp_path / "no.py"}, "no.py"),
    ]:  # fmt: skip
        with pytest.raises(rv.InputError, match=match):
            rv.picture(ball, **wrong)
    with pytest.raises(TypeError, match="transparent"):
        rv.picture(ball, zoom=2)
    with pytest.raises(TypeError, match="mesh is wanted"):
        rv.picture(part)


def test_a_ball_bends_by_its_radius_and_a_cube_has_corners(ball, part):
    principal, defects = rv.curvature(ball)
    assert principal.shape == (len(ball.points), 2) and defects.shape == (len(ball.points),)
    assert principal.mean() == pytest.approx(0.5, rel=0.02)
    assert (principal[:, 0] >= principal[:, 1]).all()
    # By Gauss and Bonnet.
    assert defects.sum() == pytest.approx(4 * math.pi, abs=1e-8)
    assert (rv.node_classes(ball) == 0).all()
    classes = rv.node_classes(rv.Part(rv.box(size=(2, 2, 2))).mesh(size=0.3))
    # Six nodes between the corners of each edge.
    assert classes.dtype == np.uint8 and np.bincount(classes)[1:].tolist() == [72, 8]
    principal, defects = rv.curvature(CUBE, SIDES)
    assert defects == pytest.approx(np.full(8, math.pi / 2))
    assert rv.distances(ball, against=part).max() < 1e-9
    grown = rv.distances(1.01 * ball.points, ball.triangles, against=part)
    assert grown == pytest.approx(np.full(len(ball.points), 0.02), abs=1e-6)
    with pytest.raises(rv.InputError):
        rv.curvature(CUBE, [*SIDES, SIDES[0]])


def test_triangles_are_told_of(tmp_path):
    info = rv.triangles_info(CUBE, SIDES)
    assert (info["vertices"], info["edges"], len(info["faces"]), info["closed"]) == (8, 12, 6, True)
    assert [f["area"] for f in info["faces"]] == pytest.approx([4.0] * 6)
    # Nothing is sharper than 100 degrees.
    assert len(rv.triangles_info(CUBE, SIDES, feature_angle=100)["faces"]) == 1
    path = tmp_path / "cube.obj"
    lines = [f"v {x} {y} {z}" for x, y, z in CUBE] + ["g floor"] + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in SIDES[:2]] + ["g rest"]
    path.write_text("\n".join(lines + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in SIDES[2:]]) + "\n")
    assert rv.triangles_info(path)["faces"][0]["name"] == "floor"
    compared = [rv.compare_triangles(CUBE, SIDES, size=0.5), rv.compare_triangles(path, size=0.5)]
    for rows in (c["rows"] for c in compared):
        assert [r["method"] for r in rows] == ["input", "poisson", "frontal", "triangles"]
        assert [r["check"]["volume"] for r in rows] == pytest.approx([8.0] * 4)
    with pytest.raises(rv.InputError, match="no.stl"):
        rv.triangles_info(tmp_path / "no.stl")
    with pytest.raises(TypeError, match="feature_angle"):
        rv.triangles_info(CUBE, SIDES, method="leaf")


def test_systems_and_samples_are_compared():
    bored = rv.Part(rv.box(size=(2, 2, 2)) - rv.cylinder(0.4))
    rows = rv.compare_rsystems(bored, size=0.3)["rows"]
    assert rows[0]["rsystem"] == "minmax" and rows[0]["moved_nodes"] == 0 and len(rows) == 5
    # Planes and cylinders have slopes of 1 on the boundary.
    assert rows[0]["boundary"]["max"] < 1e-9 and [r["rsystem"] for r in rows if r["own"]] == ["R0"]
    rows = rv.compare_samples(size=0.4)["rows"]
    assert [r["sample"] for r in rows[::5]] == ["centered", "edge", "rotated"] and rows[4]["method"] == "leaf"
    for refused in (lambda: rv.compare_samples(volume=0.01), lambda: rv.compare_rsystems(bored, without="trim")):
        with pytest.raises(rv.InputError, match="neither volume"):
            refused()


def test_faces_decide_at_points():
    bored = rv.Part(rv.box(size=(2, 2, 2)).name("body") - rv.cylinder(0.4, axis="x").name("bore"))
    names = bored.face_names
    assert sorted(names) == ["body.xmax", "body.xmin", "body.ymax", "body.ymin", "body.zmax", "body.zmin", "bore"]
    assert list(names) == [f["name"] for f in bored.info()["faces"]]
    # Near the middles of two sides, in the bore, beyond the roof, and on the floor.
    at = [(-0.95, 0.6, 0.5), (0.1, 0.97, 0.2), (0.1, 0, 0), (0.7, 0.6, 1.5), (0.8, 0.7, -1)]
    found = ["body.xmin", "body.ymax", "bore", "body.zmax", "body.zmin"]
    values, faces = rv.evaluate(bored, at, faces=True)
    assert faces.dtype == np.int32 and [names[i] for i in faces] == found
    again, gradients, same = rv.evaluate(bored, at, gradient=True, faces=True)
    assert (again == values).all() and (same == faces).all() and gradients.shape == (5, 3)
    # On the floor, where every system has a slope of 1.
    assert gradients[4] == pytest.approx([0, 0, 1], abs=1e-9)
    # In the middles of triangles of plane sides it is the face the mesh says.
    mesh = bored.mesh(size=0.3)
    inner = mesh.points[mesh.triangles].mean(axis=1)
    sides = np.array([mesh.face_names[label] != "bore" for label in mesh.labels])
    _, decide = rv.evaluate(bored, inner[sides], faces=True)
    assert [names[i] for i in decide] == [mesh.face_names[label] for label in mesh.labels[sides]]
    # Of what is built from edges the function is the distance to its faces.
    built = rv.Part(rv.extrude_edges(rv.polyline([(0, 0), (1, 0), (1, 1)], closed=True), direction="z", distance=1))
    values, faces = rv.evaluate(built, [(0.9, 0.5, 0.5), (0.5, 0.25, 1.25), (3, 0.5, 0.5)], faces=True)
    assert values == pytest.approx([0.1, -0.25, -2], abs=1e-12)
    assert "end" in built.face_names[faces[1]]


def test_comparisons_are_drawn(tmp_path):
    bored = rv.Part(rv.box(size=(2, 2, 2)) - rv.cylinder(0.4))
    png, classes, triangles = (tmp_path / name for name in ("a.png", "b.png", "c.png"))
    rows = rv.compare(bored, size=0.4, png=png)["rows"]
    rv.compare(bored, size=0.4, png=classes, color="class")
    rv.compare_triangles(CUBE, SIDES, size=0.5, png=triangles, color=None)
    # Pictures of 420 pixels stand in rows of six at most.
    for path, count in ((png, len(rows)), (classes, len(rows)), (triangles, 4)):
        data = path.read_bytes()
        width, height = struct.unpack(">II", data[16:24])
        assert data[:8] == b"\x89PNG\r\n\x1a\n" and width >= 420 * min(count, 6) and height >= 360 * math.ceil(count / 6)
    assert png.read_bytes() != classes.read_bytes()
    for wrong, match in [({"png": "a.jpg"}, "a.jpg"), ({"png": png, "color": "face"}, "angle or class"), ({"color": "class"}, "png")]:
        with pytest.raises(rv.InputError, match=match):
            rv.compare(bored, size=0.4, **wrong)
    with pytest.raises(TypeError, match="png"):
        rv.compare_rsystems(bored, png=png)


def test_parts_built_from_edges_are_told_of():
    square = rv.polyline([(0, 0), (2, 0), (2, 2), (0, 2)], closed=True)
    cube = rv.extrude_edges(square, direction="z", distance=2).name("cube")
    info = rv.Part(cube, units="mm").info()
    assert [info[k] for k in ("vertices", "edges", "open_edges", "sewn", "units")] == [8, 12, 0, True, "mm"]
    assert [f["area"] for f in info["faces"]] == pytest.approx([4.0] * 6)
    assert info["bodies"][0]["volume"] == pytest.approx(8) and info["bounds"]["size"] == pytest.approx([2, 2, 2])
    both = rv.Part([cube, rv.sphere(1).name("ball").move((5, 5, 5))]).info()
    assert both["leaves"] == 1 and [f["name"] for f in both["faces"]] == ["ball"] and both["built"]["edges"] == 12
