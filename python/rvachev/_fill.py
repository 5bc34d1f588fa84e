"""Tetrahedra inside a surface, by mesh generators that are packages of their own and are imported only here."""

from __future__ import annotations

import fnmatch
import importlib
import os
import tempfile

import numpy

from ._errors import Failed, InputError

# Names of the packages where they are imported and where they are installed.
PACKAGES = {"gmsh": "gmsh", "tetgen": "tetgen", "netgen": "netgen-mesher", "pytetwild": "pytetwild"}

# Facets of a tetrahedron, counter-clockwise seen from outside.
FACETS = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]

# Rows of points times triangles looked at together where distances or solid angles are taken: some 100 MB.
BLOCK = 1_000_000


class Filled:
    """A solid in tetrahedra, with the names of its surface.

    points: float64 (n, 3), in the part's unit. tets: int64 (m, 4), of positive volume: the fourth point is where the first three are counter-clockwise
    seen from outside it. triangles: int64 (k, 3), the surface, counter-clockwise seen from outside; each is a facet of one
    tetrahedron. labels: uint32 (k,), the face of each triangle, an index into face_names. groups, faces: name -> triangles.
    by: the generator. Where `keeps_surface` holds, points and triangles begin with those of the surface mesh, as they were.
    """

    def __init__(self, mesh, points, tets, triangles, labels, by):
        self.points, self.tets, self.triangles, self.labels, self.by = points, tets, triangles, labels, by
        self.face_names = mesh.face_names
        self.keeps_surface = by != "pytetwild"
        self.faces = {name: numpy.flatnonzero(labels == i) for i, name in enumerate(self.face_names)}
        # A group is a union of faces, so the faces of its triangles tell which.
        of_groups = {name: numpy.unique(mesh.labels[list_]) for name, list_ in mesh.groups.items()}
        self.groups = {name: numpy.flatnonzero(numpy.isin(labels, wanted)) for name, wanted in of_groups.items()}

    def nodes(self, name):
        """int64 (k,): points of the triangles of a group, or of faces whose names fit a pattern; ascending. KeyError for none."""
        if name in self.groups:
            chosen = self.groups[name]
        else:
            # Patterns have * and ? only.
            pattern = name.replace("[", "[[]")
            fits = [list_ for face, list_ in self.faces.items() if fnmatch.fnmatchcase(face, pattern)]
            if not fits:
                raise KeyError(f"there is no group and no face {name!r}")
            chosen = numpy.concatenate(fits)
        return numpy.unique(self.triangles[chosen])

    @property
    def volumes(self):
        """float64 (m,): volumes of the tetrahedra, in the cubed unit of the part."""
        return volumes(self.points, self.tets)

    def to_meshio(self):
        """As a meshio.Mesh: tetrahedra, then triangles. Cell sets are faces and groups; point sets of the same names are their points."""
        import meshio

        none = numpy.zeros(0, dtype=numpy.int64)
        names = {**self.faces, **self.groups}
        inside = numpy.full(len(self.tets), -1, dtype=numpy.int64)
        return meshio.Mesh(
            self.points,
            [("tetra", self.tets), ("triangle", self.triangles)],
            cell_data={"face": [inside, self.labels.astype(numpy.int64)]},
            cell_sets={name: [none, list_] for name, list_ in names.items()},
            point_sets={name: self.nodes(name) for name in names},
        )

    def to_netgen(self):
        """As a netgen.meshing.Mesh, which `ngsolve.Mesh` takes. A boundary is called as the first group with its face, or else as the face."""
        from ._convert import to_netgen

        def name(face, called):
            holding = (group for group, list_ in self.groups.items() if (self.labels[list_] == face).any())
            return next(holding, called)

        return to_netgen(self, [name(i, called) for i, called in enumerate(self.face_names)], self.tets.tolist())

    def write(self, *paths, **options):
        """Writes files by meshio, formats by extension; options go to meshio.write.

        Decks of solvers (.inp, .bdf) have the tetrahedra alone, .inp the names as sets of nodes; .msh has faces as physical groups;
        .vtu and .vtk have a number for each face, and 1 where a triangle is of a group.
        """
        import meshio

        for path in paths:
            whole, how = self.to_meshio(), dict(options)
            kind = str(path).rpartition(".")[2].lower()
            if kind in ("inp", "bdf", "nas", "fem"):
                whole = meshio.Mesh(self.points, whole.cells[:1], point_sets=whole.point_sets)
            elif kind == "msh":
                count = len(self.face_names)
                solid = numpy.full(len(self.tets), count + 1)
                tags = [solid, self.labels.astype(numpy.int64) + 1]
                names = {name: numpy.array([i + 1, 2]) for i, name in enumerate(self.face_names)}
                names["solid"] = numpy.array([count + 1, 3])
                data = {"gmsh:physical": tags, "gmsh:geometrical": tags}
                whole = meshio.Mesh(self.points, whole.cells, cell_data=data, field_data=names)
                how.setdefault("file_format", "gmsh22")
            elif kind in ("vtu", "vtk", "xdmf"):
                data = {"face": whole.cell_data["face"]}
                for name, list_ in self.groups.items():
                    on = numpy.zeros(len(self.triangles), dtype=numpy.int64)
                    on[list_] = 1
                    data[name] = [numpy.zeros(len(self.tets), dtype=numpy.int64), on]
                whole = meshio.Mesh(self.points, whole.cells, cell_data=data)
            meshio.write(path, whole, **how)

    def __repr__(self):
        return f"<rvachev.Filled: {len(self.points)} points, {len(self.tets)} tetrahedra by {self.by}>"


def volumes(points, tets):
    a, b, c, d = (points[tets[:, i]] for i in range(4))
    return numpy.einsum("ij,ij->i", numpy.cross(b - a, c - a), d - a) / 6


def fill(mesh, by="gmsh", size=None):
    if by not in PACKAGES:
        raise InputError(f"{by!r} is no generator of tetrahedra", help=", ".join(PACKAGES))
    if size is not None and not (numpy.isfinite(size) and size > 0):
        raise InputError(f'"size" of fill() must be positive, not {size}')
    if len(mesh.triangles) == 0:
        raise InputError("a mesh without triangles has no inside")
    try:
        package = importlib.import_module(by)
    # Libraries a package is linked against may be missing too.
    except (ImportError, OSError) as e:
        what = f"fill({by!r}) needs the Python package {PACKAGES[by]}, which cannot be imported: {e}"
        raise InputError(what, help=f"pip install {PACKAGES[by]}") from e
    shells = Shells(mesh.points, mesh.triangles)
    made = {"gmsh": by_gmsh, "tetgen": by_tetgen, "netgen": by_netgen, "pytetwild": by_pytetwild}[by]
    try:
        points, tets = made(package, mesh, shells, size)
    except (Failed, InputError):
        raise
    except Exception as e:  # noqa: BLE001 - each package has exceptions of its own
        raise Failed(f"{by} could not fill the surface: {e}") from e
    points = numpy.ascontiguousarray(points, dtype=numpy.float64)
    tets = numpy.ascontiguousarray(tets, dtype=numpy.int64)
    if by in ("tetgen", "netgen") and shells.cavities:
        # These fill cavities too. A region between surfaces is inside or not as one of its tetrahedra is.
        region = regions(tets, mesh.triangles)
        first = numpy.unique(region, return_index=True)[1]
        solid = angles(mesh.points, mesh.triangles, points[tets[first]].mean(axis=1)) > 0.5
        points, tets = used(points, tets[solid[region]], len(mesh.points))
    turned = volumes(points, tets) < 0
    tets[turned] = tets[turned][:, [0, 2, 1, 3]]
    if len(tets) == 0:
        raise Failed(f"{by} found no tetrahedra inside the surface")
    facets = boundary(tets)
    if by == "pytetwild":
        labels = mesh.labels[nearest(mesh, points[facets].mean(axis=1))]
        return Filled(mesh, points, tets, facets, labels, by)
    if not numpy.array_equal(points[: len(mesh.points)], mesh.points) or turns(facets) != turns(mesh.triangles):
        raise Failed(f"{by} did not keep the triangles of the surface")
    return Filled(mesh, points, tets, mesh.triangles, mesh.labels, by)


def turns(triangles):
    """Triangles as a set, each begun at its least point."""
    first = triangles.argmin(axis=1)
    rows = numpy.arange(len(triangles))
    return set(map(tuple, numpy.stack([triangles[rows, (first + k) % 3] for k in range(3)], axis=1).tolist()))


def boundary(tets):
    """Facets of one tetrahedron only, counter-clockwise seen from outside."""
    all_ = tets[:, FACETS].reshape(-1, 3)
    _, back, count = numpy.unique(numpy.sort(all_, axis=1), axis=0, return_inverse=True, return_counts=True)
    return all_[count[back.ravel()] == 1]


def used(points, tets, keep):
    """Without points no tetrahedron has, but for the first `keep`."""
    on = numpy.zeros(len(points), dtype=bool)
    on[tets] = True
    on[:keep] = True
    number = numpy.cumsum(on) - 1
    return points[on], number[tets]


class Shells:
    """The surface in pieces that hang together: which bound solids from outside, and which are cavities of which of these."""

    def __init__(self, points, triangles):
        self.piece = pieces(triangles, len(points))
        self.triangles = [triangles[self.piece == i] for i in range(self.piece.max() + 1)]
        corner = points[triangles] - points.mean(axis=0)
        each = numpy.einsum("ij,ij->i", corner[:, 0], numpy.cross(corner[:, 1], corner[:, 2])) / 6
        self.volume = numpy.bincount(self.piece, weights=each)
        self.outer = numpy.flatnonzero(self.volume > 0)
        self.cavities = {}
        for cavity in numpy.flatnonzero(self.volume <= 0):
            at = points[self.triangles[cavity][0, 0]][None]
            around = [i for i in self.outer if abs(angles(points, self.triangles[i], at)[0]) > 0.5]
            if not around:
                raise InputError("the surface does not bound a solid: a piece of it faces inwards with nothing around it")
            self.cavities.setdefault(min(around, key=lambda i: self.volume[i]), []).append(cavity)


def angles(points, triangles, at):
    """How often triangles wind around each point of `at`: solid angles over 4 pi [van Oosterom and Strackee]."""
    out = numpy.zeros(len(at))
    step = max(1, BLOCK // max(1, len(triangles)))
    for i in range(0, len(at), step):
        a, b, c = (points[triangles[:, k]][None] - at[i : i + step, None] for k in range(3))
        la, lb, lc = (numpy.linalg.norm(v, axis=2) for v in (a, b, c))
        dot = lambda u, v: (u * v).sum(axis=2)  # noqa: E731
        up = dot(a, numpy.cross(b, c))
        down = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb
        out[i : i + step] = numpy.arctan2(up, down).sum(axis=1) / (2 * numpy.pi)
    return out


def pieces(rows, count):
    """Which rows of numbers below `count` hang together by those they share: a number for each row, from 0."""
    least = numpy.arange(count)
    # Each takes the least number around it, then that one's own, until nothing changes.
    while True:
        before = least.copy()
        low = least[rows].min(axis=1)
        for k in range(rows.shape[1]):
            numpy.minimum.at(least, rows[:, k], low)
        least = least[least]
        if numpy.array_equal(before, least):
            return numpy.unique(least[rows[:, 0]], return_inverse=True)[1]


def regions(tets, triangles):
    """Which tetrahedra hang together by facets that are not of the surface: a number for each, from 0."""
    facets = numpy.sort(tets[:, FACETS].reshape(-1, 3), axis=1)
    all_ = numpy.concatenate([numpy.sort(triangles, axis=1), facets])
    back = numpy.unique(all_, axis=0, return_inverse=True)[1].ravel()
    wall = numpy.zeros(back.max() + 1, dtype=bool)
    wall[back[: len(triangles)]] = True
    number = back[len(triangles) :].reshape(-1, 4)
    # A wall is a number of its own on either side.
    alone = len(wall) + numpy.arange(number.size).reshape(-1, 4)
    return pieces(numpy.where(wall[number], alone, number), len(wall) + number.size)


def nearest(mesh, at):
    """The triangle of the surface next to each point, among those whose middles are."""
    corners = mesh.points[mesh.triangles]
    middle = corners.mean(axis=1)
    few = min(16, len(middle))
    out = numpy.zeros(len(at), dtype=numpy.int64)
    step = max(1, BLOCK // len(middle))
    for i in range(0, len(at), step):
        some = at[i : i + step]
        far = (middle**2).sum(axis=1) - 2 * some @ middle.T
        found = numpy.argpartition(far, few - 1, axis=1)[:, :few]
        best = distance(corners[found], some).argmin(axis=1)
        out[i : i + step] = found[numpy.arange(len(some)), best]
    return out


def distance(corners, at):
    """Squared distances of points (n, 3) from triangles (n, k, 3, 3): (n, k)."""
    a = corners[:, :, 0]
    u, v = corners[:, :, 1] - a, corners[:, :, 2] - a
    w = at[:, None] - a
    dot = lambda x, y: (x * y).sum(axis=2)  # noqa: E731
    uu, uv, vv, wu, wv = dot(u, u), dot(u, v), dot(v, v), dot(w, u), dot(w, v)
    det = numpy.maximum(uu * vv - uv * uv, numpy.finfo(float).tiny)
    s, t = (vv * wu - uv * wv) / det, (uu * wv - uv * wu) / det
    inside = (s >= 0) & (t >= 0) & (s + t <= 1)
    flat = ((w - s[..., None] * u - t[..., None] * v) ** 2).sum(axis=2)
    best = numpy.where(inside, flat, numpy.inf)
    for k in range(3):
        start = corners[:, :, k]
        along = corners[:, :, (k + 1) % 3] - start
        off = at[:, None] - start
        share = numpy.clip(dot(off, along) / numpy.maximum(dot(along, along), numpy.finfo(float).tiny), 0, 1)
        best = numpy.minimum(best, ((off - share[..., None] * along) ** 2).sum(axis=2))
    return best


# ------------------------------------------------------------------------------------------------------------ generators


def by_gmsh(gmsh, mesh, shells, size):
    """One discrete surface for each shell, one volume for each solid; of the mesh only three dimensions are made."""
    ours = not gmsh.isInitialized()
    if ours:
        gmsh.initialize(readConfigFiles=False, interruptible=False)
    wanted = {"General.Terminal": 0, "Mesh.MeshSizeMax": 1e22 if size is None else size, "Mesh.MeshSizeExtendFromBoundary": 1}
    # 10 is HXT: on the cube with holes in a quarter of the time of Delaunay (1), with better least angles. The same on each run.
    wanted.update({"Mesh.Algorithm3D": 10, "Mesh.ElementOrder": 1, "Mesh.Optimize": 1})
    before = {name: gmsh.option.getNumber(name) for name in wanted}
    current = None if ours else gmsh.model.getCurrent()
    name = "rvachev.fill"
    try:
        for option, value in wanted.items():
            gmsh.option.setNumber(option, value)
        gmsh.model.add(name)
        for i, triangles in enumerate(shells.triangles):
            gmsh.model.addDiscreteEntity(2, i + 1)
            own = numpy.unique(triangles)
            gmsh.model.mesh.addNodes(2, i + 1, own + 1, mesh.points[own].ravel())
            gmsh.model.mesh.addElementsByType(i + 1, 2, [], triangles.ravel() + 1)
        for outer in shells.outer:
            loops = [gmsh.model.geo.addSurfaceLoop([int(i) + 1]) for i in [outer, *shells.cavities.get(outer, [])]]
            gmsh.model.geo.addVolume(loops)
        gmsh.model.geo.synchronize()
        gmsh.model.mesh.generate(3)
        tags, at, _ = gmsh.model.mesh.getNodes()
        tets = gmsh.model.mesh.getElementsByType(4)[1].reshape(-1, 4)
        tags = tags.astype(numpy.int64)
        order = numpy.argsort(tags)
        number = numpy.full(tags.max() + 1, -1, dtype=numpy.int64)
        number[tags[order]] = numpy.arange(len(tags))
        return at.reshape(-1, 3)[order], number[tets.astype(numpy.int64)]
    finally:
        if ours:
            gmsh.finalize()
        else:
            if name in gmsh.model.list():
                gmsh.model.setCurrent(name)
                gmsh.model.remove()
            gmsh.model.setCurrent(current)
            for option, value in before.items():
                gmsh.option.setNumber(option, value)


def by_tetgen(tetgen, mesh, shells, size):
    maker = tetgen.TetGen(mesh.points.copy(), mesh.triangles.astype(numpy.int32))
    # Y: no points on the surface. The volume is that of a regular tetrahedron.
    limit = {} if size is None else {"fixedvolume": True, "maxvolume": size**3 / (6 * 2**0.5)}
    found = maker.tetrahedralize(plc=True, nobisect=True, quality=True, minratio=1.5, mindihedral=10, verbose=0, **limit)
    return found[0], found[1]


def by_netgen(netgen, mesh, shells, size):
    from netgen import meshing

    whole = meshing.Mesh(dim=3)
    numbers = [whole.Add(meshing.MeshPoint(meshing.Pnt(*p))) for p in mesh.points.tolist()]
    # One description for all: names are kept on this side.
    face = whole.Add(meshing.FaceDescriptor(surfnr=1, domin=1, domout=0, bc=1))
    for a, b, c in mesh.triangles.tolist():
        whole.Add(meshing.Element2D(face, [numbers[a], numbers[b], numbers[c]]))
    limit = {} if size is None else {"maxh": size}
    whole.GenerateVolumeMesh(**limit)
    at = numpy.array([p.p for p in whole.Points()])
    tets = numpy.array([[v.nr - 1 for v in e.vertices] for e in whole.Elements3D()], dtype=numpy.int64).reshape(-1, 4)
    return at, tets


def by_pytetwild(pytetwild, mesh, shells, size):
    share = 0.05 if size is None else size / numpy.linalg.norm(numpy.ptp(mesh.points, axis=0))
    points, triangles = mesh.points.copy(), mesh.triangles.astype(numpy.int32)
    # It leaves a file where it runs.
    here = os.getcwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            found = pytetwild.tetrahedralize(points, triangles, edge_length_fac=min(share, 1.0))
        finally:
            os.chdir(here)
    return found[0], found[1]
