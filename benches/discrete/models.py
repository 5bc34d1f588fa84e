#!/usr/bin/env python3
"""Writes the three models of the pictures in discrete.md: `pulley.stl`, as CAD programs export it, slivers and all, `scan.stl`, a
bolt-like body as a scanner sees it, with noise and uneven triangles, and `latch.stl`, a plate with a step far smaller than itself and
folds that end within its top. Needs numpy only.

    python3 benches/discrete/models.py FOLDER
"""
import struct
import sys
from pathlib import Path

import numpy as np


def write_stl(path, v, f):
    t = v[f].astype("<f4")
    n = np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0])
    n /= np.maximum(np.linalg.norm(n, axis=1, keepdims=True), 1e-30)
    record = np.zeros(len(f), np.dtype([("n", "<f4", 3), ("t", "<f4", (3, 3)), ("a", "<u2")]))
    record["n"], record["t"] = n, t
    with open(path, "wb") as out:
        out.write(b"binary".ljust(80, b"\0") + struct.pack("<I", len(f)) + record.tobytes())


def pulley(segments=64):
    """A profile (radius, height) turned around the z axis."""
    groove = [(30, 4), (22, 8), (22, 12), (30, 16)]
    profile = [(6, 0), (14, 0), (14, 2), (30, 2), *groove, (30, 18), (14, 18), (14, 30), (12, 32), (6, 32)]
    p, k = np.array(profile, float), len(profile)
    a = 2 * np.pi * np.arange(segments) / segments
    v = np.stack([np.outer(np.cos(a), p[:, 0]), np.outer(np.sin(a), p[:, 0]), np.tile(p[:, 1], (segments, 1))], 2)
    i, j = np.meshgrid(np.arange(segments), np.arange(k), indexing="ij")
    i1, j1 = (i + 1) % segments, (j + 1) % k
    q = [x.ravel() for x in (i * k + j, i1 * k + j, i1 * k + j1, i * k + j1)]
    f = np.concatenate([np.stack([q[0], q[1], q[2]], 1), np.stack([q[0], q[2], q[3]], 1)])
    return v.reshape(-1, 3), f


def scan(n=70, noise=0.3, seed=7):
    """A star-shaped body on a cube's grid: a rounded square shaft with a head, every node off by part of an edge."""
    random = np.random.default_rng(seed)
    v, known, f = [], {}, []
    for axis in range(3):
        for side in (-1, 1):
            def node(i, j):
                c = np.zeros(3, int)
                c[axis], c[(axis + 1) % 3], c[(axis + 2) % 3] = side * n, 2 * i - n, 2 * j - n
                key = tuple(c)
                if key not in known:
                    known[key] = len(v)
                    v.append(c / n)
                return known[key]
            for i in range(n):
                for j in range(n):
                    a, b, c, d = node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)
                    two = [(a, b, c), (a, c, d)] if random.random() < 0.5 else [(a, b, d), (b, c, d)]
                    f += two if side > 0 else [t[::-1] for t in two]
    d = np.array(v)
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    x, y, z = d.T
    flank = (np.abs(x) ** 6 + np.abs(y) ** 6 + (np.abs(z) / 1.5) ** 6) ** (-1 / 6)
    dent = 0.35 * np.exp(-6 * ((x - 1) ** 2 + y ** 2 + z ** 2)) + 0.25 * np.exp(-8 * ((y + 1) ** 2 + (z - 0.4) ** 2 + x ** 2))
    knob = 0.5 * np.exp(-10 * (x ** 2 + y ** 2 + (z - 1) ** 2))
    r = flank * (1 - dent) + knob
    edge = 2.0 / n
    v = d * (r + noise * edge * random.uniform(-0.5, 0.5, len(d)))[:, None] + noise * edge * random.uniform(-0.5, 0.5, d.shape)
    return v, np.array(f)


def latch(step=0.5):
    """A plate of 60 by 40 by 8 with a boss, a step of 1.5 by 1.5 on its top, and three folds, 1.5 to 4 long, that fade out."""
    def height(x, y):
        z = np.full_like(x, 8.0)
        z += 3 * np.clip(np.minimum(8 - np.abs(x - 42), 8 - np.abs(y - 20)) / step, 0, 1)
        z += 1 * np.clip(np.minimum(1.25 - np.abs(x - 12.25), 1.25 - np.abs(y - 30.25)) / step, 0, 1)
        for cx, cy, half in ((10, 8, 0.75), (20, 14, 1.25), (22, 32, 2)):
            ridge = np.clip(1.5 - np.abs(y - cy), 0, None) * np.tan(np.radians(27))
            z += ridge * np.clip(half + 1.5 - np.abs(x - cx), 0, 1.5) / 1.5
        return z
    nx, ny = round(60 / step), round(40 / step)
    x, y = np.meshgrid(np.arange(nx + 1) * step, np.arange(ny + 1) * step, indexing="ij")
    top = np.stack([x, y, height(x, y)], 2).reshape(-1, 3)
    v = np.concatenate([top, top * [1, 1, 0]])
    n = (nx + 1) * (ny + 1)
    i, j = (a.ravel() for a in np.meshgrid(np.arange(nx), np.arange(ny), indexing="ij"))
    at = lambda i, j: i * (ny + 1) + j
    q = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]
    up = np.concatenate([np.stack([q[0], q[1], q[2]], 1), np.stack([q[0], q[2], q[3]], 1)])
    rim = [at(k, 0) for k in range(nx)] + [at(nx, k) for k in range(ny)]
    rim = np.array(rim + [at(k, ny) for k in range(nx, 0, -1)] + [at(0, k) for k in range(ny, 0, -1)])
    following = np.roll(rim, -1)
    side = np.concatenate([np.stack([rim + n, following + n, following], 1), np.stack([rim + n, following, rim], 1)])
    return v, np.concatenate([up, up[:, ::-1] + n, side])


def main():
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
    folder.mkdir(parents=True, exist_ok=True)
    write_stl(folder / "pulley.stl", *pulley())
    write_stl(folder / "scan.stl", *scan())
    write_stl(folder / "latch.stl", *latch())


if __name__ == "__main__":
    main()
