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


def to_netgen(mesh):
    from netgen import meshing

    out = meshing.Mesh(dim=3)
    numbers = [out.Add(meshing.MeshPoint(meshing.Pnt(*p))) for p in mesh.points.tolist()]
    faces = []
    for i, name in enumerate(mesh.face_names):
        faces.append(out.Add(meshing.FaceDescriptor(surfnr=i + 1, domin=1, domout=0, bc=i + 1)))
        out.SetBCName(i, name)
    for (a, b, c), face in zip(mesh.triangles.tolist(), mesh.labels.tolist()):
        out.Add(meshing.Element2D(faces[face], [numbers[a], numbers[b], numbers[c]]))
    return out


def to_gmsh(mesh, name):
    import gmsh

    from ._fill import Shells

    if not gmsh.isInitialized():
        gmsh.initialize(readConfigFiles=False, interruptible=False)
    gmsh.model.add(name)
    model, placed = gmsh.model, numpy.zeros(len(mesh.points), bool)
    shells = Shells(mesh.points, mesh.triangles)
    # A face may lie on several shells: a surface for each face of each shell, all of them by the rows of triangles in `own`.
    shell_of = shells.of
    surfaces = {}
    for number, shell in enumerate(numpy.unique(shell_of)):
        for face in numpy.unique(mesh.labels[shell_of == shell]):
            surfaces[int(shell), int(face)] = len(surfaces) + 1
    for (shell, face), tag in surfaces.items():
        rows = mesh.triangles[(shell_of == shell) & (mesh.labels == face)]
        model.addDiscreteEntity(2, tag)
        own = numpy.unique(rows)
        own = own[~placed[own]]
        placed[own] = True
        model.mesh.addNodes(2, tag, own + 1, mesh.points[own].ravel())
        model.mesh.addElementsByType(tag, 2, [], rows.ravel() + 1)
    return name


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
