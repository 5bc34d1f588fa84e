"""What all codes compute: the bracket in tetrahedra, its material, where it is held and what pulls at it.

Millimeters, newtons, megapascals.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

import rvachev as rv

PART = Path(__file__).with_name("bracket.py")


@dataclass
class Model:
    points: np.ndarray  # float64 (n, 3)
    tets: np.ndarray  # int64 (m, 4)
    clamped: np.ndarray  # int64 (k,): points that do not move
    forces: np.ndarray  # float64 (n, 3): what pulls at each point
    filled: rv.Filled  # the same tetrahedra, with the names of the surface
    young: float = 210_000.0
    poisson: float = 0.3


def nodal_forces(filled, name, total):
    """A force spread evenly over the triangles of a group: each gives a third of its share to each of its points."""
    triangles = filled.triangles[filled.groups[name]]
    a, b, c = (filled.points[triangles[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    share = np.bincount(triangles.ravel(), np.repeat(area / (3 * area.sum()), 3), len(filled.points))
    return share[:, None] * np.asarray(total, dtype=float)


def bracket(size=3.0, by="gmsh"):
    """The bracket with 1000 N on its pin, pulling down and a little aside."""
    filled = rv.mesh(PART, size=size).fill(by)
    forces = nodal_forces(filled, "loaded", (0, 300, -1000))
    return Model(filled.points, filled.tets, filled.nodes("clamped"), forces, filled)


def tell(code, model, u):
    worst = np.linalg.norm(u, axis=1).max()
    print(f"{code}: {len(model.points)} points, {len(model.tets)} tetrahedra, the farthest moves {worst:.6e} mm")
