"""Pictures of the models with troubles: edges and faces divided by the size alone, and what `rvachev` makes.

    python3 benches/parametric/pictures.py OUT.png

On the left edges and faces divided by gmsh with one length everywhere (no curvature, no narrow places), on the right the
mesh of `rvachev` with the size of the part file. Needs gmsh, numpy and matplotlib; the command is taken from
`target/release` or from the variable RVACHEV.
"""
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import gmsh
import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.collections import PolyCollection  # noqa: E402

ROOT = Path(__file__).resolve().parent.parent.parent
OURS = os.environ.get("RVACHEV", ROOT / "target" / "release" / "rvachev")
# Name, size, direction of view, center and half width of what is shown.
SCENES = [
    ("small_hole", 5, (0.2, -0.3, 1), (0, 0, 6), 3.5),
    ("thin_ring", 4, (0.2, -0.3, 1), (0, -19, 8), 9),
    ("seam", 1, (0.3, -1, 0.6), (1, 0, 5), 9.5),
    ("poles", 0.6, (0.4, -1, 0.4), (0, 0, 8.3), 1.8),
    ("torus", 0.8, (0.3, -1, 0.9), (0, 0, 0), 9),
    ("touching_contours", 1.2, (-0.4, -0.6, 1), (2, 1.5, 6), 5),
    ("border_curvature", 1.2, (0.4, -1, 0.3), (6.8, 0, 1.6), 3.5),
    ("narrow_face", 2, (1, 1, 0.8), (9.9, 9.9, 4), 3.5),
    ("narrow_region", 1.2, (-0.1, -0.3, 1), (7.6, 0.3, 5), 1.4),
    ("sharp_edge", 0.18, (0.5, -1, 0.5), (3.8, 0.2, 0), 0.9),
]


def plain(step, size):
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.occ.importShapes(str(step))
    gmsh.model.occ.synchronize()
    for name, value in [("MeshSizeMin", size), ("MeshSizeMax", size), ("MeshSizeFromCurvature", 0),
                        ("MeshSizeExtendFromBoundary", 0), ("MinimumCircleNodes", 3), ("Algorithm", 6)]:
        gmsh.option.setNumber("Mesh." + name, value)
    try:
        gmsh.model.mesh.generate(2)
    except Exception:  # what it could not mesh is missing in the picture
        pass
    tags, xyz, _ = gmsh.model.mesh.getNodes()
    index = np.zeros(int(tags.max()) + 1, int)
    index[tags] = np.arange(len(tags))
    _, nodes = gmsh.model.mesh.getElementsByType(2)
    gmsh.finalize()
    return xyz.reshape(-1, 3), index[nodes].reshape(-1, 3)


def off(path):
    words = path.read_text().split("\n")
    n, m, _ = map(int, words[1].split())
    points = np.array([list(map(float, w.split()[:3])) for w in words[2:2 + n]])
    return points, np.array([list(map(int, w.split()[1:4])) for w in words[2 + n:2 + n + m]])


def draw(axes, points, triangles, view, center, half):
    z = np.array(view, float) / np.linalg.norm(view)
    x = np.cross((0, 0, 1), z) if abs(z[2]) < 0.99 else np.array((1.0, 0, 0))
    x /= np.linalg.norm(x)
    frame = np.array([x, np.cross(z, x), z])
    corners = (points[triangles] - center) @ frame.T
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    order = corners[:, :, 2].mean(1).argsort()
    light = 0.55 + 0.4 * np.abs(normal[order] @ (0.3, 0.4, 0.87))
    colors = np.clip(light, 0, 1)[:, None] * (0.86, 0.92, 1.0)
    axes.add_collection(PolyCollection(corners[order][:, :, :2], facecolors=colors, edgecolors="#223", linewidths=0.35))
    axes.set_xlim(-half, half)
    axes.set_ylim(-half, half)
    axes.set_aspect("equal")
    axes.set_xticks([])
    axes.set_yticks([])


def main():
    columns = 4
    rows = (2 * len(SCENES) + columns - 1) // columns
    figure, all_axes = plt.subplots(rows, columns, figsize=(2.1 * columns, 2.2 * rows))
    flat = iter(all_axes.flat)
    with tempfile.TemporaryDirectory() as folder:
        for name, size, view, center, half in SCENES:
            part = ROOT / "data" / "troubles" / f"{name}.py"
            step, mesh = Path(folder, "a.step"), Path(folder, "a.off")
            subprocess.run([OURS, "convert", part, "-q", "-o", step], check=True)
            subprocess.run([OURS, "mesh", part, "-q", "-o", mesh], check=True)
            for axes, (points, triangles), what in [(next(flat), plain(step, size), "size alone"),
                                                    (next(flat), off(mesh), "rvachev")]:
                draw(axes, points, triangles, view, np.array(center, float), half)
                axes.set_title(f"{name.replace('_', ' ')}: {what}", fontsize=7, pad=2)
    for axes in flat:
        axes.axis("off")
    figure.subplots_adjust(0.01, 0.01, 0.99, 0.97, 0.03, 0.1)
    figure.savefig(sys.argv[1], dpi=90, pil_kwargs={"optimize": True})


if __name__ == "__main__":
    main()
