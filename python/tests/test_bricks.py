"""Meshes brick by brick by executors of Python's: the same arrays whoever makes the bricks."""

import pickle
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest

import rvachev as rv

TEXT = "part(box(size=(2, 2, 2)).name('body') - cylinder(0.4, axis='x') - cylinder(0.4, axis='z'))\n"
# A cube less two cylinders of radius 0.4 that cross, by Steinmetz.
VOLUME = 8 - 4 * np.pi * 0.16 + 16 / 3 * 0.4**3


@pytest.fixture(scope="module")
def tasks(tmp_path_factory):
    path = tmp_path_factory.mktemp("bricks") / "part.py"
    path.write_text(TEXT)
    tasks = rv.plan(path, 0.04, bricks=(2, 2, 1))
    # Other processes need the tasks only.
    path.unlink()
    assert [t.brick for t in tasks] == [0, 1, 2, 3] and all(t.cost > 0 for t in tasks)
    return tasks


@pytest.fixture(scope="module")
def here(tasks):
    mesh = rv.merge(map(rv.mesh_brick, tasks))
    p, t = mesh
    a, b, c = (p[t[:, k]] for k in range(3))
    assert abs(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6 - VOLUME) < 1e-3 * VOLUME
    assert mesh.certificate["faults"] == []
    return mesh


def same(a, b):
    return np.array_equal(a.points, b.points) and np.array_equal(a.triangles, b.triangles)


def test_a_pool_of_processes_gives_the_same(tasks, here):
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        assert same(rv.merge(pool.map(rv.mesh_brick, tasks)), here)


def test_dask_gives_the_same(tasks, here):
    from dask.distributed import Client

    with Client(n_workers=2, threads_per_worker=1, dashboard_address=None) as client:
        assert same(rv.merge(client.get_executor().map(rv.mesh_brick, tasks)), here)


def test_mpi_gives_the_same_bytes(tmp_path, here):
    part, out, alone = (tmp_path / name for name in ("part.py", "a.stl", "alone.stl"))
    part.write_text(TEXT)
    script = Path(__file__).parents[2] / "examples" / "cluster" / "mpi.py"
    # Open MPI of the same environment, whichever else the system has; it refuses root without being told.
    mpirun = [Path(sys.executable).with_name("mpirun"), "--allow-run-as-root", "--oversubscribe", "-n", "4"]
    python = [sys.executable, "-m", "mpi4py.futures", script, part, "0.04", "2x2x1", out]
    said = subprocess.run([*mpirun, *python], cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert said.returncode == 0, said.stdout + said.stderr
    assert f"{len(here.triangles)} triangles of 4 bricks by 3 processes" in said.stdout
    here.write(alone)
    assert out.read_bytes() == alone.read_bytes()


def test_what_lacks_or_does_not_fit_is_an_error(tasks):
    pieces = [pickle.loads(pickle.dumps(rv.mesh_brick(t))) for t in tasks[:2]]
    with pytest.raises(rv.InputError, match="brick 2 of round 1"):
        rv.merge(pieces)
    with pytest.raises(ValueError, match="no pieces"):
        rv.merge([])
    with pytest.raises(rv.InputError, match="read from files"):
        rv.plan(rv.Part(rv.box(size=(1, 1, 1))), 0.1, bricks=(1, 1, 1))


def test_bricks_are_made_by_one_method_alone(tmp_path):
    path = tmp_path / "part.py"
    path.write_text(TEXT)
    for options in ({"method": "mc"}, {"sequence": "N*10"}):
        with pytest.raises(rv.Error, match="method leaf"):
            rv.plan(path, 0.04, bricks=(1, 1, 1), **options)
