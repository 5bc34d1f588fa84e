"""The peers' side of `run.py`; runs in their virtual environment and prints one JSON object.

    makers.py gmsh PART SIZE TRIANGLES REPS OUT.off       the part as exact B-rep, meshed by gmsh
    makers.py remesh IN.off SIZE TRIANGLES REPS OUT.off   a mesh, remeshed by pymeshlab
    makers.py picture OUT.png SHEET.png CELLS CHOSEN...   some of the cells of a contact sheet, side by side

SIZE is the edge length to start with; it is changed, five tries at most, until TRIANGLES come out to one part in a hundred;
the nearest try counts.
Seconds are CPU seconds of this process, user and system. Imports, start-up, reading and writing are not counted.
"""
import json
import os
import sys
import time

SLOW = 5.0  # seconds of CPU after which a run is not repeated
TRIES = 5


def seconds_of(run):
    start = time.process_time()
    run()
    return time.process_time() - start


def write_off(path, points, triangles):
    with open(path, "w") as out:
        print(f"OFF\n{len(points)} {len(triangles)} 0", file=out)
        for p in points.tolist():
            print(*map(repr, p), file=out)
        for t in triangles.tolist():
            print(3, *t, file=out)


def least(mesh_at, size, wanted, reps):
    """Meshes at the size that gives the wanted count, then again for the time.

    `mesh_at(size)` returns a dict of seconds and the number of triangles.
    """
    tries = [(size, *mesh_at(size))]
    while abs(tries[-1][2] / wanted - 1) > 0.01 and len(tries) < TRIES:
        size, _, count = tries[-1]
        size *= (count / wanted) ** 0.5
        tries.append((size, *mesh_at(size)))
    best_size, best, count = min(tries, key=lambda t: abs(t[2] / wanted - 1))
    if best_size != tries[-1][0] or sum(best.values()) < SLOW:
        for _ in range(max(1, reps - 1)):
            seconds, count = mesh_at(best_size)
            best = min(best, seconds, key=lambda s: sum(s.values()))
    return {"seconds": best, "triangles": count, "size": best_size}


# ------------------------------------------------------------------------------------------------------------- gmsh

def cube_with_holes(occ):
    cube = (3, occ.addBox(-1, -1, -1, 2, 2, 2))
    holes = [(3, occ.addCylinder(-2, 0, 0, 4, 0, 0, 0.4)), (3, occ.addCylinder(0, 0, -2, 0, 0, 4, 0.4))]
    return occ.cut([cube], holes)[0]


def cube_with_holes_rotated(occ):
    from math import radians
    solid = cube_with_holes(occ)
    axis = (0.30529502354055693, -0.2801478599619021, -0.9101165448227702)
    occ.rotate(solid, 0, 0, 0, *axis, radians(179.85594446358624))
    return solid


def bracket(occ):
    def box(lo, hi):
        return (3, occ.addBox(*lo, *(b - a for a, b in zip(lo, hi))))

    def along(axis, at, start, length, radius):
        base, direction = list(at), [0, 0, 0]
        base["xyz".index(axis)], direction["xyz".index(axis)] = start, length
        return (3, occ.addCylinder(*base, *direction, radius))

    base = box((-1, -0.6, -0.6), (1, 0.6, -0.4))
    wall = box((-1, -0.6, -0.6), (-0.8, 0.6, 0.6))
    boss_base = along("z", (0.3, 0, 0), -0.5, 0.33, 0.3)
    boss_wall = along("x", (0, 0, 0.2), -0.9, 0.3, 0.25)
    corners = [occ.addPoint(x, -0.06, z) for x, z in ((-0.9, -0.5), (-0.45, -0.5), (-0.9, -0.05))]
    sides = [occ.addLine(corners[i], corners[(i + 1) % 3]) for i in range(3)]
    triangle = occ.addPlaneSurface([occ.addCurveLoop(sides)])
    rib = [e for e in occ.extrude([(2, triangle)], 0, 0.12, 0) if e[0] == 3]
    solid, _ = occ.fuse([base], [wall, boss_base, boss_wall] + rib)

    holes = [along("z", (0.3, 0, 0), -2, 4, 0.15), along("x", (0, 0, 0.2), -2, 4, 0.12)]
    holes += [along("z", (x, y, 0), -2, 4, 0.08) for x in (0.78, -0.4) for y in (0.41, -0.41)]
    holes += [along("x", (0, y, 0.4), -2, 4, 0.07) for y in (0.4, -0.4)]
    return occ.cut(solid, holes)[0]


def by_gmsh(part, size, wanted, reps, out):
    import gmsh
    import numpy as np

    builder = {f.__name__: f for f in (cube_with_holes, cube_with_holes_rotated, bracket)}[part]
    gmsh.initialize(["gmsh", "-noenv"], readConfigFiles=False)
    for option, value in (("Terminal", 0), ("NumThreads", 1)):
        gmsh.option.setNumber(f"General.{option}", value)
    gmsh.option.setNumber("Mesh.Algorithm", 6)  # frontal Delaunay: gmsh's default, and its best triangles

    def mesh_at(size):
        gmsh.clear()
        gmsh.option.setNumber("Mesh.MeshSizeMin", size)
        gmsh.option.setNumber("Mesh.MeshSizeMax", size)

        def build():
            builder(gmsh.model.occ)
            gmsh.model.occ.synchronize()

        seconds = {"B-rep": seconds_of(build), "meshing": seconds_of(lambda: gmsh.model.mesh.generate(2))}
        return seconds, len(gmsh.model.mesh.getElementsByType(2)[0])

    result = least(mesh_at, size, wanted, reps)
    for _, volume in gmsh.model.getEntities(3):
        gmsh.model.mesh.setOutwardOrientation(volume)
    tags, points, _ = gmsh.model.mesh.getNodes()
    triangles = gmsh.model.mesh.getElementsByType(2)[1].reshape(-1, 3)
    used = np.unique(triangles)
    order = np.argsort(tags)
    points = points.reshape(-1, 3)[order][np.searchsorted(tags[order], used)]
    write_off(out, points, np.searchsorted(used, triangles))
    return result


# -------------------------------------------------------------------------------------------------------- pymeshlab

def by_pymeshlab(source, size, wanted, reps, out):
    # Bound lazily: see `lend_opengl` in `run.py`.
    sys.setdlopenflags(os.RTLD_LAZY)
    import pymeshlab

    meshes = []

    def mesh_at(size):
        meshes.clear()
        ms = pymeshlab.MeshSet(verbose=False)
        ms.load_new_mesh(source)

        def remesh():
            ms.meshing_merge_close_vertices(threshold=pymeshlab.PureValue(1e-3 * size))
            ms.meshing_isotropic_explicit_remeshing(
                iterations=10, targetlen=pymeshlab.PureValue(size), featuredeg=30,
                checksurfdist=True, maxsurfdist=pymeshlab.PureValue(size))

        seconds = {"remeshing": seconds_of(remesh)}
        meshes.append(ms)
        return seconds, ms.current_mesh().face_number()

    result = least(mesh_at, size, wanted, reps)
    mesh = meshes[0].current_mesh()
    write_off(out, mesh.vertex_matrix(), mesh.face_matrix())
    return result


# ---------------------------------------------------------------------------------------------------------- picture

def side_by_side(out, sheet, count, chosen):
    """Cells `chosen` of the contact sheet of `count` cells that `rvachev compare --png` draws."""
    from PIL import Image

    columns, gap = 6, 12
    sheet = Image.open(sheet).convert("RGB")
    rows = -(-count // columns)
    wide, high = (sheet.width - gap) // columns, (sheet.height - gap) // rows
    joined = Image.new("RGB", (len(chosen) * wide + gap, high + gap), "white")
    for i, k in enumerate(chosen):
        left, top = k % columns * wide, k // columns * high
        joined.paste(sheet.crop((left, top, left + wide + gap, top + high + gap)), (i * wide, 0))
    joined.quantize(256, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE).save(out, optimize=True)
    return {"width": joined.width, "height": joined.height}


def main(arguments):
    match arguments:
        case ["gmsh", part, size, wanted, reps, out]:
            return by_gmsh(part, float(size), int(wanted), int(reps), out)
        case ["remesh", source, size, wanted, reps, out]:
            return by_pymeshlab(source, float(size), int(wanted), int(reps), out)
        case ["picture", out, sheet, count, *chosen]:
            return side_by_side(out, sheet, int(count), [int(c) for c in chosen])
    sys.exit(__doc__)


if __name__ == "__main__":
    print(json.dumps(main(sys.argv[1:])))
