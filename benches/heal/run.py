"""rvachev beside other repair tools: dirty files as they are, and controlled damage of sound ones.

    python3 benches/heal/run.py FOLDER [--dirty a.stl,b.off] [--sound c.off] [--peers meshfix,pymeshlab] [--levels 1,2,3]
                                [--exact PROGRAM] [--out target/heal/results.jsonl]

FOLDER holds triangle meshes (STL, OFF, OBJ, PLY). Each of `--dirty` is healed as it is (without it: every file that is not
sound). Each of `--sound` is damaged in ten ways, each as hard as the levels say, and healed; without `--sound` that is left
out. Needs Python 3.10 or newer with what `requirements.txt` names, and a release build of rvachev. `--exact PROGRAM` names
one that prints the number of intersecting pairs of triangles for `PROGRAM si FILE`; without it rvachev itself is asked.

Definitions.

    valid   no open edge, no edge of more than two triangles, one fan at each node, consistent orientation, no duplicate,
            no triangle without area, no pair of intersecting triangles
    kept    at least 98 % of 20 000 points of the input, evenly by area, lie within 1e-4 of the diagonal from the result
    right   valid, with the Euler characteristic and the number of components before the damage

CPU seconds are user and system of one process with one thread: ours from start to end, file reading and writing included;
the peers' of the repair alone.
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
sys.path.insert(0, str(ROOT / "benches" / "discrete"))
from run import OURS, checked, load, save_off  # noqa: E402

TIMEOUT = 120
PEERS = "meshfix,meshfix_join,pymeshlab,manifold3d,trimesh"


# ------------------------------------------------------------------------------------------------------------- damage

def neighbors(n, f):
    near = [set() for _ in range(n)]
    for a, b, c in f:
        near[a] |= {b, c}
        near[b] |= {a, c}
        near[c] |= {a, b}
    return near


def patch(v, f, center, rings):
    """Triangles with all nodes within so many edges of a node."""
    near, seen, front = neighbors(len(v), f), {center}, {center}
    for _ in range(rings):
        front = set().union(*(near[x] for x in front)) - seen
        seen |= front
    return np.isin(f, list(seen)).all(1)


def disks(f):
    """Whether triangles fall into disks: then closing the holes they leave brings back what was there."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    half = np.sort(np.concatenate([f[:, [0, 1]], f[:, [1, 2]], f[:, [2, 0]]]), axis=1)
    _, edge = np.unique(half, axis=0, return_inverse=True)
    t = np.tile(np.arange(len(f)), 3)
    order = np.argsort(edge.ravel(), kind="stable")
    same = edge.ravel()[order][1:] == edge.ravel()[order][:-1]
    a, b = t[order[1:][same]], t[order[:-1][same]]
    count, piece = connected_components(coo_array((np.ones(len(a)), (a, b)), shape=(len(f), len(f))))
    euler = lambda g: len(np.unique(g)) - len(np.unique(np.sort(
        np.concatenate([g[:, [0, 1]], g[:, [1, 2]], g[:, [2, 0]]]), 1), axis=0)) + len(g)
    return all(euler(f[piece == k]) == 1 for k in range(count))


def split_edges(v, f, which):
    """A node in the middle of an edge of each of these triangles, for that triangle alone."""
    v, out = list(v), []
    for t, (a, b, c) in enumerate(f):
        if t in which:
            v.append(0.5 * (np.asarray(v[a]) + v[b]))
            m = len(v) - 1
            out += [[a, m, c], [m, b, c]]
        else:
            out.append([a, b, c])
    return np.array(v), np.array(out)


def path(v, f, start, length):
    """A chain of edges that goes straight on."""
    near = neighbors(len(v), f)
    chain = [start, min(near[start])]
    while len(chain) < length:
        a, b = chain[-2:]
        ahead = [x for x in sorted(near[b]) if x not in chain and not near[x] & set(chain[:-1])]
        if not ahead:
            break
        d = (v[b] - v[a]) / np.linalg.norm(v[b] - v[a])
        chain.append(max(ahead, key=lambda x: (v[x] - v[b]) @ d / np.linalg.norm(v[x] - v[b])))
    return chain


def slit(v, f, chain, width):
    """Opens the mesh along a chain: its inner nodes get a copy for the triangles to its left, drawn away from it."""
    inner, copy, v, f = chain[1:-1], {}, list(v), f.copy()
    corner = {}
    for t, nodes in enumerate(f):
        for k in range(3):
            corner[nodes[k], nodes[(k + 1) % 3]] = t
    for i, x in enumerate(inner, 1):
        # from the chain's next edge to the one before it, around the left side
        t, at, left = corner.get((x, chain[i + 1])), chain[i + 1], []
        while t is not None:
            left.append(t)
            at = next(y for y in f[t] if y not in (x, at))
            if at == chain[i - 1]:
                break
            t = corner.get((x, at))
        if not left or at != chain[i - 1]:
            continue
        copy[x] = (len(v), left)
        middle = np.mean([np.asarray(v)[f[t]].mean(0) for t in left], axis=0)
        v.append(np.asarray(v[x]) + width * (middle - v[x]))
    for x, (new, left) in copy.items():
        for t in left:
            f[t][f[t] == x] = new
    return np.array(v), f


def corners_apart(v, f, random, by):
    p = v[f].reshape(-1, 3)
    return p + random.normal(size=p.shape) * by, np.arange(len(p)).reshape(-1, 3)


def damage(kind, v, f, level, random):
    """A damaged copy. Levels 1, 2, 3: as one would find it, worse, and hard."""
    n, diagonal = len(f), np.linalg.norm(v.max(0) - v.min(0))
    any_node = lambda: int(random.integers(len(v)))
    if kind in ("hole", "8 holes", "holes sharing nodes"):
        near = neighbors(len(v), f)
        for _ in range(1000):
            gone = np.zeros(n, bool)
            if kind == "hole":
                gone = patch(v, f, any_node(), (2, 4, 7)[level - 1])
            elif kind == "8 holes":
                for _ in range(8 * level):
                    gone |= patch(v, f, any_node(), (1, 2, 2)[level - 1])
            else:
                for _ in range((1, 3, 6)[level - 1]):
                    a = any_node()
                    second = sorted(set().union(*(near[x] for x in near[a])) - near[a] - {a})
                    for x in [a, *random.choice(second, min(len(second), level), replace=False)]:
                        gone |= (f == x).any(1)
            if 0 < gone.sum() < 0.3 * n and disks(f[gone]):
                return v, f[~gone]
        raise RuntimeError("the model is too small for this damage")
    if kind == "pairs of chains":
        for _ in range((1, 4, 10)[level - 1]):
            v, f = slit(v, f, path(v, f, any_node() % len(v), 4 + 3 * level), 0.2)
        return v, f
    if kind == "T-junctions":
        return split_edges(v, f, set(random.choice(n, n * (2, 10, 30)[level - 1] // 100, replace=False)))
    if kind == "turned":
        f = f.copy()
        some = random.random(n) < (0.02, 0.2, 0.5)[level - 1]
        f[some] = f[some][:, [0, 2, 1]]
        return v, f
    if kind == "duplicates, degenerate":
        some = f[random.choice(n, max(1, n * 3 * level // 100))]
        half = some[::2][:, [1, 2, 0]] if level == 1 else some[::2][:, [0, 2, 1]]
        flat = some[1::2][:, [0, 1, 0]]
        return v, np.concatenate([f, half, flat])[random.permutation(n + len(half) + len(flat))]
    if kind == "jittered corners":
        shortest = np.linalg.norm(v[f] - v[np.roll(f, 1, 1)], axis=2).min()
        return corners_apart(v, f, random, (1e-3, 1e-2, 5e-2)[level - 1] * shortest)
    if kind == "fins":
        v, fins = list(v), []
        for t in random.choice(n, (1, 10, 40)[level - 1], replace=False):
            a, b, c = f[t]
            out = np.cross(v[b] - v[a], v[c] - v[a])
            out *= np.linalg.norm(v[b] - v[a]) / max(np.linalg.norm(out), 1e-300)
            v.append(0.5 * (v[a] + v[b]) + (1 if level < 3 else random.choice([-1, 1])) * out)
            fins.append([a, b, len(v) - 1])
        return np.array(v), np.concatenate([f, fins])
    # pulled through itself
    v, c = v.copy(), v[any_node()]
    to = v.mean(0) - c
    reach = (0.05, 0.08, 0.12)[level - 1] * diagonal
    weight = np.exp(-((v - c) ** 2).sum(1) / reach ** 2)
    return v + np.outer(weight, to * (2.0 + 0.3 * level)), f


KINDS = ["hole", "8 holes", "holes sharing nodes", "pairs of chains", "T-junctions", "turned", "duplicates, degenerate",
         "jittered corners", "fins", "pulled through itself"]


# ----------------------------------------------------------------------------------------------------------- programs

def run_ours(source, out):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([OURS, "heal", source, "-o", out, "--threads", "1", "-q"], capture_output=True, text=True,
                          timeout=TIMEOUT)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if not Path(out).exists():
        raise RuntimeError(done.stderr.strip()[-200:])
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def peer_main(peer, source, out):
    """In a process of its own: a peer may crash, and its CPU time is its own."""
    v, f = load(source)
    f = f[(f[:, 0] != f[:, 1]) & (f[:, 1] != f[:, 2]) & (f[:, 0] != f[:, 2])]
    if peer.startswith("meshfix"):
        import pymeshfix
        began = time.process_time()
        m = pymeshfix.MeshFix(v, f.astype(np.int32))
        m.repair(**({"joincomp": True, "remove_smallest_components": False} if peer == "meshfix_join" else {}))
        v, f = np.asarray(m.points, float), np.asarray(m.faces, int)
    elif peer == "pymeshlab":
        import pymeshlab as ml
        diagonal = np.linalg.norm(v.max(0) - v.min(0))
        began = time.process_time()
        s = ml.MeshSet()
        s.add_mesh(ml.Mesh(v, f.astype(np.int32)))
        s.meshing_merge_close_vertices(threshold=ml.PureValue(1e-5 * diagonal))
        for step in ("remove_duplicate_faces", "remove_null_faces", "remove_t_vertices", "snap_mismatched_borders",
                     "repair_non_manifold_edges", "repair_non_manifold_vertices"):
            getattr(s, "meshing_" + step)()
        for step, how in (("close_holes", {"maxholesize": 100000, "refinehole": False}), ("re_orient_faces_coherently", {})):
            try:
                getattr(s, "meshing_" + step)(**how)
            except Exception:
                pass
        v, f = s.current_mesh().vertex_matrix(), s.current_mesh().face_matrix()
    elif peer == "trimesh":
        import trimesh
        began = time.process_time()
        m = trimesh.Trimesh(v, f, process=True)
        m.update_faces(m.unique_faces() & m.nondegenerate_faces())
        trimesh.repair.fix_winding(m)
        trimesh.repair.fix_normals(m)
        trimesh.repair.fill_holes(m)
        v, f = np.asarray(m.vertices), np.asarray(m.faces)
    else:
        import manifold3d
        began = time.process_time()
        m = manifold3d.Mesh(v.astype(np.float32), f.astype(np.uint32))
        m.merge()
        m = manifold3d.Manifold(m).to_mesh()
        v, f = np.asarray(m.vert_properties, float)[:, :3], np.asarray(m.tri_verts, int)
    spent = time.process_time() - began
    used, inverse = np.unique(f.ravel(), return_inverse=True)
    save_off(out, v[used], inverse.reshape(-1, 3))
    print(spent)


def run_peer(peer, source, out):
    done = subprocess.run([sys.executable, __file__, "--peer", peer, source, out], capture_output=True, text=True,
                          timeout=TIMEOUT, env={**os.environ, "OMP_NUM_THREADS": "1"})
    if done.returncode or not Path(out).exists():
        raise RuntimeError(f"exit code {done.returncode} {done.stderr.strip()[-160:]}")
    return float(done.stdout.split()[-1])


# -------------------------------------------------------------------------------------------------------------- a run

def kept(v, f, w, g):
    import igl
    double = np.linalg.norm(np.cross(v[f[:, 1]] - v[f[:, 0]], v[f[:, 2]] - v[f[:, 0]]), axis=1)
    random, area = np.random.default_rng(1), np.cumsum(double)
    t = np.searchsorted(area, (np.arange(20000) + 0.5) / 20000 * area[-1])
    a, b = random.random((2, len(t), 1))
    a, b = np.where(a + b > 1, 1 - a, a), np.where(a + b > 1, 1 - b, b)
    p = v[f[t, 0]] + a * (v[f[t, 1]] - v[f[t, 0]]) + b * (v[f[t, 2]] - v[f[t, 0]])
    square = igl.point_mesh_squared_distance(p, np.ascontiguousarray(w), np.ascontiguousarray(g.astype(np.int64)))[0]
    return float((square < (1e-4 * np.linalg.norm(v.max(0) - v.min(0))) ** 2).mean())


def is_valid(path, exact):
    c = checked(path)
    w, g = load(path)
    double = np.linalg.norm(np.cross(w[g[:, 1]] - w[g[:, 0]], w[g[:, 2]] - w[g[:, 0]]), axis=1)
    crossing = c["self_intersections"]
    if exact:
        crossing = int(subprocess.run([exact, "si", path], capture_output=True, text=True).stdout.split()[-2])
    once = len(np.unique(np.sort(g, 1), axis=0)) == len(g)
    return bool(c["closed"] and c["manifold"] and c["oriented"] and once and double.min() > 0 and crossing == 0), c


def measured(program, name, source, mesh, truth, exact, folder):
    out = str(folder / f"{name}-{program}.off")
    Path(out).unlink(missing_ok=True)
    row = {"program": program, "file": name, "valid": False, "kept": 0.0, "right": False}
    try:
        row["cpu"] = run_ours(source, out) if program == "rvachev" else run_peer(program, source, out)
        row["valid"], c = is_valid(out, exact)
        row["kept"] = kept(*mesh, *load(out))
        row["right"] = bool(row["valid"] and truth and c["euler"] == truth["euler"] and c["components"] == truth["components"])
    except Exception as e:
        row["error"] = f"{type(e).__name__}: {e}"[:200]
    return row


def seconds(rows):
    cpu = [r["cpu"] for r in rows if "cpu" in r] or [np.nan]
    return f"{np.median(cpu):.3f} | {max(cpu):.2f}"


def main():
    if len(sys.argv) > 1 and sys.argv[1] == "--peer":
        return peer_main(*sys.argv[2:])
    a = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    a.add_argument("folder", type=Path)
    a.add_argument("--dirty", default=None)
    a.add_argument("--sound", default="")
    a.add_argument("--levels", default="1,2,3")
    a.add_argument("--kinds", default=",".join(k.replace(",", ";") for k in KINDS))
    a.add_argument("--peers", default=PEERS)
    a.add_argument("--exact", default="")
    a.add_argument("--out", type=Path, default=ROOT / "target" / "heal" / "results.jsonl")
    a = a.parse_args()
    if not OURS.exists():
        sys.exit("run.py: no release build; run `cargo build --release` first")
    a.out.parent.mkdir(parents=True, exist_ok=True)
    programs = ["rvachev", *[p for p in a.peers.split(",") if p]]
    kinds = [k.replace(";", ",") for k in a.kinds.split(",")]
    folder, rows, hurt = a.out.parent, [], []

    def go(log, name, source, mesh, truth, into, **more):
        for program in programs:
            row = measured(program, name, source, mesh, truth, a.exact, folder) | more
            into.append(row)
            log.write(json.dumps(row) + "\n")
            log.flush()
            print(f"# {name} {program}: valid {row['valid']}, kept {row['kept']:.3f}, right {row['right']}", file=sys.stderr)

    with open(a.out, "w") as log:
        names = a.dirty.split(",") if a.dirty is not None else sorted(p.name for p in a.folder.iterdir() if p.is_file())
        for name in filter(None, names):
            if a.dirty is None:
                v, f = load(a.folder / name)
                save_off(folder / "asked.off", v, f)
                if len(f) == 0 or is_valid(str(folder / "asked.off"), a.exact)[0]:
                    continue
            go(log, name, str(a.folder / name), load(a.folder / name), None, rows)
        for model in filter(None, a.sound.split(",")):
            v, f = load(a.folder / model)
            save_off(folder / "asked.off", v, f)
            truth = checked(str(folder / "asked.off"))
            for kind in kinds:
                for level in map(int, a.levels.split(",")):
                    bad = damage(kind, v, f, level, np.random.default_rng([KINDS.index(kind), level, len(f)]))
                    name = f"{Path(model).stem}-{kind.replace(' ', '_').replace(',', '')}-{level}"
                    save_off(folder / f"{name}.off", *bad)
                    go(log, name, str(folder / f"{name}.off"), bad, truth, hurt, kind=kind, level=level)
    if rows:
        print(f"\n### {len(rows) // len(programs)} dirty files\n\n| | valid | valid and kept | CPU s, median | largest |\n|---|---|---|---|---|")
        for p in programs:
            mine = [r for r in rows if r["program"] == p]
            both = sum(r["valid"] and r["kept"] >= 0.98 for r in mine)
            print(f"| {p} | {sum(r['valid'] for r in mine)} | {both} | {seconds(mine)} |")
    if hurt:
        print(f"\n### Damage, {len(hurt) // len(programs)} files\n")
        print("| | " + " | ".join(kinds) + " | all | CPU s, median | largest |\n" + "|---" * (len(kinds) + 4) + "|")
        for p in programs:
            mine = [r for r in hurt if r["program"] == p]
            per = [sum(r["right"] for r in mine if r["kind"] == k) for k in kinds]
            print(f"| {p} | " + " | ".join(map(str, per)) + f" | {sum(per)}/{len(mine)} | {seconds(mine)} |")


if __name__ == "__main__":
    main()
