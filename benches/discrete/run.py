"""rvachev beside other remeshers on triangle soups: the same models, the same number of triangles, one run.

    python3 benches/discrete/run.py FOLDER [--models a.stl,b.off] [--sizes 0.04,0.02,0.01] [--peers mmg,pymeshlab,gmsh]
                                    [--out target/discrete/results.jsonl]

FOLDER holds closed triangle meshes (STL, OFF, OBJ, PLY); without `--models` all of them are run. Sizes are shares of the
diagonal. Needs Python 3.10 or newer with what `requirements.txt` names, and a release build of rvachev. Prints one Markdown
table for the models that have sharp edges by the name lists below, one for the others.

Definitions. L is the size, N = area / (sqrt(3)/4 L^2). Every program is asked for L; where it gives fewer than 0.87 N or
more than 1.15 N triangles it is asked again with a corrected size, twice at most, and the nearest count is kept. Features
of the input are edges whose normals differ by more than 40 degrees, sampled every L/10; the floor is what even spacing at L
of the same curves would miss by its chords alone.

    success   closed manifold, topology of the input, no self-intersection the input has not, and for models with features
              rms distance of features to mesh edges at most 0.01 L + 1.25 floors, sharp edges within 5 % of L over
              98 % of their length or all but 1 % of what the floor allows
    good      success, mean 2r/R >= 0.95, 5th percentile >= 40 degrees, smallest angle >= 20 degrees, count within 15 %

CPU seconds are user and system of one process with one thread: ours from start to end, file reading and certificate
included; the peers' without imports and files.
"""
import argparse
import json
import os
import resource
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent.parent
OURS = Path(os.environ.get("RVACHEV", ROOT / "target" / "release" / "rvachev"))
FEATURED = {"igl_fandisk", "cg_anchor_dense", "cg_joint", "gen_flange", "tm_plate_holes", "ps_M3_hex_nut",
            "gen_smallfeatures", "tm_1002_tray_bottom", "cg_pinion", "gen_plate_holes", "cg_spool", "ps_extruder_idler",
            "tm_large_block", "c3_rocker-arm", "cg_dragknob"}
ANGLE = 35.0  # given to the peers: features are measured at 40


# ------------------------------------------------------------------------------------------------------------- meshes

def load(path):
    import trimesh
    m = trimesh.load(path, process=False, force="mesh")
    v, f = np.asarray(m.vertices, float), np.asarray(m.faces, int)
    if Path(path).suffix.lower() in (".stl", ".stla"):
        v, inverse = np.unique(v[f].reshape(-1, 3) + 0.0, axis=0, return_inverse=True)
        f = inverse.reshape(-1, 3)
    return v, f


def save_off(path, v, f):
    with open(path, "w") as out:
        out.write(f"OFF\n{len(v)} {len(f)} 0\n")
        np.savetxt(out, v, fmt="%.17g")
        np.savetxt(out, np.c_[np.full(len(f), 3), f], fmt="%d")


def edges(f):
    """Undirected edges, how many triangles each has, and for each edge of two its triangles."""
    half = np.concatenate([f[:, [0, 1]], f[:, [1, 2]], f[:, [2, 0]]])
    triangle = np.tile(np.arange(len(f)), 3)
    e, inverse, count = np.unique(np.sort(half, axis=1), axis=0, return_inverse=True, return_counts=True)
    order = np.argsort(inverse.ravel(), kind="stable")
    start = np.r_[0, np.cumsum(count)[:-1]]
    two = count == 2
    return e, count, two, triangle[order[start[two]]], triangle[order[start[two] + 1]]


def sharp_edges(v, f, degrees):
    t = v[f]
    n = np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0])
    length = np.linalg.norm(n, axis=1, keepdims=True)
    n = n / np.where(length > 0, length, 1)
    e, _, two, a, b = edges(f)
    found = ~two
    flat = (length[a, 0] > 0) & (length[b, 0] > 0)
    found[two] = ((n[a] * n[b]).sum(1) < np.cos(np.radians(degrees))) & flat
    return e[found]


def samples(v, e, step):
    a, b = v[e[:, 0]], v[e[:, 1]]
    length = np.linalg.norm(b - a, axis=1)
    k = np.maximum(1, np.ceil(length / step).astype(int))
    i = np.repeat(np.arange(len(e)), k)
    t = (np.arange(len(i)) - np.repeat(np.cumsum(k) - k, k) + 0.5) / k[i]
    return a[i] + (b - a)[i] * t[:, None], (length / k)[i]


def to_segments(p, v, e):
    import igl
    if not len(e):
        return np.full(len(p), np.inf)
    square = igl.point_mesh_squared_distance(np.ascontiguousarray(p), np.ascontiguousarray(v),
                                             np.ascontiguousarray(e.astype(np.int64)))[0]
    return np.sqrt(np.maximum(0, square))


def chains(v, e, turn=40.0):
    """Feature curves between nodes where other than two edges meet or the curve turns."""
    near = {}
    for k, (a, b) in enumerate(e):
        near.setdefault(a, []).append((b, k))
        near.setdefault(b, []).append((a, k))

    def is_corner(x):
        if len(near[x]) != 2:
            return True
        p, q = v[near[x][0][0]] - v[x], v[x] - v[near[x][1][0]]
        return p @ q < np.cos(np.radians(turn)) * np.linalg.norm(p) * np.linalg.norm(q)

    corners, used, out = {x for x in near if is_corner(x)}, set(), []
    for start in [*sorted(corners), *sorted(set(near) - corners)]:
        for x, k in near[start]:
            if k in used:
                continue
            chain, at = [start], start
            while True:
                used.add(k)
                chain.append(x)
                at = x
                if at in corners or at == start:
                    break
                onward = [y for y in near[at] if y[1] not in used]
                if not onward:
                    break
                x, k = onward[0]
            out.append(chain)
    return out


def floor_distance(v, e, size, p):
    nodes, segments, first = [], [], 0
    for chain in chains(v, e):
        q = v[np.array(chain)]
        s = np.r_[0, np.cumsum(np.linalg.norm(np.diff(q, axis=0), axis=1))]
        n = max(3 if chain[0] == chain[-1] else 1, int(round(s[-1] / size)))
        t = np.linspace(0, s[-1], n + 1)
        nodes.append(np.stack([np.interp(t, s, q[:, k]) for k in range(3)], 1))
        segments.append(np.c_[np.arange(n), np.arange(1, n + 1)] + first)
        first += n + 1
    return to_segments(p, np.concatenate(nodes), np.concatenate(segments))


def quality(v, f):
    t = v[f]
    length = np.stack([np.linalg.norm(t[:, (i + 2) % 3] - t[:, (i + 1) % 3], axis=1) for i in range(3)], 1)
    double = np.linalg.norm(np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0]), axis=1)
    a, b, c = length.T
    cosines = np.stack([(b * b + c * c - a * a) / (2 * b * c), (a * a + c * c - b * b) / (2 * a * c),
                        (a * a + b * b - c * c) / (2 * a * b)], 1)
    smallest = np.degrees(np.arccos(np.clip(cosines, -1, 1))).min(1)
    ratio = np.where(double > 0, 4 * double * double / ((a + b + c) * a * b * c), 0)
    return {"min": smallest.min(), "p5": np.percentile(smallest, 5), "ratio": ratio.mean(),
            "below20": 100 * (smallest < 20).mean()}


def checked(path):
    out = subprocess.run([OURS, "check", path, "--json"], capture_output=True, text=True)
    return json.loads(out.stdout)


# ----------------------------------------------------------------------------------------------------------- programs

def run_ours(source, size, out):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([OURS, "mesh", source, "-o", out, "--size", repr(size), "--threads", "1", "-q"],
                          capture_output=True, text=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if not Path(out).exists():
        raise RuntimeError(done.stderr.strip()[-200:])
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def peer_main(peer, source, size, out):
    """In a process of its own: a peer may crash, and its CPU time is its own."""
    v, f = load(source)
    size = float(size)
    if peer == "mmg":
        import mmgpy
        began = time.process_time()
        m = mmgpy.MmgMeshS()
        m.set_mesh_size(vertices=len(v), triangles=len(f))
        m.set_vertices(v)
        m.set_triangles(f.astype(np.int32))
        m.remesh(hsiz=size, hausd=0.05 * size, ar=ANGLE, hgrad=1.3, verbose=-1)
        v, f = np.asarray(m.get_vertices(), float), np.asarray(m.get_triangles(), int)
    elif peer == "pymeshlab":
        import pymeshlab as ml
        began = time.process_time()
        s = ml.MeshSet()
        s.add_mesh(ml.Mesh(v, f.astype(np.int32)))
        s.meshing_isotropic_explicit_remeshing(iterations=10, adaptive=False, targetlen=ml.PureValue(size),
                                               featuredeg=ANGLE, checksurfdist=True, maxsurfdist=ml.PureValue(0.1 * size))
        v, f = s.current_mesh().vertex_matrix(), s.current_mesh().face_matrix()
    else:
        import gmsh
        began = time.process_time()
        gmsh.initialize()
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("General.NumThreads", 1)
        surface = gmsh.model.addDiscreteEntity(2)
        gmsh.model.mesh.addNodes(2, surface, np.arange(1, len(v) + 1), v.ravel())
        gmsh.model.mesh.addElementsByType(surface, 2, [], (f + 1).ravel())
        gmsh.model.mesh.classifySurfaces(np.radians(ANGLE), True, True, np.pi)
        gmsh.model.mesh.createGeometry()
        gmsh.model.geo.synchronize()
        for name in ("Mesh.MeshSizeMin", "Mesh.MeshSizeMax"):
            gmsh.option.setNumber(name, size)
        for name in ("Mesh.MeshSizeExtendFromBoundary", "Mesh.MeshSizeFromPoints", "Mesh.MeshSizeFromCurvature"):
            gmsh.option.setNumber(name, 0)
        gmsh.option.setNumber("Mesh.Algorithm", 6)
        gmsh.model.mesh.generate(2)
        tags, xyz, _ = gmsh.model.mesh.getNodes()
        _, corners = gmsh.model.mesh.getElementsByType(2)
        place = np.zeros(int(max(tags)) + 1, int)
        place[np.asarray(tags, int)] = np.arange(len(tags))
        v, f = np.asarray(xyz).reshape(-1, 3), place[np.asarray(corners, int)].reshape(-1, 3)
    spent = time.process_time() - began
    used, inverse = np.unique(f.ravel(), return_inverse=True)
    save_off(out, v[used], inverse.reshape(-1, 3))
    print(spent)


def run_peer(peer, source, size, out):
    done = subprocess.run([sys.executable, __file__, "--peer", peer, source, repr(size), out], capture_output=True, text=True,
                          timeout=300, env={**os.environ, "OMP_NUM_THREADS": "1"})
    if done.returncode or not Path(out).exists():
        raise RuntimeError(f"exit code {done.returncode} {done.stderr.strip()[-160:]}")
    return float(done.stdout.split()[-1])


# -------------------------------------------------------------------------------------------------------------- a run

def measured(program, name, model, share, folder):
    v, f, info, source = model
    size = float(share * np.linalg.norm(v.max(0) - v.min(0)))
    wanted = max(4, round(info["area"] / (np.sqrt(3) / 4 * size * size)))
    row = {"program": program, "model": name, "size": share}
    best, asked = None, size
    for _ in range(3):
        out = str(folder / f"{name}-{share}-{program}-{asked:.6g}.off")
        Path(out).unlink(missing_ok=True)
        try:
            spent = run_ours(source, asked, out) if program == "rvachev" else run_peer(program, source, asked, out)
            w, g = load(out)
        except Exception as e:
            row.setdefault("error", f"{type(e).__name__}: {e}"[:200])
            break
        off = abs(np.log(len(g) / wanted))
        if best is None or off < best[0]:
            best = (off, spent, w, g, out)
        elif best:
            break
        if 0.87 <= len(g) / wanted <= 1.15:
            break
        asked *= float(np.clip(np.sqrt(len(g) / wanted), 0.4, 2.5))
    if best is None:
        return {**row, "success": False, "good": False}
    _, spent, w, g, out = best
    row.pop("error", None)
    c = checked(out)
    sound = c["closed"] and c["manifold"] and c["oriented"] and c["euler"] == info["euler"]
    sound = sound and c["components"] == info["components"]
    sound = sound and (c["self_intersections"] == 0 or info["self_intersections"] > 0)
    row |= {"triangles": len(g), "count": len(g) / wanted, "cpu": spent, **quality(w, g)}
    kept = True
    e = sharp_edges(v, f, 40)
    if name.split(".")[0] in FEATURED and len(e):
        p, weight = samples(v, e, size / 10)
        weight = weight / weight.sum()
        d, low = to_segments(p, w, edges(g)[0]) / size, floor_distance(v, e, size, p) / size
        s = to_segments(p, w, sharp_edges(w, g, 25)) / size
        rms = [float(np.sqrt((x * x * weight).sum())) for x in (d, low)]
        within, sharp_within, low_within = (float(((x <= 0.05) * weight).sum()) for x in (d, s, low))
        kept = rms[0] <= 0.01 + 1.25 * rms[1] and sharp_within >= min(0.98, low_within - 0.01)
        row |= {"within": within, "floor": low_within, "farthest": float(d.max())}
    row["success"] = bool(sound and kept)
    row["good"] = bool(row["success"] and row["ratio"] >= 0.95 and row["p5"] >= 40 and row["min"] >= 20
                       and abs(row["count"] - 1) <= 0.15)
    return row


def table(rows, programs, title):
    print(f"\n### {title}\n")
    print("| program | runs | success | good | count / N | smallest angle: worst, median | 5th percentile | mean 2r/R "
          "| % below 20° | features within 5 % of L (floor) | farthest / L | ktri/s |")
    print("|" + "---|" * 12)
    for program in programs:
        mine = [r for r in rows if r["program"] == program]
        done = [r for r in mine if "cpu" in r]
        if not done:
            continue
        median = lambda key: float(np.median([r[key] for r in done if key in r] or [np.nan]))
        features = f"{100 * median('within'):.1f} ({100 * median('floor'):.1f})"
        speed = float(np.median([r["triangles"] / max(r["cpu"], 1e-3) / 1e3 for r in done]))
        print(f"| {program} | {len(mine)} | {sum(r['success'] for r in mine)} | {sum(r['good'] for r in mine)} "
              f"| {median('count'):.2f} | {min(r['min'] for r in done):.1f}, {median('min'):.1f} | {median('p5'):.1f} "
              f"| {median('ratio'):.3f} | {median('below20'):.2f} | {features} | {median('farthest'):.2f} | {speed:.0f} |")


def main():
    if len(sys.argv) > 1 and sys.argv[1] == "--peer":
        return peer_main(*sys.argv[2:])
    a = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    a.add_argument("folder", type=Path)
    a.add_argument("--models", default="")
    a.add_argument("--sizes", default="0.04,0.02,0.01")
    a.add_argument("--peers", default="mmg,pymeshlab,gmsh")
    a.add_argument("--out", type=Path, default=ROOT / "target" / "discrete" / "results.jsonl")
    a = a.parse_args()
    if not OURS.exists():
        sys.exit("run.py: no release build; run `cargo build --release` first")
    a.out.parent.mkdir(parents=True, exist_ok=True)
    names = [m for m in a.models.split(",") if m] or sorted(p.name for p in a.folder.iterdir() if p.is_file())
    programs = ["rvachev", *[p for p in a.peers.split(",") if p]]
    rows = []
    with open(a.out, "w") as log:
        for name in names:
            v, f = load(a.folder / name)
            source = str(a.out.parent / f"{name}.in.off")
            save_off(source, v, f)
            model = (v, f, checked(source), source)
            for share in map(float, a.sizes.split(",")):
                for program in programs:
                    row = measured(program, name, model, share, a.out.parent)
                    rows.append(row)
                    log.write(json.dumps(row, default=float) + "\n")
                    log.flush()
                    print(f"# {name} {share} {program}: {'good' if row['good'] else 'success' if row['success'] else 'no'}",
                          file=sys.stderr, flush=True)
    featured = [r for r in rows if r["model"].split(".")[0] in FEATURED]
    others = [r for r in rows if r["model"].split(".")[0] not in FEATURED]
    if featured:
        table(featured, programs, "Models with sharp edges")
    if others:
        table(others, programs, "Organic, scanned and marching-cubes models")


if __name__ == "__main__":
    main()
