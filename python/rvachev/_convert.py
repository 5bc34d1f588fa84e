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


def to_netgen(mesh, names=None, tets=()):
    """Boundaries are called by `names`, one for each face: without them as the faces are."""
    from netgen import meshing

    out = meshing.Mesh(dim=3)
    numbers = [out.Add(meshing.MeshPoint(meshing.Pnt(*p))) for p in mesh.points.tolist()]
    faces = []
    for i, name in enumerate(mesh.face_names if names is None else names):
        faces.append(out.Add(meshing.FaceDescriptor(surfnr=i + 1, domin=1, domout=0, bc=i + 1)))
        out.SetBCName(i, name)
    for (a, b, c), face in zip(mesh.triangles.tolist(), mesh.labels.tolist()):
        out.Add(meshing.Element2D(faces[face], [numbers[a], numbers[b], numbers[c]]))
    for tet in tets:
        out.Add(meshing.Element3D(1, [numbers[v] for v in tet]))
    return out


def to_gmsh(mesh, name):
    import gmsh

    from ._fill import Shells

    shells = Shells(mesh.points, mesh.triangles)
    if not gmsh.isInitialized():
        gmsh.initialize(readConfigFiles=False, interruptible=False)
    gmsh.model.add(name)
    placed = numpy.zeros(len(mesh.points), bool)
    # A surface for each face of each shell, since loops are of whole surfaces.
    of_shell, of_face = [[] for _ in shells.triangles], [[] for _ in mesh.face_names]
    keys = numpy.stack([shells.piece, mesh.labels.astype(numpy.int64)], axis=1)
    for tag, (shell, face) in enumerate(numpy.unique(keys, axis=0).tolist(), 1):
        of_shell[shell].append(tag)
        of_face[face].append(tag)
        rows = mesh.triangles[(keys == (shell, face)).all(axis=1)]
        own = numpy.unique(rows)
        own = own[~placed[own]]
        placed[own] = True
        gmsh.model.addDiscreteEntity(2, tag)
        gmsh.model.mesh.addNodes(2, tag, own + 1, mesh.points[own].ravel())
        gmsh.model.mesh.addElementsByType(tag, 2, [], rows.ravel() + 1)
    volumes = []
    for outer in shells.outer.tolist():
        walls = [outer, *shells.cavities.get(outer, [])]
        loops = [gmsh.model.geo.addSurfaceLoop(of_shell[int(i)]) for i in walls]
        volumes.append(gmsh.model.geo.addVolume(loops))
    gmsh.model.geo.synchronize()
    for face, tags in zip(mesh.face_names, of_face):
        gmsh.model.addPhysicalGroup(2, tags, name=face)
    for group, list_ in mesh.groups.items():
        tags = [tag for face in numpy.unique(mesh.labels[list_]) for tag in of_face[face]]
        if group not in mesh.face_names:
            gmsh.model.addPhysicalGroup(2, tags, name=group)
    gmsh.model.addPhysicalGroup(3, volumes, name="volume")
    return name


def cells_to_meshio(volume, cells):
    """Cells of several kinds, then the sides of the boundary."""
    import meshio

    sides, names = volume.sides, volume.faces
    flat = sides[:, 2] == sides[:, 3]
    # Where each side is among those of its kind.
    place = numpy.where(flat, numpy.cumsum(flat), numpy.cumsum(~flat)) - 1
    none = [numpy.empty(0, numpy.int64)] * len(cells)
    sets = {name: [*none, place[list_[flat[list_]]], place[list_[~flat[list_]]]] for name, list_ in names.items()}
    sets["volume"] = [*(numpy.arange(len(rows)) for _, rows in cells), *[numpy.empty(0, numpy.int64)] * 2]
    blocks = [*cells, ("triangle", sides[flat, :3]), ("quad", sides[~flat])]
    return meshio.Mesh(volume.points, blocks, cell_sets=sets)
