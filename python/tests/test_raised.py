"""Plane figures extruded and turned around: volumes, names of faces, and what is no figure."""

import math

import numpy as np
import pytest

import rvachev as rv


def made(solid):
    mesh = rv.Part(solid).mesh(size="1%")
    a, b, c = (mesh.points[mesh.triangles[:, k]] for k in range(3))
    return np.einsum("ij,ij->", a, np.cross(b, c)) / 6, set(mesh.faces)


def test_figures_are_extruded():
    plate = rv.rectangle(size=(4, 2)).name("plate") - rv.cylinder(0.5).name("bore")
    volume, faces = made(rv.extrude(plate, 3, at=(0, 0, 5)).name("it"))
    assert volume == pytest.approx(3 * (8 - math.pi / 4), rel=1e-3)
    assert faces == {"plate.xmin", "plate.xmax", "plate.ymin", "plate.ymax", "bore", "it.bottom", "it.top"}
    assert made(rv.extrude(rv.circle(1), height=2))[0] == pytest.approx(2 * math.pi, rel=2e-3)
    assert made(rv.extrude([(0, 0), (1, 0), (0, 1)], 2))[0] == pytest.approx(1)


def test_figures_are_turned_around():
    for figure in rv.circle(1, at=(3, 0)), rv.cylinder(1).move((3, 0, 0)), (rv.x - 3) ** 2 + rv.y**2 <= 1:
        assert made(rv.revolve(figure))[0] == pytest.approx(6 * math.pi**2, rel=2e-3)


def test_what_depends_on_z_is_no_figure():
    for call in (lambda: rv.extrude(rv.sphere(1), 2), lambda: rv.revolve(rv.z >= 0)):
        with pytest.raises(rv.InputError, match="depends on z"):
            call()
    with pytest.raises(rv.InputError, match="height"):
        rv.extrude(rv.rectangle((1, 1)), 0)
