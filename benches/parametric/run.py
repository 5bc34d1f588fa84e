"""rvachev beside gmsh and Netgen on STEP models: the same number of triangles asked for, one thread, one run.

    python3 benches/parametric/run.py CORPUS [--models REGEX] [--programs rvachev,gmsh5,gmsh6,netgen] [--python PYTHON]

CORPUS is a folder of STEP files with a table MANIFEST.tsv: a line per file with the columns `file`, `half` (the folder
it is in), `unique_faces`, `free_edges` and `area`. Prints Markdown: the table of `benches/parametric.md` and a line per model;
an interrupt ends it early with what was measured until then.
Needs Unix and Python 3.10 or newer with `venv`; installs the peers from the pinned `requirements.txt` below
`target/peers-env` unless `--python` names an interpreter that has them.

Asked for are 40 triangles per face, between 3000 and 20 000. Sizes are changed at most twice to come within 30 % of that, no
program is tuned to a model. *Valid*: every face meshed, closed where the model is, a manifold, no body intersects itself,
by `rvachev check`, within 60 CPU seconds (a mesh of ours, all meshes of a peer; `--limit` changes that). Times are CPU seconds: of the peers without reading, of ours of the whole process with reading, certificate and writing.
"""
import argparse
import csv
import hashlib
import json
import math
import os
import re
import resource
import shutil
import signal
import statistics
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
TARGET = HERE.parent.parent / "target"
OURS = Path(os.environ.get("RVACHEV", TARGET / "release" / "rvachev"))
OUT = TARGET / "parametric-bench"
LIMIT = 60
WALL = 5
CLEAN = {**{k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "PYTHONHOME")},
         "PYTHONDONTWRITEBYTECODE": "1", "OMP_NUM_THREADS": "1", "RAYON_NUM_THREADS": "1"}


def environment():
    wanted = HERE / "requirements.txt"
    key = hashlib.sha256(wanted.read_bytes() + sys.version.encode()).hexdigest()[:16]
    folder = TARGET / "peers-env" / f"parametric-{key}"
    python = folder / "bin" / "python"
    if not (folder / "ready").exists():
        print(f"# installing the peers below {folder}", file=sys.stderr)
        shutil.rmtree(folder, ignore_errors=True)
        subprocess.run([sys.executable, "-m", "venv", folder], check=True)
        subprocess.run([python, "-m", "pip", "install", "--quiet", "-r", wanted], check=True)
        (folder / "ready").touch()
    return python


def timed(command, limit):
    """(CPU seconds, exit code or None when it took too long, standard output). On a busy machine CPU time is what counts."""
    def bounded():
        resource.setrlimit(resource.RLIMIT_CPU, (int(limit), int(limit) + 5))
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    try:
        done = subprocess.run([str(c) for c in command], env=CLEAN, capture_output=True, text=True, timeout=WALL * limit,
                              preexec_fn=bounded)
        code, text = done.returncode, done.stdout
        if code in (-signal.SIGXCPU, -signal.SIGKILL):
            code = None
    except subprocess.TimeoutExpired as e:
        code, text = None, (e.stdout or b"").decode(errors="replace")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime, code, text


def bodies(path):
    """The connected parts of an OFF file, as OFF files, where there are several."""
    lines = path.read_text().split("\n")
    nodes, triangles, _ = map(int, lines[1].split())
    corner = [tuple(map(int, line.split()[1:4])) for line in lines[2 + nodes:2 + nodes + triangles]]
    leader = list(range(nodes))

    def find(i):
        while leader[i] != i:
            leader[i] = leader[leader[i]]
            i = leader[i]
        return i
    for a, b, c in corner:
        for x in (b, c):
            i, j = find(a), find(x)
            leader[max(i, j)] = min(i, j)
    parts = {}
    for t in corner:
        parts.setdefault(find(t[0]), []).append(t)
    if len(parts) < 2:
        return [path]
    out = []
    for k, part in enumerate(parts.values()):
        number = {}
        for t in part:
            for v in t:
                number.setdefault(v, len(number))
        file = OUT / f"part{k}.off"
        body = [lines[2 + v] for v in number] + ["3 %d %d %d" % tuple(number[v] for v in t) for t in part]
        file.write_text("\n".join(["OFF", f"{len(number)} {len(part)} 0", *body, ""]))
        out.append(file)
    return out


def check(path):
    return json.loads(timed([OURS, "check", path, "--json"], 600)[2])


def judge(row, mesh, whole):
    """What `check` says, and whether the mesh is valid."""
    found = check(mesh)
    hits = found["self_intersections"]
    if hits:
        hits = sum(check(p)["self_intersections"] for p in bodies(mesh))
    q = found["quality"]
    closed = found["closed"] or int(row["free_edges"]) > 0
    return {"valid": bool(whole and closed and found["manifold"] and hits == 0), "least": q["min_angle"],
            "p05": q["p05_angle"], "rr": q["mean_radius_ratio"], "below": q["below_20"]}


def ours(row, file, target):
    mesh, report = OUT / "rvachev.off", OUT / "rvachev.json"
    h, spent, result = math.sqrt(float(row["area"]) / target / 0.433), 0.0, None
    for _ in range(3):
        report.unlink(missing_ok=True)
        seconds, code, _ = timed([OURS, "mesh", file, "--size", repr(h), "--threads", "1", "--force", "-q", "-o", mesh,
                                  "--report", report], LIMIT)
        spent += seconds
        if code is None or not report.exists():
            return result or {"hang": code is None, "triangles": 0}
        told = json.loads(report.read_text())
        result = {"triangles": told["check"]["triangles"], "seconds": seconds, "code": code,
                  "whole": not any(s["kind"] in ("no_mesh", "not_read") for s in told["shortfalls"])}
        ratio = result["triangles"] / target
        if 1 / 1.3 < ratio < 1.3 or spent > 14:
            break
        h *= min(max(math.sqrt(ratio), 1 / 12), 12)
    return result | judge(row, mesh, result["whole"])


def theirs(python, peer, row, file, target):
    mesh = OUT / f"{peer}.off"
    mesh.unlink(missing_ok=True)
    _, code, text = timed([python, HERE / "peer.py", peer, file, mesh, target, row["area"]], LIMIT)
    lines = [json.loads(line) for line in text.splitlines() if line.startswith("{") and line.endswith("}")]
    if not lines or not mesh.exists():
        return {"hang": code is None, "crash": code not in (0, None), "triangles": 0}
    last = lines[-1]
    result = {"triangles": last["triangles"], "seconds": last["mesh"], "hang": code is None}
    return result | judge(row, mesh, code == 0 and last["failed"] == 0)


def table(rows, results, programs):
    print("| | " + " | ".join(programs) + " |\n|---|" + "---|" * len(programs))

    def line(name, cell):
        print(f"| {name} | " + " | ".join(cell([r for r in results[p] if r], p) for p in programs) + " |")
    good = lambda rs: [r for r in rs if "p05" in r]
    median = lambda xs: statistics.median(xs) if xs else float("nan")
    line(f"valid of {len(rows)}", lambda rs, p: str(sum(r.get("valid", False) for r in rs)))
    line("over the time limit, crashed", lambda rs, p: f"{sum(r.get('hang', False) for r in rs)}, {sum(r.get('crash', False) for r in rs)}")
    line("more than 3 times the triangles asked for", lambda rs, p: str(sum(r["triangles"] > 3 * r["target"] for r in rs)))
    line("least angle above 20 degrees", lambda rs, p: f"{100 * sum(r['least'] > 20 for r in good(rs)) / len(rs):.0f} %")
    line("triangles below 20 degrees, of all",
         lambda rs, p: f"{100 * sum(r['below'] * r['triangles'] for r in good(rs)) / max(1, sum(r['triangles'] for r in good(rs))):.2f} %")
    line("median of the 5th-percentile angle", lambda rs, p: f"{median([r['p05'] for r in good(rs)]):.1f}")
    line("median of mean 2r/R", lambda rs, p: f"{median([r['rr'] for r in good(rs)]):.3f}")
    line("median of ktri/s", lambda rs, p: f"{median([r['triangles'] / max(r['seconds'], 1e-3) / 1e3 for r in good(rs)]):.0f}")


def main():
    # Also where it was started in the background: an interrupt ends the run and prints what there is.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    arguments = argparse.ArgumentParser()
    arguments.add_argument("corpus", type=Path)
    arguments.add_argument("--models", default=".")
    arguments.add_argument("--programs", default="rvachev,gmsh5,gmsh6,netgen")
    arguments.add_argument("--python")
    arguments.add_argument("--limit", type=int, default=LIMIT, metavar="SECONDS")
    a = arguments.parse_args()
    globals()["LIMIT"] = a.limit
    programs = a.programs.split(",")
    python = a.python or (environment() if programs != ["rvachev"] else None)
    OUT.mkdir(parents=True, exist_ok=True)
    with open(a.corpus / "MANIFEST.tsv") as f:
        rows = [r for r in csv.DictReader(f, delimiter="\t") if re.search(a.models, r["file"])]
    rows = [r for r in rows if (a.corpus / r["half"] / r["file"]).exists()]
    rows.sort(key=lambda r: int(r["unique_faces"]))
    results = {p: [] for p in programs}
    done = []
    try:
        for row in rows:
            one(a, row, programs, python, results)
            done.append(row)
    except KeyboardInterrupt:
        print("# stopped: the tables hold what was measured until then", file=sys.stderr)
    tell(done, {p: r[:len(done)] for p, r in results.items()}, programs)


def one(a, row, programs, python, results):
    file = a.corpus / row["half"] / row["file"]
    target = min(20000, max(3000, 40 * int(row["unique_faces"])))
    for p in programs:
        r = ours(row, file, target) if p == "rvachev" else theirs(python, p, row, file, target)
        results[p].append({**r, "target": target})
    print(f"# {row['file']}", *(p + (" ok" if results[p][-1].get("valid") else " -") for p in programs), file=sys.stderr,
          flush=True)


def tell(rows, results, programs):
    table(rows, results, programs)
    print("\n| model | " + " | ".join(programs) + " |\n|---|" + "---|" * len(programs))
    for k, row in enumerate(rows):
        def cell(r):
            if "p05" not in r:
                return "time limit" if r.get("hang") else "none"
            return (f"{'valid' if r['valid'] else 'not valid'}, {r['triangles'] / r['target']:.2f}, {r['least']:.1f}, {r['p05']:.1f}, "
                    f"{r['rr']:.3f}, {r['seconds']:.2f} s")
        print(f"| {row['file']} | " + " | ".join(cell(results[p][k]) for p in programs) + " |")


if __name__ == "__main__":
    main()
