"""Meshes as those of other packages, which are imported only here."""

import numpy


def to_meshio(mesh):
    import meshio

    triangles = mesh.triangles
    sets = {name: [numpy.asarray(list_)] for name, list_ in mesh.faces.items()}
    # A group of a face's own name holds what the user said it holds.
    sets.update({name: [numpy.asarray(list_)] for name, list_ in mesh.groups.items()})
    return meshio.Mesh(
        mesh.points,
        [("triangle", triangles)],
        cell_data={"face": [mesh.labels.astype(numpy.int64)]},
        cell_sets=sets,
    )


def to_trimesh(mesh):
    import trimesh

    return trimesh.Trimesh(
        vertices=mesh.points.copy(),
        faces=mesh.triangles.copy(),
        face_attributes={"face": mesh.labels.astype(numpy.int64)},
        metadata={"face_names": mesh.face_names},
        process=False,
    )


def to_pyvista(mesh):
    import pyvista

    out = pyvista.PolyData.from_regular_faces(mesh.points.copy(), mesh.triangles.copy())
    out.cell_data["face"] = mesh.labels.astype(numpy.int64)
    out.field_data["face_names"] = mesh.face_names
    return out


def prisms_to_meshio(prisms):
    import meshio

    sides, names = prisms.sides, prisms.faces
    flat = sides[:, 2] == sides[:, 3]
    # Where each side is among those of its kind.
    place = numpy.where(flat, numpy.cumsum(flat), numpy.cumsum(~flat)) - 1
    none = numpy.empty(0, numpy.int64)
    sets = {name: [none, place[list_[flat[list_]]], place[list_[~flat[list_]]]] for name, list_ in names.items()}
    sets["volume"] = [numpy.arange(len(prisms.cells)), none, none]
    blocks = [("wedge", prisms.cells), ("triangle", sides[flat, :3]), ("quad", sides[~flat])]
    return meshio.Mesh(prisms.points, blocks, cell_sets=sets)
