"""What libigl and pymeshlab say about meshes, as JSON.

    check.py MESH.off ...              one object per mesh, in a list
    check.py --distance A.off B.off    Hausdorff distances between two meshes, both ways and both peers

Self-intersections are asked of libigl, which uses exact predicates, and not of pymeshlab: its test takes clean meshes for
bad ones and misses true crossings.
"""
import json
import os
import sys

# pymeshlab is linked against OpenGL, which nothing here calls: bound lazily, a library without symbols serves as well.
if hasattr(os, "RTLD_LAZY"):
    sys.setdlopenflags(os.RTLD_LAZY)

import igl
import igl.predicates
import numpy as np
import pymeshlab


def read_off(path):
    with open(path) as file:
        words = [w for line in file for w in line.split("#")[0].split()]
    if words[0] != "OFF":
        raise ValueError(f"{path}: not an OFF file")
    n, m = int(words[1]), int(words[2])
    nodes = np.array(words[4 : 4 + 3 * n], float).reshape(n, 3)
    rest, triangles = words[4 + 3 * n :], np.empty((m, 3), np.int64)
    at = 0
    colors = (len(rest) - 4 * m) // m if m else 0
    for i in range(m):
        if rest[at] != "3":
            raise ValueError(f"{path}: face {i} has {rest[at]} nodes")
        triangles[i] = [int(w) for w in rest[at + 1 : at + 4]]
        at += 4 + colors
    return nodes, triangles


def of_igl(nodes, triangles):
    edges = np.sort(igl.boundary_facets(triangles)[0], axis=1)
    tetrahedra = np.column_stack([np.full(len(triangles), len(nodes)), triangles])
    # Signed: a tetrahedron per triangle, with its apex in the first node.
    volume = igl.volume(np.vstack([nodes, nodes[:1]]), tetrahedra).sum()
    angles = np.degrees(igl.internal_angles(nodes, triangles))
    return {
        "boundary_edges": len(edges),
        "edge_manifold": bool(igl.is_edge_manifold(triangles)[0]),
        "vertex_manifold": bool(np.all(igl.is_vertex_manifold(triangles))),
        "euler": int(igl.euler_characteristic(triangles)),
        "intersecting_triangles": len(np.unique(igl.predicates.find_self_intersections(nodes, triangles)[1])),
        "components": int(igl.facet_components(triangles)[0]),
        "area": float(igl.doublearea(nodes, triangles).sum() / 2),
        "volume": float(volume),
        "min_angle": float(angles.min()),
        "max_angle": float(angles.max()),
        "p05_angle": float(np.percentile(angles.min(axis=1), 5)),
        "below_20": float((angles.min(axis=1) < 20).mean()),
    }


def curvature(nodes, triangles):
    """Percentiles of the principal curvatures over all nodes."""
    k1, k2 = igl.principal_curvature(nodes, triangles)[2:4]
    shares = (1, 5, 50, 95, 99)
    return {"max": np.percentile(k1, shares).tolist(), "min": np.percentile(k2, shares).tolist()}


def of_pymeshlab(nodes, triangles):
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(nodes, triangles))
    topology = meshes.get_topological_measures()
    geometry = meshes.get_geometric_measures()
    out = {k: topology[k] for k in ("boundary_edges", "number_holes", "genus", "connected_components_number")}
    out |= {k: topology[k] for k in ("non_two_manifold_edges", "non_two_manifold_vertices", "unreferenced_vertices")}
    out["is_mesh_two_manifold"] = topology["is_mesh_two_manifold"]
    out["nodes"], out["triangles"] = topology["vertices_number"], topology["faces_number"]
    out["area"], out["volume"] = geometry["surface_area"], geometry.get("mesh_volume")
    meshes.compute_scalar_by_aspect_ratio_per_face(metric="inradius/circumradius")
    out["mean_radius_ratio"] = float(meshes.current_mesh().face_scalar_array().mean())
    return out


def distance(a, b):
    meshes = pymeshlab.MeshSet()
    for nodes, triangles in (a, b):
        meshes.add_mesh(pymeshlab.Mesh(nodes, triangles))
    samples = 100_000
    ways = [meshes.get_hausdorff_distance(sampledmesh=i, targetmesh=1 - i, samplenum=samples) for i in (0, 1)]
    return {
        "igl": float(igl.hausdorff(*a, *b)),
        "pymeshlab": max(w["max"] for w in ways),
        "pymeshlab_rms": max(w["RMS"] for w in ways),
    }


def plain(x):
    """Numbers of numpy as those of Python; what is not a number (an angle of a triangle without area) as null."""
    if isinstance(x, dict):
        return {k: plain(v) for k, v in x.items()}
    if isinstance(x, list):
        return [plain(v) for v in x]
    x = x.item() if isinstance(x, np.generic) else x
    return None if isinstance(x, float) and not np.isfinite(x) else x


def main(arguments):
    if arguments[:1] == ["--distance"]:
        a, b = map(read_off, arguments[1:])
        answer = distance(a, b)
    else:
        answer = []
        for path in arguments:
            mesh = read_off(path)
            answer.append({"igl": of_igl(*mesh), "pymeshlab": of_pymeshlab(*mesh), "curvature": curvature(*mesh)})
    print(json.dumps(plain(answer), allow_nan=False))


if __name__ == "__main__":
    main(sys.argv[1:])
