"""Pictures of the models with troubles: what goes wrong, and what `rvachev` makes.

    python3 benches/parametric/pictures.py sizes OUT.png
    python3 benches/parametric/pictures.py remedies OUT.png

`sizes`: on the left edges and faces divided by gmsh with one length everywhere (no curvature, no narrow places), on the
right the mesh of `rvachev` with the size of the part file.

`remedies`: on the left the mesh of `rvachev` without one remedy (`mesh --without NAME`), on the right the mesh with it. The
line above each picture is made of figures of the report. Gray-brown is the back of a triangle: it shows where a face is missing.

Needs numpy and matplotlib (which brings Pillow), `sizes` gmsh, too. The command is taken from `target/release` or from the
variable RVACHEV.
"""
import io
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib
import numpy as np
from PIL import Image

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
# Remedy, model, further options, what goes wrong without it, direction of view, center and half width of what is shown, and how
# many times higher than wide it is drawn.
REMEDIES = [
    ("halving", "crossing_contours.py", [], "contours cross once divided", (0, 0, 1), (0, -19.2, 8), 6.5, 3),
    ("least-length", "least_length.py", [], "fine along a narrow face", (0.7, -0.8, 0.5), (10, -10, 6.7), 1.7, 1),
    ("plane", "open_pole.step", [], "a surface ends before its pole", (0.4, -1, 0.9), (0, 0, 0.3), 3.1, 1),
    ("inset", "wide_tip.py", ["--tol", "0.1"], "curvature at a tip", (0.3, -1, 0.9), (0, 0, 1.66), 0.25, 1),
    ("trim", "narrow_neck.py", [], "a region 0.004 wide", (0, 0, 1), (10, 0.002, 3), 2.3, 300),
]
FRONT, BACK = (0.86, 0.92, 1.0), (0.62, 0.5, 0.42)


def plain(step, size):
    import gmsh

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


def draw(axes, points, triangles, view, center, half, stretch=1):
    z = np.array(view, float) / np.linalg.norm(view)
    x = np.cross((0, 0, 1), z) if abs(z[2]) < 0.99 else np.array((1.0, 0, 0))
    x /= np.linalg.norm(x)
    frame = np.array([x, np.cross(z, x), z])
    corners = (points[triangles] - center) @ frame.T
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    order = corners[:, :, 2].mean(1).argsort()
    light = 0.55 + 0.4 * np.abs(normal[order] @ (0.3, 0.4, 0.87))
    colors = np.clip(light, 0, 1)[:, None] * np.where(normal[order][:, 2:] < 0, BACK, FRONT)
    axes.add_collection(PolyCollection(corners[order][:, :, :2], facecolors=colors, edgecolors="#223", linewidths=0.35))
    axes.set_xlim(-half, half)
    axes.set_ylim(-half / stretch, half / stretch)
    axes.set_aspect(stretch)
    axes.set_xticks([])
    axes.set_yticks([])


def save(figure, path):
    drawn = io.BytesIO()
    figure.savefig(drawn, dpi=90)
    # Few colors are in it: a palette makes the file a third as large.
    Image.open(drawn).convert("RGB").quantize(96).save(path, optimize=True)


def sizes(path):
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
    save(figure, path)


def figures(report):
    """What the report says of a mesh, in one line: faces that lack, else the number of triangles and the angles."""
    check = report["check"]
    lacking = [f for f in report["shortfalls"] if f["kind"] == "no_mesh"]
    if lacking:
        return f"{len(lacking)} face{'s' * (len(lacking) > 1)} without triangles, not closed"
    quality = check["quality"]
    return f"{check['triangles']} triangles, angles {quality['min_angle']:.1f} to {quality['max_angle']:.0f} degrees"


def remedies(path):
    figure, all_axes = plt.subplots(len(REMEDIES), 2, figsize=(7.2, 3.75 * len(REMEDIES)))
    with tempfile.TemporaryDirectory() as folder:
        mesh, told = Path(folder, "a.off"), Path(folder, "a.json")
        for row, (name, model, options, wrong, view, center, half, stretch) in zip(all_axes, REMEDIES):
            for axes, left_out in zip(row, [["--without", name], []]):
                command = [OURS, "mesh", ROOT / "data" / "troubles" / model, *options, *left_out]
                # Exit code 1 is what a mesh without its remedy may end with; `--force` has it written.
                done = subprocess.run([*command, "--force", "-q", "-o", mesh, "--report", told], capture_output=True)
                if done.returncode not in (0, 1):
                    sys.exit(done.stderr.decode())
                draw(axes, *off(mesh), view, np.array(center, float), half, stretch)
                what = f"without {name}: {wrong}" if left_out else f"with {name}"
                what += f" ({stretch} times as high)" if stretch != 1 else ""
                axes.set_title(f"{what}\n{figures(json.loads(told.read_text()))}", fontsize=7, pad=3)
    figure.subplots_adjust(0.01, 0.005, 0.99, 0.975, 0.03, 0.12)
    save(figure, path)


def main():
    kinds = {"sizes": sizes, "remedies": remedies}
    if len(sys.argv) != 3 or sys.argv[1] not in kinds:
        sys.exit(__doc__)
    kinds[sys.argv[1]](sys.argv[2])


if __name__ == "__main__":
    main()
