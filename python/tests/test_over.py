"""What is told before meshing and asked of a mesh: numbers of triangles, values at other points, ways, progress."""

import sys

import numpy as np
import psutil
import pytest

import rvachev as rv


@pytest.fixture(scope="module")
def mesh():
    return rv.mesh(rv.box(lo=(0, 0, 0), hi=(2, 2, 1)), size=0.2)


def test_triangles_are_told_before_meshing(tmp_path):
    ball = rv.Part(rv.sphere(1))
    about = rv.expected_triangles(ball, 0.1)
    # The area over that of an equilateral triangle.
    assert isinstance(about, int) and about == pytest.approx(4 * np.pi / (0.1**2 * np.sqrt(3) / 4), rel=0.1)
    assert len(ball.mesh(0.1).triangles) == pytest.approx(about, rel=0.1)
    assert rv.expected_triangles(rv.sphere(1), size=0.1) == about
    (tmp_path / "p.py").write_text("r = 1\npart(sphere(r))\n")
    assert rv.expected_triangles(tmp_path / "p.py", 0.1) == about
    assert rv.expected_triangles(tmp_path / "p.py", 0.1, define={"r": 2}) == pytest.approx(4 * about, rel=0.1)
    with pytest.raises(rv.InputError):
        rv.expected_triangles(ball, -1)
    with pytest.raises(rv.Error):
        rv.expected_triangles(tmp_path / "none.py")


def test_linear_values_are_carried_exactly(mesh):
    def f(p):
        return p @ np.array([(1, 2, 3, -1), (0, 1, 0, 5), (2, 0, 1, 0)]) + (1, 0, 0, 2)

    finer = rv.mesh(rv.box(lo=(0, 0, 0), hi=(2, 2, 1)), size=0.13)
    values, distances = rv.carry(mesh, f(mesh.points), finer)
    assert values.shape == (len(finer.points), 4) and np.abs(values - f(finer.points)).max() < 1e-12
    assert distances.shape == (len(finer.points),) and distances.max() < 1e-12
    one, away = rv.carry(mesh, mesh.points[:, 2], [(1, 1, 3), (0.3, 0.4, -1)])
    assert one.tolist() == pytest.approx([1, 0]) and away.tolist() == pytest.approx([2, 1])
    many, _ = rv.carry(mesh, np.broadcast_to(np.eye(3), (len(mesh.points), 3, 3)), finer.points[:5])
    assert np.abs(many - np.eye(3)).max() < 1e-12
    nothing, far = rv.carry(mesh, np.zeros((len(mesh.points), 0)), [(1, 1, 3)])
    assert nothing.shape == (1, 0) and far[0] == pytest.approx(2)
    with pytest.raises(rv.InputError, match="values"):
        rv.carry(mesh, np.zeros(7), finer)
    with pytest.raises(rv.InputError):
        rv.carry(mesh, np.zeros(len(mesh.points)), [(np.nan, 0, 0)])
    with pytest.raises(TypeError, match="number"):
        rv.carry(mesh, 1.0, finer)


def test_the_shortest_way_goes_around_the_edge(mesh):
    # Over the edge x = 2, z = 1: laid flat, 0.5 + 0.5 across and 1 along.
    points, length = rv.shortest_path(mesh, (1.5, 0.5, 1), (2, 1.5, 0.5))
    assert length == pytest.approx(np.sqrt(2), abs=1e-9)
    assert points[[0, -1]] == pytest.approx(np.array([(1.5, 0.5, 1), (2, 1.5, 0.5)]))
    assert np.linalg.norm(np.diff(points, axis=0), axis=1).sum() == pytest.approx(length)
    apart = rv.mesh(rv.union(rv.sphere(1), rv.sphere(1, at=(4, 0, 0))), size=0.3)
    with pytest.raises(rv.InputError, match="hang together"):
        rv.shortest_path(apart, (0, 0, 1), (4, 0, 1))
    with pytest.raises(TypeError):
        rv.shortest_path(mesh, (0, 0), (1, 1))


def test_meshes_are_joined_where_nodes_match(mesh):
    # Upside down above the mesh, a hundredth apart: nodes of the lids match.
    upper = rv.heal(mesh.points * (1, 1, -1) + (0, 0, 2.01), mesh.triangles[:, ::-1])
    assert len(upper.points) == len(mesh.points)
    with pytest.warns(rv.Shortfall, match="mesh 1 has no node in common"):
        apart = rv.join([mesh, upper])
    assert len(apart.points) == len(mesh.points) + len(upper.points) and apart.report["matched"] == 0
    joined = rv.join(iter([mesh, upper]), within=0.02)
    lid = np.count_nonzero(mesh.points[:, 2] == 1)
    assert joined.report["matched"] == lid and len(joined.points) == len(apart.points) - lid
    assert joined.report["farthest"] == pytest.approx(0.01)
    assert joined.face_names == [*mesh.face_names, *upper.face_names]
    assert len(joined.triangles) == len(mesh.triangles) + len(upper.triangles)
    assert joined.points[: len(mesh.points)].tobytes() == mesh.points.tobytes()
    for wrong, within in (([], None), ([mesh], -1)):
        with pytest.raises(rv.InputError):
            rv.join(wrong, within)
    with pytest.raises(TypeError):
        rv.join([mesh, "a.stl"])


def test_models_are_told_of_and_methods_compared(tmp_path):
    square = rv.polyline([(0, 0), (1, 0), (1, 1), (0, 1)], closed=True)
    rv.Part(rv.extrude_edges(square, direction="z", distance=2), units="mm").write(tmp_path / "b.step")
    assert rv.step_check(tmp_path / "b.step")["sound"] is True
    told = rv.step_info(tmp_path / "b.step")
    assert len(told["faces"]) == 6 or len(told["bodies"]) == 1
    assert told["bodies"][0]["volume"] == pytest.approx(2)
    found = rv.compare(rv.Part(rv.sphere(1)), size=0.3)
    assert {row["method"] for row in found["rows"]} >= {"leaf", "operators", "mc"}
    with pytest.raises(rv.InputError, match="volume"):
        rv.compare(rv.Part(rv.sphere(1)), volume=0.1)
    (tmp_path / "c.step").write_text("nothing")
    for look in (rv.step_check, rv.step_info):
        with pytest.raises(rv.InputError, match="c.step"):
            look(tmp_path / "c.step")


def test_progress_is_a_bar_of_tqdm_if_there_is_one(capsys, monkeypatch):
    from tqdm.auto import tqdm

    started = []
    made = tqdm.__init__
    monkeypatch.setattr(tqdm, "__init__", lambda self, *a, **k: (started.append(k), made(self, *a, **k))[1])
    rv.mesh(rv.sphere(1), size=0.02, progress=True)
    shown = capsys.readouterr().err
    assert len(started) == 1 and "%|" in shown and not tqdm._instances
    # Taken away also where the mesh is refused.
    with pytest.raises(rv.Error):
        rv.mesh("none.step", progress=True)
    assert len(started) == 2 and not tqdm._instances
    rv.mesh(rv.sphere(1), size=0.1, progress=False)
    assert len(started) == 2

    monkeypatch.setitem(sys.modules, "tqdm.auto", None)
    capsys.readouterr()
    rv.mesh(rv.sphere(1), size=0.02, progress=True)
    shown = capsys.readouterr().err
    assert "%|" not in shown and "[===" in shown and shown.endswith("\r")
    monkeypatch.setattr(sys, "stderr", None)
    rv.mesh(rv.sphere(1), size=0.1, progress=True)


def resident():
    """Memory of this process, in bytes."""
    return psutil.Process().memory_info().rss


def test_ten_thousand_calls_leak_nothing(mesh):
    part = rv.Part(rv.box(size=(1, 1, 1)))
    at = np.random.default_rng(0).normal(size=(100, 3))
    upper = np.count_nonzero(mesh.points[:, 2])

    def calls(n):
        for _ in range(n):
            rv.evaluate(part, at, gradient=True)
            arrays = mesh.points, mesh.triangles, mesh.labels, mesh.normals, mesh.feature_edges, mesh.nodes("*.zmax"), mesh.faces
            assert len(arrays[0]) > upper
            with pytest.raises(KeyError):
                mesh.nodes("none")

    calls(300)
    before = resident()
    calls(1000)
    # Some ten calls in each round: a tenth of an array of points would be seen.
    assert resident() - before < 1000 * mesh.points.nbytes / 10
    # Allocators keep what the first meshes gave back.
    for n in (50, 80):
        before = resident()
        for _ in range(n):
            made = part.mesh(size=0.1)
    assert resident() - before < n * (made.points.nbytes + made.triangles.nbytes) / 3
