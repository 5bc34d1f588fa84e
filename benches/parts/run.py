"""Function-defined parts that are hard to mesh, one after the other.

    python3 benches/parts/run.py [--size 2%] [--limit 60] [--program target/release/rvachev] [--folder target/parts]
                                 [--only NAME ...] [--markdown] [--colonnade FOLDER]

The parts are written into the folder from `parts.py` beside this: threads, gears, blades, foams, lattices, sheets of least area,
coincident planes, many solids. Some ask for a size of their own, and many solids for a longer limit. `--only` takes names with `*`.
With `--colonnade`, the `.vm` files of a folder, such as bear.vm and colonnade.vm of the fidget project, are meshed too, at 3 %
and with three times the limit. Needs Python 3.10 or newer and a release build of rvachev.

Definitions.

    leaves      functions the part is made of, after formulas are taken apart (`rvachev info --json`)
    exit        exit code; 0 is a sound mesh with nothing that falls short; `limit` where the part was not done in its CPU seconds
    attempts    how many meshes were tried, and the method of the one that was kept where it is not `leaf`
    CPU         CPU seconds of the whole command, certificate and report included, with one thread
    recall      share of the length of true sharp edges that the mesh has
    precision   share of the length of the mesh's sharp edges that are true ones
    corners     found and true
    angles      least, and the 5th percentile, in degrees
    unproved    cells of the grid that the kept attempt could not prove, of all that hold some of the surface
    teeth       nodes where a border between two names on a smooth surface turns by more than 60 degrees, of all nodes within such
                borders; true corners of a border count, too

Recall, precision and corners are those of the report's `check.features`. A part that stops at its limit has no figures. Lines below
the table tell what falls short, warnings, attempts where there were several, and why places are not proved.
"""
import argparse
import fnmatch
import json
import math
import os
import re
import resource
import struct
import subprocess
from collections import defaultdict
from pathlib import Path

from parts import Part, catalog

ROOT = Path(__file__).resolve().parent.parent.parent
HEAD = "part,leaves,exit,attempts,CPU,triangles,recall,precision,corners,least,5 %,unproved,teeth".split(",")
SMOOTH = math.cos(math.radians(15))  # two triangles that bend less are no edge at any size used here
TOOTH = math.cos(math.radians(60))  # a border that follows triangles at random turns by 60 degrees; a smooth one by far less


def run(command, limit):
    """Exit code (None at the limit), CPU seconds and what was printed."""

    def limited():
        resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 5))

    child = subprocess.Popen(list(map(str, command)), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, preexec_fn=limited)
    printed = child.stdout.read().decode(errors="replace")
    _, status, used = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    return (None if child.returncode < 0 else child.returncode), used.ru_utime + used.ru_stime, printed


def read_ply(path):
    """Nodes, triangles and the label of each triangle, as rvachev writes them."""
    data = path.read_bytes()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    head = data[:end].decode(errors="replace")
    count = {k: int(n) for k, n in re.findall(r"element (\w+) (\d+)", head)}
    nodes = list(struct.iter_unpack("<3d", data[end:end + 24 * count["vertex"]]))
    triangles = [t[1:] for t in struct.iter_unpack("<B3i", data[end + 24 * count["vertex"]:])]
    labels = []
    for label, times in re.findall(r"(\d+)\*(\d+)", " ".join(re.findall(r"comment labels (.*)", head))):
        labels += [label] * int(times)
    return nodes, triangles, labels


def across(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a, b):
    d = [q - p for p, q in zip(a, b)]
    length = math.hypot(*d) or 1
    return [v / length for v in d]


def teeth(path):
    """Teeth of smooth borders between names, and how many nodes these borders have."""
    nodes, triangles, labels = read_ply(path)
    if len(labels) != len(triangles):
        return None
    sides = defaultdict(list)
    for k, (a, b, c) in enumerate(triangles):
        for e in ((a, b), (b, c), (c, a)):
            sides[min(e), max(e)].append(k)

    def normal(k):
        a, b, c = (nodes[i] for i in triangles[k])
        n = across([q - p for p, q in zip(a, b)], [q - p for p, q in zip(a, c)])
        return unit((0, 0, 0), n)

    ways = defaultdict(list)
    for (a, b), at in sides.items():
        if len(at) == 2 and labels[at[0]] != labels[at[1]]:
            if sum(p * q for p, q in zip(normal(at[0]), normal(at[1]))) > SMOOTH:
                pair = tuple(sorted((labels[at[0]], labels[at[1]])))
                ways[a, pair].append(b)
                ways[b, pair].append(a)
    between = [(n[0], ends) for n, ends in ways.items() if len(ends) == 2]
    turns = [sum(p * q for p, q in zip(unit(nodes[e[0]], nodes[n]), unit(nodes[n], nodes[e[1]]))) for n, e in between]
    return sum(t < TOOTH for t in turns), len(between)


def row(part, path, args):
    """The cells of a part's row and the lines about it."""
    limit = args.limit * part.patience
    code, _, printed = run([args.program, "info", path, "--json"], limit)
    leaves = json.loads(printed[printed.index("{"):])["leaves"] if code == 0 else "-"
    mesh, report = path.with_suffix(".ply"), path.with_suffix(".json")
    for old in (mesh, report):
        old.unlink(missing_ok=True)
    command = [args.program, "mesh", path, "--size", part.size or args.size, "--threads", 1, "-v", "--force"]
    code, cpu, printed = run([*command, "-o", mesh, "--report", report], limit)
    path.with_suffix(".log").write_text(printed)
    name = part.name + (f" ({part.size})" if part.size else "")
    cells = [name, leaves, "limit" if code is None else code, "-", f"{cpu:.1f}"] + ["-"] * (len(HEAD) - 5)
    told = json.loads(report.read_text()) if report.exists() else {}
    lines = [f"falls short: {fault['message']}" for fault in told.get("shortfalls", [])]
    lines += [f"warning: {text}" for text in told.get("warnings", [])]
    if not told:
        return cells, lines + printed.strip().splitlines()[-2:]
    tried = told["attempts"]
    cells[3] = len(tried) if told["method"] == "leaf" else f"{len(tried)}, {told['method']}"
    check = told.get("check") or {}
    if check:
        cells[5] = check["triangles"]
        cells[9], cells[10] = (f"{check['quality'][k]:.1f}" for k in ("min_angle", "p05_angle"))
    edges = check.get("features")
    if edges:
        cells[6], cells[7] = f"{edges['recall']:.3f}", f"{edges['precision']:.3f}"
        cells[8] = f"{edges['corners_found']}/{edges['corners_true']}"
    proof = next((a["proof"] for a in tried if a["kept"] and a.get("proof")), None)
    if proof:
        cells[11] = f"{proof['unproved']} of {proof['cells']}"
        reasons = defaultdict(int)
        for place in proof["places"]:
            reasons[place["reason"]] += 1
        if reasons:
            lines.append("first places not proved: " + ", ".join(f"{n} {why}" for why, n in sorted(reasons.items())))
    if mesh.exists():
        found = teeth(mesh)
        cells[12] = "-" if found is None else f"{found[0]} of {found[1]}"
    lines += [f"attempt {i + 1}: {a['rung']}, {a['change']}, because {a.get('because') or '-'}; {a['triangles']} triangles, "
              f"{a['faults']} faults; {'kept' if a['kept'] else a['why']}" for i, a in enumerate(tried) if len(tried) > 1]
    return cells, lines


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--size", default="2%")
    parser.add_argument("--limit", type=int, default=60, help="CPU seconds for a part")
    parser.add_argument("--program", type=Path, default=ROOT / "target" / "release" / "rvachev")
    parser.add_argument("--folder", type=Path, default=ROOT / "target" / "parts")
    parser.add_argument("--only", nargs="+", default=["*"], metavar="NAME")
    parser.add_argument("--markdown", action="store_true")
    parser.add_argument("--colonnade", type=Path, metavar="FOLDER")
    args = parser.parse_args()
    args.folder.mkdir(parents=True, exist_ok=True)
    work = []
    for part in catalog():
        path = args.folder / f"{part.name}.py"
        path.write_text(part.text)
        work.append((part, path))
    for source in sorted(args.colonnade.glob("*.vm")) if args.colonnade else []:
        path = args.folder / source.name
        path.write_bytes(source.read_bytes())
        work.append((Part(source.stem, "formula of another program", "", "3%", 3), path))
    between, edge = (" | ", "| ") if args.markdown else ("  ", "")
    widths = [26] + [10] * (len(HEAD) - 1)

    def printed(cells):
        padded = cells if args.markdown else [str(c).ljust(w) for c, w in zip(cells, widths)]
        print((edge + between.join(map(str, padded)) + edge[::-1]).rstrip(), flush=True)

    printed(HEAD)
    if args.markdown:
        printed(["---"] * len(HEAD))
    notes = []
    for part, path in work:
        if any(fnmatch.fnmatchcase(part.name, wanted) for wanted in args.only):
            cells, lines = row(part, path, args)
            printed(cells)
            notes += [f"{part.name}: {line}" for line in lines]
    print("", *notes, sep="\n")


if __name__ == "__main__":
    main()
