"""Trees of functions of other programs, meshed and measured: the examples of implicit complexes.

    python3 benches/complexes.py FOLDER [--size 3% 1%] [--box BOX] [--program target/release/rvachev] [--markdown]

FOLDER holds, in folders of their own, a list of functions and a tree for each example: the data of Ju, Du, Zhou, Carr, Ju, Adaptive grid
generation for discretizing implicit complexes (ACM TOG 43, 2024), which are not in this repository. Functions are
`[{"type": "plane" | "sphere" | "cylinder" | "torus" | "cone", ...}]`, trees `[{"type": "Intersection" | "Union" | "Negation",
"elements": [i, j]}]`, where `-k` is function k and `k` is node k. Inside is where the root's value is negative. The part is what is inside of
a box, by default of side 4 about the origin.

Columns.

    functions   of the example
    exit        exit code; attempts are meshes that were tried
    triangles   of the finished mesh
    euler       Euler characteristic
    distance    the largest distance of the mesh from the surface
    recall      sharp edges that are found, by length
    cells       seconds of grid and arrangement with one thread: the stages cells, signs, surface, arrange and settle
    all         CPU seconds of the whole command

Needs Python 3.10 or newer and a release build of rvachev.
"""
import argparse
import json
import math
import os
import subprocess
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
ARRANGING = ("cells", "signs", "surface", "arrange", "settle")


def vector(v):
    return "(" + ", ".join(repr(float(x)) for x in v) + ")"


def unit(v):
    length = math.sqrt(sum(x * x for x in v))
    return [x / length for x in v]


def solid(f, name):
    """The solid where a function is negative: planes grow along their normal, all others are positive inside."""
    if f["type"] == "plane":
        return f'half_space({vector(f["normal"])}, at={vector(f["point"])}).name("{name}")'
    if f["type"] == "sphere":
        return f'~sphere({f["radius"]!r}, at={vector(f["center"])}).name("{name}")'
    if f["type"] == "cylinder":
        at = f.get("axis_point", f.get("axis_point1"))
        axis = f.get("axis_vector") or [b - a for a, b in zip(f["axis_point1"], f["axis_point2"])]
        return f'~cylinder({f["radius"]!r}, axis={vector(axis)}, at={vector(at)}).name("{name}")'
    axis = unit(f["axis_vector"])
    if f["type"] == "torus":
        radii = f'{f["major_radius"]!r}, {f["minor_radius"]!r}'
        return f'~torus({radii}, axis={vector(axis)}, at={vector(f["center"])}).name("{name}")'
    if f["type"] == "cone":
        x, y, z = (f"({c} - ({float(o)!r}))" for c, o in zip("xyz", f["apex"]))
        height = " + ".join(f"({a!r})*{c}" for a, c in zip(axis, (x, y, z)))
        return f'solid({height} <= {math.cos(f["apex_angle"])!r}*hypot({x}, {y}, {z})).name("{name}")'
    raise ValueError(f"no function {f['type']!r}")


def written(functions, tree, box):
    lines = [f"s{k} = {solid(f, f'f{k}')}" for k, f in enumerate(functions, 1)]

    def node(k):
        if k < 0:
            return f"s{-k}"
        of = tree[k - 1]
        if of["type"] == "Negation":
            return f"~{node(of['elements'][0])}"
        sign = " & " if of["type"] == "Intersection" else " | "
        return "(" + sign.join(node(e) for e in of["elements"]) + ")"

    return "\n".join([*lines, f"part({node(1)}, domain={box})", ""])


def examples(folder):
    """Pairs of files of functions and trees that belong together: the tree is named as the functions are."""
    for tree in sorted(folder.rglob("*tree.json")):
        functions = tree.with_name(tree.name.replace("_tree", "").replace("-tree", ""))
        if functions.exists():
            yield tree.parent.name, functions, tree


def measured(program, part, size):
    with tempfile.TemporaryDirectory() as folder:
        mesh, report = Path(folder) / "mesh.ply", Path(folder) / "report.json"
        before = os.times()
        command = [program, "mesh", part, "-o", mesh, "--report", report, "--size", size, "--threads", "1", "-q"]
        done = subprocess.run(command, capture_output=True, text=True)
        after = os.times()
        if not report.exists():
            raise SystemExit(f"{part}: {done.stderr.strip()}")
        seconds = after.children_user + after.children_system - before.children_user - before.children_system
        return done.returncode, json.loads(report.read_text()), seconds


def main():
    args = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    args.add_argument("folder", type=Path)
    args.add_argument("--size", nargs="+", default=["3%", "1%"])
    args.add_argument("--box", default="((-2, -2, -2), (2, 2, 2))")
    args.add_argument("--program", default=ROOT / "target/release/rvachev")
    args.add_argument("--markdown", action="store_true")
    args = args.parse_args()
    head = ["example", "functions", "size", "exit", "attempts", "triangles", "euler", "distance", "recall", "cells", "all"]
    rows = [head, ["---"] * len(head)] if args.markdown else [head]
    for name, functions, tree in examples(args.folder):
        given = json.loads(functions.read_text())
        given = given["input"] if isinstance(given, dict) else given
        with tempfile.NamedTemporaryFile("w", suffix=".py", delete=False) as part:
            part.write(written(given, json.loads(tree.read_text()), args.box))
        for size in args.size:
            code, report, seconds = measured(args.program, part.name, size)
            check, attempts = report["check"], report["attempts"]
            stages = [s for a in attempts for s in a["stages"] if s["name"] in ARRANGING]
            rows.append([
                name, len(given), size, code, len(attempts), check["triangles"], check["euler"],
                f"{check['deviation']['max']:.1e}", f"{check['features']['recall']:.3f}",
                f"{sum(s['seconds'] for s in stages):.2f}", f"{seconds:.2f}",
            ])
        os.unlink(part.name)
    for row in rows:
        cells = [str(c) for c in row]
        print("| " + " | ".join(cells) + " |" if args.markdown else "  ".join(c.rjust(9) for c in cells))


if __name__ == "__main__":
    main()
