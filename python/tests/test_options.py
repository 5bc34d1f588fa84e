"""Options of meshing that have more than one form, or are for some kinds of parts alone."""

import math
from pathlib import Path

import numpy as np
import pytest

import rvachev as rv
from rvachev import sphere

# A ball of radius 2.
STEP = Path(__file__).parents[2] / "data/step/sphere.step"
BALL = 4 / 3 * math.pi * 8


def volume(mesh):
    a, b, c = (mesh.points[mesh.triangles[:, k]] for k in range(3))
    return np.einsum("ij,ij->", a, np.cross(b, c)) / 6


def test_a_tolerance_is_a_length_or_a_share_of_the_diagonal():
    ball = rv.Part(sphere(1))
    share, length = (ball.mesh(size="40%", tol=t) for t in ("0.1%", 0.002 * math.sqrt(3)))
    assert len(share.triangles) == len(length.triangles) > 1000
    assert len(ball.mesh(size="40%", tol="1%").triangles) < len(share.triangles) / 5
    bounded, by_length = (ball.mesh(size="40%", tol="0.1%", size_min=m) for m in ("5%", 0.1 * math.sqrt(3)))
    assert len(bounded.triangles) == len(by_length.triangles) < len(share.triangles)
    with pytest.raises(rv.Error, match="-1%"):
        ball.mesh(tol="-1%")


def test_a_share_of_the_volume_may_be_lost():
    coarse, fine = (volume(rv.mesh(STEP, volume=v)) for v in (0.01, 0.001))
    assert BALL * 0.999 < fine < BALL and BALL * 0.99 < coarse < fine
    with pytest.raises(rv.Error, match="volume"):
        rv.Part(sphere(1)).mesh(volume=0.01)
    with pytest.raises(rv.Error, match="below 1"):
        rv.mesh(STEP, volume=1)


def test_remedies_are_left_out_by_name():
    for without in ("trim", ["halving", "inset"]):
        assert volume(rv.mesh(STEP, without=without)) == pytest.approx(BALL, rel=0.01)
    with pytest.raises(rv.Error, match="no remedy"):
        rv.mesh(STEP, without="luck")
    with pytest.raises(rv.Error, match="remedies"):
        rv.Part(sphere(1)).mesh(without="trim")


@pytest.mark.filterwarnings("ignore::rvachev.Shortfall")
def test_a_sequence_stands_for_the_method_that_runs_it():
    ball = rv.Part(sphere(1))
    mesh = ball.mesh(size=0.2, sequence="R_all*2 N*10 N1")
    assert mesh.report["method"] == "operators" and mesh.report["sequence"] == "R_all*2 N*10 N1"
    assert volume(mesh) == pytest.approx(4 / 3 * math.pi, rel=0.03)
    with pytest.raises(rv.Error, match="operators"):
        ball.mesh(size=0.2, sequence="N*10", method="leaf")
    with pytest.raises(rv.Error, match="column 9"):
        ball.mesh(sequence="R_all*2 M")
    with pytest.raises(rv.Error, match="sequence"):
        rv.mesh(STEP, sequence="N*10")
