"""What gmsh, meshio and trimesh find in mesh files, as JSON.

    read.py gmsh FILE ...      physical groups with how many elements they have; a script is filled first
    read.py meshio FILE ...    nodes, triangles, names of sets with how many triangles they have, prisms and hexahedra with their volumes
    read.py arrays FILE ...    by meshio, bits of coordinates, corners of triangles, cell data, numbers by name
    read.py trimesh FILE ...   materials with their triangles, areas and normals; the scene's box and volume, what else is said
"""
import json
import sys


def of_gmsh(path):
    import gmsh

    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.open(path)
    if path.endswith(".geo"):
        gmsh.model.mesh.generate(3)
    groups, seen = {}, {}
    for dim, tag in gmsh.model.getPhysicalGroups():
        tags = []
        for entity in gmsh.model.getEntitiesForPhysicalGroup(dim, tag):
            for list_ in gmsh.model.mesh.getElements(dim, entity)[1]:
                tags += [int(t) for t in list_]
        name = gmsh.model.getPhysicalName(dim, tag) or str(tag)
        groups[f"{dim} {name}"] = len(tags)
        for t in tags if dim == 2 else []:
            seen[t] = seen.get(t, 0) + 1
    count = {d: sum(len(t) for t in gmsh.model.mesh.getElements(d)[1]) for d in (1, 2, 3)}
    volume = 0.0
    if count[3]:
        tags = [int(t) for ts in gmsh.model.mesh.getElements(3)[1] for t in ts]
        volume = float(gmsh.model.mesh.getElementQualities(tags, "volume").sum())
    gmsh.finalize()
    most = max(seen.values(), default=0)
    return {"groups": groups, "lines": count[1], "triangles": count[2], "tetrahedra": count[3], "most": most, "volume": volume}


def of_meshio(path):
    import meshio

    mesh = meshio.read(path)
    counts = [len(block.data) if block.type == "triangle" else 0 for block in mesh.cells]
    sets = {}
    for name, blocks in mesh.cell_sets.items():
        sizes = [len(b) for b, block in zip(blocks, mesh.cells) if b is not None and block.type == "triangle"]
        sets[name] = sum(sizes)
    refs = {}
    for key, data in mesh.cell_data.items():
        for values, block in zip(data, mesh.cells):
            if block.type == "triangle" and getattr(values, "dtype", None) is not None and values.dtype.kind in "iu":
                for v in values.tolist():
                    refs.setdefault(key, {}).setdefault(str(v), 0)
                    refs[key][str(v)] += 1
    points = {name: len(list_) for name, list_ in mesh.point_sets.items()}
    box = [mesh.points.min(axis=0).tolist(), mesh.points.max(axis=0).tolist()]
    found = {"nodes": len(mesh.points), "triangles": sum(counts), "sets": sets, "refs": refs, "point_sets": points, "box": box}
    found["quads"] = sum(len(block.data) for block in mesh.cells if block.type == "quad")
    prisms = [block.data for block in mesh.cells if block.type == "wedge"]
    found["prisms"] = sorted(v for cells in prisms for v in volumes(mesh.points[cells]))
    hexahedra = [block.data for block in mesh.cells if block.type == "hexahedron"]
    # Halves of a hexahedron on both sides of the plane through two of its walls' corners are prisms.
    halves = ([0, 1, 2, 4, 5, 6], [0, 2, 3, 4, 6, 7])
    found["hexahedra"] = sorted(sum(v) for cells in hexahedra for v in zip(*(volumes(mesh.points[cells[:, half]]) for half in halves)))
    return found


def arrays_of_meshio(path):
    import meshio

    mesh = meshio.read(path)
    (block,) = mesh.cells
    return {
        "type": block.type,
        "points": mesh.points.view("uint64").tolist(),
        "triangles": block.data.tolist(),
        "data": {name: values[0].tolist() for name, values in mesh.cell_data.items()},
        "names": {name: int(values[0]) for name, values in mesh.field_data.items()},
    }


def of_trimesh(path):
    import numpy
    import trimesh

    # As it is in the file: corners are not merged, and nothing is made upright.
    scene = trimesh.load_scene(path, process=False)
    faces, extras = [], []
    for one in scene.geometry.values():
        # How far from the triangles' own normals those of the file are.
        along = numpy.einsum("ij,ikj->ik", one.face_normals, one.vertex_normals[one.faces])
        material = one.visual.material
        faces.append({
            "name": material.name,
            "color": [int(c) for c in material.main_color],
            "triangles": len(one.faces),
            "area": float(one.area),
            "vertices": len(one.vertices),
            "normals": float(along.min()),
        })
        extras.append({key: one.metadata[key] for key in ("units", "groups") if key in one.metadata})
    whole = scene.to_mesh()
    whole.merge_vertices(merge_norm=True, merge_tex=True)
    found = {"faces": faces, "extras": extras, "box": scene.bounds.tolist(), "area": float(whole.area)}
    return found | {"volume": float(whole.volume), "closed": bool(whole.is_watertight)}


def volumes(p):
    """Of prisms with flat sides, positive where the first triangle runs counterclockwise as seen from the second."""
    import numpy

    def six(a, b, c, d):
        return numpy.einsum("ij,ij->i", p[:, b] - p[:, a], numpy.cross(p[:, c] - p[:, a], p[:, d] - p[:, a]))

    return ((six(0, 1, 2, 3) + six(1, 2, 3, 4) + six(2, 3, 4, 5)) / 6).tolist()


def main(arguments):
    read = {"gmsh": of_gmsh, "meshio": of_meshio, "arrays": arrays_of_meshio, "trimesh": of_trimesh}[arguments[0]]
    # meshio talks on standard output: the answer is the last line.
    print("\n" + json.dumps([read(path) for path in arguments[1:]]))


if __name__ == "__main__":
    main(sys.argv[1:])
