"""A mesh in bricks by MPI: one process plans and merges, all others make bricks.

usage: mpirun --oversubscribe -n 4 python -m mpi4py.futures mpi.py PART SIZE BRICKS MESH
  e.g. mpirun --oversubscribe -n 4 python -m mpi4py.futures mpi.py part.py 0.5% 4x4x2 part.vtu
"""

import sys

import rvachev as rv
from mpi4py.futures import MPIPoolExecutor


def main():
    if len(sys.argv) != 5:
        sys.exit(__doc__)
    part, size, bricks, out = sys.argv[1:]
    size = size if size.endswith("%") else float(size)
    tasks = rv.plan(part, size, bricks=tuple(int(n) for n in bricks.split("x")))
    with MPIPoolExecutor() as workers:
        mesh = rv.merge(workers.map(rv.mesh_brick, tasks))
        print(f"{len(mesh.triangles)} triangles of {len(tasks)} bricks by {workers.num_workers} processes")
    mesh.write(out)


if __name__ == "__main__":
    main()
