"""One peer meshes one STEP file: peer.py gmsh5|gmsh6|netgen FILE OUT.off TRIANGLES AREA

The size is changed, at most twice, until the number of triangles is within 30 % of TRIANGLES. One JSON line per attempt: CPU
seconds of reading and of meshing, triangles, faces, faces without triangles, memory above the model in MB.
"""
import json
import math
import resource
import sys
import time

import numpy as np

peer, path, out, target, area = sys.argv[1], sys.argv[2], sys.argv[3], int(sys.argv[4]), float(sys.argv[5])


def memory():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def save(points, triangles):
    # Nodes at one place are one: Netgen gives the two sides of a seam nodes of their own.
    cell = 1e-9 * np.linalg.norm(np.ptp(points, axis=0))
    _, first, same = np.unique(np.round(points / cell), axis=0, return_index=True, return_inverse=True)
    triangles = first[same.ravel()][triangles]
    triangles = triangles[(triangles != np.roll(triangles, 1, axis=1)).all(axis=1)]
    used, number = np.unique(triangles, return_inverse=True)
    with open(out, "w") as f:
        f.write(f"OFF\n{len(used)} {len(triangles)} 0\n")
        f.writelines(f"{x!r} {y!r} {z!r}\n" for x, y, z in points[used].tolist())
        f.writelines(f"3 {a} {b} {c}\n" for a, b, c in number.reshape(-1, 3).tolist())


if peer.startswith("gmsh"):
    import gmsh

    gmsh.initialize()
    for option, value in (("General.Verbosity", 0), ("General.NumThreads", 1), ("Mesh.Algorithm", int(peer[4:])),
                          ("Mesh.MeshSizeFromCurvature", 12)):
        gmsh.option.setNumber(option, value)
    start = time.process_time()
    gmsh.model.occ.importShapes(path, highestDimOnly=False)
    gmsh.model.occ.synchronize()
    read = time.process_time() - start
    faces = [tag for _, tag in gmsh.model.getEntities(2)]

    def run(h):
        gmsh.model.mesh.clear()
        gmsh.option.setNumber("Mesh.MeshSizeMax", h)
        gmsh.option.setNumber("Mesh.MeshSizeMin", h / 50)
        start = time.process_time()
        try:
            gmsh.model.mesh.generate(2)
        except Exception:
            pass
        seconds = time.process_time() - start
        tags, xyz, _ = gmsh.model.mesh.getNodes()
        index = np.zeros(int(tags.max()) + 1 if len(tags) else 1, int)
        index[tags.astype(int)] = np.arange(len(tags))
        parts = [gmsh.model.mesh.getElementsByType(2, tag)[1].astype(int) for tag in faces]
        return seconds, xyz.reshape(-1, 3), index[np.concatenate(parts)].reshape(-1, 3), sum(len(p) == 0 for p in parts)
else:
    import netgen.meshing as ng
    import netgen.occ as occ

    start = time.process_time()
    geometry = occ.OCCGeometry(path)
    read = time.process_time() - start
    faces = list(geometry.shape.faces)

    def run(h):
        start = time.process_time()
        try:
            mesh = geometry.GenerateMesh(mp=ng.MeshingParameters(maxh=h, perfstepsend=ng.MeshingStep.MESHSURFACE))
        except BaseException:
            mesh = None
        seconds = time.process_time() - start
        if mesh is None:
            return seconds, np.zeros((0, 3)), np.zeros((0, 3), int), len(faces)
        elements = mesh.Elements2D().NumPy()
        points = np.array(mesh.Coordinates()).reshape(-1, 3)
        return seconds, points, elements["nodes"][:, :3].astype(int) - 1, len(faces) - len(np.unique(elements["index"]))

before = memory()
h, spent = math.sqrt(area / target / 0.433), 0.0
for attempt in range(3):
    seconds, points, triangles, failed = run(h)
    spent += seconds
    if len(triangles):
        save(points, triangles)
    print(json.dumps({"read": read, "mesh": seconds, "triangles": len(triangles), "faces": len(faces), "failed": int(failed),
                      "memory": memory() - before}), flush=True)
    ratio = len(triangles) / target
    if ratio == 0 or 1 / 1.3 < ratio < 1.3 or spent > 14:
        break
    h *= min(max(math.sqrt(ratio), 1 / 12), 12)
