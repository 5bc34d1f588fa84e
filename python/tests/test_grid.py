"""Values on grids as solids: nodes on the zeros of the trilinear function, and what is refused."""

import math
import time

import numpy as np
import pytest

import rvachev as rv


def trilinear(values, origin, spacing, points):
    """Values and gradients of the trilinear interpolant, written here without the library."""
    at = (points - origin) / spacing
    cell = np.clip(np.floor(at).astype(int), 0, np.array(values.shape) - 2)
    t = at - cell
    f, g = np.zeros(len(points)), np.zeros((len(points), 3))
    for corner in np.ndindex(2, 2, 2):
        v = values[tuple((cell + corner).T)]
        w = np.where(np.array(corner) == 1, t, 1 - t)
        f += v * w.prod(axis=1)
        for a in range(3):
            others = np.delete(w, a, axis=1).prod(axis=1)
            g[:, a] += (1 if corner[a] else -1) * v * others / np.broadcast_to(spacing, 3)[a]
    return f, g


def sampled(function, n, lo, hi):
    axes = [np.linspace(a, b, k) for a, b, k in zip(lo, hi, n)]
    spacing = (np.array(hi, dtype=float) - lo) / (np.array(n) - 1)
    return function(*np.meshgrid(*axes, indexing="ij")), np.array(lo, dtype=float), spacing


def volume(points, triangles):
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return np.einsum("ij,ij->", a, np.cross(b, c)) / 6


def dented(x, y, z):
    return np.minimum(1 - np.sqrt(x**2 + y**2 + z**2), np.sqrt(x**2 + y**2 + (z - 1.3) ** 2) - 0.7)


def torus(x, y, z):
    return 0.4 - np.hypot(np.hypot(x, y) - 1, z)


@pytest.mark.parametrize(
    ("function", "euler", "truth"),
    [
        # A unit ball without where a ball of radius 0.7 about (0, 0, 1.3) meets it.
        (dented, 2, 4 / 3 * math.pi - math.pi * (1.7 - 1.3) ** 2 * (1.3**2 + 2 * 1.3 * 1.7 - 3 * (0.3) ** 2) / (12 * 1.3)),
        (torus, 0, 2 * math.pi**2 * 0.4**2),
    ],
)
def test_nodes_are_where_the_trilinear_function_vanishes(function, euler, truth):
    values, origin, spacing = sampled(function, (100, 100, 100), (-1.5, -1.5, -1.5), (1.5, 1.5, 1.5))
    started = time.monotonic()
    made = rv.Part(rv.grid(values, origin, spacing).name("scan")).mesh(size=0.05)
    print(f"{len(made.points)} points in {time.monotonic() - started:.1f} s")
    f, g = trilinear(values, origin, spacing, made.points)
    off = np.abs(f) / np.linalg.norm(g, axis=1)
    assert off.max() < 0.1 * spacing.max()
    assert made.report["check"]["euler"] == euler
    assert made.certificate["faults"] == []
    assert volume(*made) == pytest.approx(truth, rel=5e-3)


def test_axes_origin_and_spacing_are_where_numpy_has_them():
    # No two axes alike: a box-shaped level set of a linear-by-parts function off the origin.
    n, lo, hi = (21, 31, 41), (1.0, 2.0, 3.0), (3.0, 5.0, 11.0)
    values, origin, spacing = sampled(
        lambda x, y, z: 1 - np.sqrt(((x - 2) / 0.8) ** 2 + ((y - 3.5) / 1.2) ** 2 + ((z - 7) / 3.5) ** 2), n, lo, hi
    )
    part = rv.Part(rv.grid(values, origin, spacing))
    points = np.random.default_rng(3).uniform(lo, hi, (500, 3))
    f, _ = trilinear(values, origin, spacing, points)
    assert ((rv.evaluate(part, points) > 0) == (f > 0)).all()
    made = part.mesh(size=0.3)
    assert made.points.min(axis=0) == pytest.approx([1.2, 2.3, 3.5], abs=0.06)
    assert made.points.max(axis=0) == pytest.approx([2.8, 4.7, 10.5], abs=0.06)
    moved = rv.Part(rv.grid(values.astype(np.float32), tuple(origin), spacing) & rv.half_space((0, 0, 1), at=(0, 0, 7)))
    assert volume(*moved.mesh(size=0.3)) == pytest.approx(volume(*made) / 2, rel=1e-2)


def test_what_reaches_the_walls_is_cut_off_there():
    # One number for all axes, and two points along one of them: half space z < 0.25 in a box.
    values = np.broadcast_to(np.array([0.25, -0.75]), (3, 4, 2))
    made = rv.Part(rv.grid(values, spacing=1.0)).mesh(size=0.5)
    assert volume(*made) == pytest.approx(2 * 3 * 0.25)
    assert made.report["check"]["features"]["recall"] == 1.0


def test_the_same_bytes_for_any_number_of_threads():
    part = rv.Part(rv.grid(*sampled(torus, (30, 30, 30), (-1.5,) * 3, (1.5,) * 3)))
    one, two = (part.mesh(size=0.15, threads=n) for n in (1, 3))
    assert one.points.tobytes() == two.points.tobytes() and one.triangles.tobytes() == two.triangles.tobytes()


def bad(at, value):
    values = np.ones((4, 5, 6))
    values[0] = -1
    values[at] = value
    return values


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ((np.ones((4, 4)),), r"shape \(nx, ny, nz\), not \(4, 4\)"),
        ((np.ones((4, 4, 4, 1)),), "shape"),
        ((bad((1, 2, 3), np.nan),), r"\[1, 2, 3\].*not finite"),
        ((bad((3, 0, 5), -np.inf),), r"\[3, 0, 5\].*not finite"),
        ((np.array([[[1.0, -1.0]]]),), "two points along each axis"),
        ((np.ones((3, 3, 3)),), "all values.*inside"),
        ((-np.ones((3, 3, 3)),), "all values.*outside"),
        ((bad((1, 1, 1), 2), (0, 0, np.inf)), "finite origin"),
        ((bad((1, 1, 1), 2), (0, 0, 0), (1, 0, 1)), "positive spacing"),
        ((bad((1, 1, 1), 2), (0, 0)), "origin"),
        ((bad((1, 1, 1), 2), (0, 0, 0), (1, 1)), "spacing"),
    ],
)
def test_what_is_no_grid(arguments, text):
    with pytest.raises(rv.InputError, match=text):
        rv.grid(*arguments)
