"""Capacitance of a conductor in bempp-cl: its single layer operator on our surface mesh. `pip install bempp-cl`, then run it.

Charge is constant on each triangle, the potential of the conductor is one. In units of 4 pi epsilon times the part's unit: a ball has
its radius, the unit cube 0.66067815.
"""

import bempp_cl.api as bem
import numpy as np
from capacitance import limit, series

import rvachev as rv


def grid_of(mesh):
    """A bempp_cl.api.Grid. Domain i + 1 is the face of `mesh.face_names[i]`: `function_space(..., segments=[i + 1])` is that face's."""
    # By columns, and contiguous, as its kernels want them.
    return bem.Grid(mesh.points.T.copy(), mesh.triangles.T.astype(np.uint32, order="C"), mesh.labels + 1)


def capacitance(mesh):
    """In units of 4 pi epsilon times the mesh's unit."""
    grid = grid_of(mesh)
    space = bem.function_space(grid, "DP", 0)
    # numba's kernels: OpenCL is a package and a driver of its own.
    operator = bem.operators.boundary.laplace.single_layer(space, space, space, device_interface="numba")
    # A potential of one, tested by each triangle's charge, is its area.
    density = np.linalg.solve(operator.weak_form().to_dense(), grid.volumes)
    return density @ grid.volumes / (4 * np.pi)


if __name__ == "__main__":
    for name, solid, sizes, order, truth in [
        ("unit cube", rv.box(size=(1, 1, 1)), (0.25, 0.125, 0.0625), 4 / 3, 0.66067815),
        ("unit ball", rv.sphere(1), (0.4, 0.2), 2, 1.0),
    ]:
        print(name)
        print(f"  carried on: {limit(series(solid, sizes, capacitance), order):.6f}, true {truth}")
