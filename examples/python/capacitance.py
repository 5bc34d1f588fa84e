"""Capacitance of a conductor by boundary elements on its surface mesh: Galerkin's method, charge constant on each triangle.

The potential of a triangle's charge is integrated in closed form [Wilton et al. 1984], that over the other triangle by three points.
Needs numpy alone. In units of 4 pi epsilon times the part's unit: a ball has its radius, the unit cube 0.66067815.
"""

import numpy as np

import rvachev as rv

# Pairs looked at together: what fits a cache.
BLOCK = 30_000


def potentials(at, corners):
    """Integrals of 1 / distance over triangles (m, 3, 3), seen from points (k, 3): (k, m)."""
    a, b, c = (corners[:, k] for k in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)

    def measured(directions, origins):
        """Coordinates along a direction of each triangle from an origin of it."""
        return at @ directions.T - (directions * origins).sum(axis=1)

    height = np.abs(measured(normal, a))
    total = np.zeros(height.shape)
    for k in range(3):
        start, side = corners[:, k], corners[:, (k + 1) % 3] - corners[:, k]
        length = np.linalg.norm(side, axis=1)
        along = side / length[:, None]
        aside = -measured(np.cross(along, normal), start)
        s = -measured(along, start)
        e = s + length
        near = aside**2 + height**2
        rs, re = np.sqrt(near + s**2), np.sqrt(near + e**2)
        # Whichever of the two equal quotients does not cancel.
        behind = s + e < 0
        total += aside * np.log(np.where(behind, rs - s, re + e) / np.where(behind, re - e, rs + s))
        total -= height * (np.arctan2(aside * e, near + height * re) - np.arctan2(aside * s, near + height * rs))
    return total


def capacitance(mesh):
    """In units of 4 pi epsilon times the mesh's unit."""
    points, triangles = mesh
    corners = points[triangles]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    matrix = np.zeros((len(corners), len(corners)))
    step = max(1, BLOCK // len(corners))
    for weights in np.full((3, 3), 1 / 6) + np.eye(3) / 2:
        at = np.einsum("k,ikj->ij", weights, corners)
        for i in range(0, len(at), step):
            matrix[i : i + step] += area[i : i + step, None] / 3 * potentials(at[i : i + step], corners)
    charge = np.linalg.solve((matrix + matrix.T) / 2, area)
    return charge @ area


def series(solid, sizes, of=capacitance):
    """Numbers of triangles and capacitances, as `of` a mesh gives them, for edges of several lengths: (n, 2)."""
    found = []
    for size in sizes:
        mesh = rv.mesh(solid, size=size)
        found.append((len(mesh.triangles), of(mesh)))
        print(f"  edges {size:g}: {found[-1][0]} triangles, {found[-1][1]:.6f}")
    return np.array(found)


def limit(found, order):
    """The last two carried on to infinitely many triangles. Errors go as a power of the length, which is one over the root of the number.

    Charge grows like distance^(-1/3) towards edges of a right angle, so the order is 4/3 there; it is 2 on smooth surfaces.
    """
    (coarse, a), (fine, b) = found[-2:]
    return b + (b - a) / ((fine / coarse) ** (order / 2) - 1)


if __name__ == "__main__":
    for name, solid, sizes, order, truth in [
        ("unit cube", rv.box(size=(1, 1, 1)), (0.5, 0.25, 0.125), 4 / 3, 0.66067815),
        ("unit ball", rv.sphere(1), (0.8, 0.4), 2, 1.0),
    ]:
        print(name)
        print(f"  carried on: {limit(series(solid, sizes), order):.6f}, true {truth}")
