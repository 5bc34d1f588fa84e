from collections.abc import Callable, Iterable
from os import PathLike
from typing import Any, Literal, Protocol, TypedDict, final

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import Self, Unpack

from ._fill import Filled

Number = float | int
Vector = tuple[Number, Number, Number] | list[Number] | NDArray[np.floating[Any]]
Axis = Literal["x", "y", "z"] | Vector
Size = Number | str
Path = str | PathLike[str]

class Event(Protocol):
    def is_set(self) -> bool: ...

Remedy = Literal["halving", "least-length", "plane", "inset", "trim"]

class Run(TypedDict, total=False):
    progress: bool | Callable[[str, float], object] | None
    cancel: Event | None
    threads: int

class Options(Run, total=False):
    method: Literal["leaf", "operators", "paper", "cut", "mc"]
    sequence: str
    angle: float
    tol: Size
    volume: float
    grading: float
    size_min: Size
    trim: Size
    without: Remedy | list[Remedy]
    thickness: float
    refine: str | list[str]
    eps: float
    memory: float
    measure: bool
    feature_angle: float
    min_area: float
    min_length: float
    nodes: int
    close: bool
    force: bool
    define: dict[str, float]

class CompareOptions(Options, total=False):
    png: Path | None
    color: Literal["angle", "class"] | None

class HealOptions(Run, total=False):
    max_hole: int
    force: bool

class FaceOptions(Run, total=False):
    force: bool

class CheckOptions(Run, total=False):
    define: dict[str, float]

class TrianglesOptions(Run, total=False):
    size: Size
    feature_angle: float
    min_area: float
    min_length: float
    nodes: int
    close: bool

class PictureOptions(CheckOptions, total=False):
    view: Literal["iso", "front", "back", "left", "right", "top", "bottom"] | str | tuple[Number, Number]
    focus: tuple[Number, Number, Number, Number] | str
    clip: str | list[str]
    color: Literal["face", "angle", "edge", "distance", "class"]
    against: Part | Path
    edges: Literal["none", "sharp", "all"]
    pixels: tuple[int, int] | str
    transparent: bool
    legend: bool

__version__: str
x: Expr
y: Expr
z: Expr

@final
class Expr:
    """A formula in the coordinates x, y and z."""

    def __add__(self, other: Expr | Number) -> Expr: ...
    def __radd__(self, other: Number) -> Expr: ...
    def __sub__(self, other: Expr | Number) -> Expr: ...
    def __rsub__(self, other: Number) -> Expr: ...
    def __mul__(self, other: Expr | Number) -> Expr: ...
    def __rmul__(self, other: Number) -> Expr: ...
    def __truediv__(self, other: Expr | Number) -> Expr: ...
    def __rtruediv__(self, other: Number) -> Expr: ...
    def __pow__(self, other: Expr | Number) -> Expr: ...
    def __rpow__(self, other: Number) -> Expr: ...
    def __mod__(self, other: Expr | Number) -> Expr: ...
    def __rmod__(self, other: Number) -> Expr: ...
    def __floordiv__(self, other: Expr | Number) -> Expr: ...
    def __rfloordiv__(self, other: Number) -> Expr: ...
    def __floor__(self) -> Expr: ...
    def __ceil__(self) -> Expr: ...
    def __trunc__(self) -> Expr: ...
    def __round__(self) -> Expr: ...
    def __neg__(self) -> Expr: ...
    def __pos__(self) -> Expr: ...
    def __abs__(self) -> Expr: ...
    def __ge__(self, other: Expr | Number) -> Solid: ...
    def __gt__(self, other: Expr | Number) -> Solid: ...
    def __le__(self, other: Expr | Number) -> Solid: ...
    def __lt__(self, other: Expr | Number) -> Solid: ...
    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **kwargs: Any) -> Any: ...
    def sqrt(self) -> Expr: ...
    def exp(self) -> Expr: ...
    def log(self) -> Expr: ...
    def sin(self) -> Expr: ...
    def cos(self) -> Expr: ...
    def tan(self) -> Expr: ...
    def arcsin(self) -> Expr: ...
    def arccos(self) -> Expr: ...
    def arctan(self) -> Expr: ...
    def sinh(self) -> Expr: ...
    def cosh(self) -> Expr: ...
    def tanh(self) -> Expr: ...
    def floor(self) -> Expr: ...
    def ceil(self) -> Expr: ...
    def trunc(self) -> Expr: ...
    def rint(self) -> Expr: ...

@final
class Solid:
    """A solid: `|` is the union, `&` the intersection, `-` the difference, `~` the complement."""

    def __or__(self, other: Solid) -> Solid: ...
    def __and__(self, other: Solid) -> Solid: ...
    def __sub__(self, other: Solid) -> Solid: ...
    def __invert__(self) -> Solid: ...
    def name(self, name: str) -> Solid: ...
    def size(self, h: float) -> Solid: ...
    def move(self, by: Vector) -> Solid: ...
    def rotate(self, degrees: float, axis: Axis = "z", at: Vector = (0, 0, 0)) -> Solid: ...
    def scale(self, k: float) -> Solid: ...
    def mirror(self, axis: Axis, at: Vector = (0, 0, 0)) -> Solid: ...

class _Placed:
    def move(self, by: Vector) -> Self: ...
    def rotate(self, degrees: float, axis: Axis = "z", at: Vector = (0, 0, 0)) -> Self: ...
    def scale(self, k: float, about: Vector | Literal["mass"] | None = None) -> Self: ...
    def mirror(self, axis: Axis, at: Vector = (0, 0, 0)) -> Self: ...

@final
class Edges(_Placed):
    """A chain of edges in space."""

@final
class Built(_Placed):
    """A solid or sheet built from edges."""

    def name(self, name: str) -> Built: ...
    def without(self, *faces: str) -> Built: ...

@final
class Part:
    """A solid with a unit, groups of faces, and wishes for its mesh."""

    def __init__(
        self,
        solid: Solid | Built | Iterable[Solid | Built],
        *,
        units: Literal["m", "dm", "cm", "mm", "um", "in", "ft"] | None = None,
        domain: tuple[Vector, Vector] | None = None,
        rsystem: str | tuple[str, Number] | None = None,
        size: Size | None = None,
        size_min: Size | None = None,
    ) -> None: ...
    @staticmethod
    def load(path: Path, define: dict[str, float] | None = None) -> Part: ...
    def group(self, name: str, *faces: str) -> None: ...
    @property
    def units(self) -> str | None:
        """"mm" and the like; only files are told."""
    @units.setter
    def units(self, units: Literal["m", "dm", "cm", "mm", "um", "in", "ft"] | None) -> None: ...
    @property
    def groups(self) -> dict[str, tuple[str, ...]]: ...
    @property
    def face_names(self) -> tuple[str, ...]:
        """Of the part's function, as evaluate numbers them."""
    def info(self) -> dict[str, Any]: ...
    def write(self, *paths: Path) -> None: ...
    def mesh(self, size: Size | None = None, **options: Unpack[Options]) -> Mesh: ...

@final
class Task:
    """A brick to be made: what `mesh_brick` takes. It can be pickled."""

    @property
    def brick(self) -> int: ...
    @property
    def cost(self) -> int:
        """How many regions of 8 by 8 by 8 cells may hold some of the surface."""

@final
class Piece:
    """A brick that was made: what `merge` takes. It can be pickled."""

    @property
    def brick(self) -> int: ...

@final
class Prisms:
    """A volume in layers of prisms: what Mesh.sweep gives."""

    @property
    def points(self) -> NDArray[np.float64]:
        """(n, 3), in the part's unit."""
    @property
    def cells(self) -> NDArray[np.int64]:
        """(m, 6): three points of the bottom, and those across from them."""
    @property
    def sides(self) -> NDArray[np.int64]:
        """(k, 4), the boundary, counter-clockwise seen from outside; a triangle has its third point twice."""
    @property
    def labels(self) -> NDArray[np.uint32]:
        """(k,), indices into names."""
    @property
    def names(self) -> list[str]: ...
    @property
    def faces(self) -> dict[str, NDArray[np.int64]]:
        """Sides of each name, (j,)."""
    @property
    def volume(self) -> float: ...
    def hexahedra(self, off: Number = 45.0) -> Hexahedra:
        """Pairs of prisms as hexahedra whose quadrilaterals have angles at most off degrees from right ones."""
    def write(self, *paths: Path, msh_version: Literal["4.1", "2.2"] = "4.1") -> None: ...
    def to_meshio(self) -> Any: ...

@final
class Hexahedra:
    """A volume in layers of hexahedra, and of prisms without a partner: what Prisms.hexahedra gives."""

    @property
    def points(self) -> NDArray[np.float64]:
        """(n, 3), in the part's unit; those of the prisms."""
    @property
    def cells(self) -> NDArray[np.int64]:
        """(m, 8): four points of the bottom, and those across from them."""
    @property
    def prisms(self) -> NDArray[np.int64]:
        """(l, 6), those that stay."""
    @property
    def sides(self) -> NDArray[np.int64]:
        """(k, 4), the boundary, counter-clockwise seen from outside; a triangle has its third point twice."""
    @property
    def labels(self) -> NDArray[np.uint32]:
        """(k,), indices into names."""
    @property
    def names(self) -> list[str]: ...
    @property
    def faces(self) -> dict[str, NDArray[np.int64]]:
        """Sides of each name, (j,)."""
    @property
    def volume(self) -> float: ...
    def write(self, *paths: Path, msh_version: Literal["4.1", "2.2"] = "4.1") -> None: ...
    def to_meshio(self) -> Any: ...

@final
class Mesh:
    """`points, triangles = mesh`; arrays lie on the library's memory and are read-only."""

    @property
    def points(self) -> NDArray[np.float64]:
        """(n, 3), in the part's unit."""
    @property
    def triangles(self) -> NDArray[np.int64]:
        """(m, 3), counter-clockwise seen from outside."""
    @property
    def labels(self) -> NDArray[np.uint32]:
        """(m,), indices into face_names."""
    @property
    def face_names(self) -> list[str]: ...
    @property
    def faces(self) -> dict[str, NDArray[np.int64]]:
        """Triangles of each face, (k,)."""
    @property
    def groups(self) -> dict[str, NDArray[np.int64]]:
        """Triangles of each group, (k,)."""
    def nodes(self, name: str) -> NDArray[np.int64]:
        """Points of a group, or of faces that fit a pattern, (k,)."""
    @property
    def feature_edges(self) -> NDArray[np.int64]:
        """(k, 2)."""
    @property
    def corners(self) -> NDArray[np.int64]:
        """(k,)."""
    @property
    def normals(self) -> NDArray[np.float64]:
        """Outward unit normals of the triangles, (m, 3)."""
    @property
    def report(self) -> dict[str, Any]: ...
    @property
    def certificate(self) -> dict[str, Any] | None: ...
    @property
    def shortfalls(self) -> list[str]: ...
    @property
    def units(self) -> str | None: ...
    def __iter__(self) -> Any: ...
    def write(
        self, *paths: Path, groups: Literal["faces", "user", "all"] = "all", msh_version: Literal["4.1", "2.2"] = "4.1"
    ) -> None: ...
    def to_meshio(self) -> Any: ...
    def to_trimesh(self) -> Any: ...
    def to_pyvista(self) -> Any: ...
    def to_netgen(self) -> Any: ...
    def to_gmsh(self, name: str = "rvachev") -> str:
        """A model of gmsh with named surfaces, and volumes to be filled."""
    def remesh_face(self, name: str, size: Number, **options: Unpack[FaceOptions]) -> Mesh:
        """One face made anew with edges of length size, in the part's unit; all others stay bit by bit.

        For solids of functions by the method leaf, solids built from edges, CAD models and surfaces of triangles.
        """
    def sweep(
        self, face: str, *, along: Vector | None = None, to: str | None = None, layers: int = 1
    ) -> Prisms:
        """Layers of prisms: what a face sweeps along a vector, or the room between it and the face to."""
    def to_html(self, title: str = "mesh") -> str:
        """One page that shows the mesh in a browser."""
    def _repr_html_(self) -> str | None: ...
    def fill(self, by: Literal["gmsh", "tetgen", "netgen", "pytetwild"] = "gmsh", size: float | None = None) -> Filled: ...

def made(kind: str, function: str, *args: Any, **kwargs: Any) -> Any: ...
def union(*solids: Solid | Iterable[Solid]) -> Solid: ...
def intersection(*solids: Solid | Iterable[Solid]) -> Solid: ...
def blend(a: Solid, b: Solid, radius: float) -> Solid: ...
def extruded(figure: Solid, height: float) -> Solid: ...
def revolved(figure: Solid) -> Solid: ...
def solid(f: Expr | Solid | Callable[[Any, Any, Any], Any]) -> Solid: ...
def field(
    function: Callable[[NDArray[np.float64]], ArrayLike],
    *,
    gradient: Callable[[NDArray[np.float64]], ArrayLike] | None = None,
    lipschitz: float | None = None,
    bounds: tuple[Vector, Vector] | None = None,
) -> Solid: ...
def grid(values: ArrayLike, origin: Vector = (0, 0, 0), spacing: Number | Vector = 1.0) -> Solid: ...
def mesh(source: Part | Solid | Built | Path, size: Size | None = None, **options: Unpack[Options]) -> Mesh: ...
def expected_triangles(
    source: Part | Solid | Built | Path, size: Size | None = None, **options: Unpack[Options]
) -> int:
    """About how many triangles mesh gives with these arguments; no mesh is made."""
def remesh(
    points: ArrayLike | Mesh, triangles: ArrayLike | None = None, size: Size | None = None, **options: Unpack[Options]
) -> Mesh: ...
def heal(points: ArrayLike | Mesh, triangles: ArrayLike | None = None, **options: Unpack[HealOptions]) -> Mesh: ...
def check(
    points: ArrayLike | Mesh,
    triangles: ArrayLike | None = None,
    against: Part | Path | None = None,
    **options: Unpack[CheckOptions],
) -> dict[str, Any]: ...
def plan(
    part: Part | Path, size: Size | None = None, *, bricks: tuple[int, int, int], **options: Unpack[Options]
) -> list[Task]:
    """Bricks of a mesh for any executor: merge(executor.map(mesh_brick, plan("part.py", "0.5%", bricks=(4, 4, 2))))."""
def mesh_brick(task: Task) -> Piece: ...
def merge(pieces: Iterable[Piece], **options: Unpack[Options]) -> Mesh: ...
def task_again(plan: str, brick: int) -> Task: ...
def piece_again(plan: str, brick: int, bytes: bytes) -> Piece: ...
def evaluate(part: Part | Solid, points: ArrayLike, gradient: bool = False, faces: bool = False) -> Any:
    """Values, float64 (N,); with either flag a tuple: values, gradients (N, 3), and faces, int32 (N,), indices into Part.face_names or -1."""
def read_triangles(path: Path, **options: Unpack[Run]) -> tuple[NDArray[np.float64], NDArray[np.int64]]: ...
def carry(mesh: Mesh, values: ArrayLike, to: Mesh | ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Values at a mesh's points, (n, ...), at other points, (k, ...), and how far these are from the mesh, (k,)."""
def shortest_path(mesh: Mesh, start: Vector, end: Vector) -> tuple[NDArray[np.float64], float]:
    """The points, (k, 3), and the length of the shortest way over a mesh."""
def join(meshes: Iterable[Mesh], within: Size | None = None) -> Mesh:
    """Meshes joined to one where nodes are no farther apart than within (0.0001% of the diagonal of all)."""
def step_check(path: Path, **options: Unpack[Run]) -> dict[str, Any]: ...
def step_info(path: Path, **options: Unpack[Run]) -> dict[str, Any]: ...
def compare(part: Part, size: Size | None = None, **options: Unpack[CompareOptions]) -> dict[str, Any]: ...
def compare_rsystems(part: Part, size: Size | None = None, **options: Unpack[Options]) -> dict[str, Any]: ...
def compare_samples(size: Size | None = None, **options: Unpack[CompareOptions]) -> dict[str, Any]: ...
def compare_triangles(
    points: ArrayLike | Mesh | Path,
    triangles: ArrayLike | None = None,
    size: Size | None = None,
    **options: Unpack[CompareOptions],
) -> dict[str, Any]: ...
def triangles_info(
    points: ArrayLike | Mesh | Path, triangles: ArrayLike | None = None, **options: Unpack[TrianglesOptions]
) -> dict[str, Any]: ...
def picture(
    points: ArrayLike | Mesh,
    triangles: ArrayLike | None = None,
    path: Path | None = None,
    **options: Unpack[PictureOptions],
) -> NDArray[np.uint8]:
    """Pixels, (height, width, 4), and with a path a PNG file."""
def curvature(
    points: ArrayLike | Mesh, triangles: ArrayLike | None = None
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Principal curvatures, (n, 2), as magnitudes, 1 over length; and angle defects, (n,), radians."""
def node_classes(points: ArrayLike | Mesh, triangles: ArrayLike | None = None) -> NDArray[np.uint8]:
    """(n,): 0 regular, 1 on a crease, 2 a corner."""
def distances(
    points: ArrayLike | Mesh, triangles: ArrayLike | None = None, *, against: Part
) -> NDArray[np.float64]:
    """How far points are from the surface of a part, (n,)."""
