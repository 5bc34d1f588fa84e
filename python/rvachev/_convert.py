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
