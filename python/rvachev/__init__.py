"""Solids to triangle surface meshes an engineer can compute on.

A solid is built of primitives, formulas and functions by set operations; a part is a solid with a unit and named groups of faces;
a mesh is arrays of numpy that know the face of each triangle:

>>> import rvachev as rv
>>> body = rv.box(size=(2, 2, 2)).name("body")
>>> part = rv.Part(body - rv.cylinder(0.4).name("bore"), units="mm")
>>> points, triangles = part.mesh(size="4%")

Lengths are in the part's own unit, angles in degrees. Inside is where functions are positive; triangles wind counter-clockwise seen
from outside. Names and arguments are those of part files.
"""

from __future__ import annotations

import math as _math
from functools import reduce as _reduce

import numpy as _np

from ._errors import Cancelled, Error, Failed, InputError, NotTraced, Shortfall, Told
from ._fill import Filled
from ._rvachev import (
    Built,
    Edges,
    Expr,
    Hexahedra,
    Mesh,
    Part,
    Piece,
    Prisms,
    Solid,
    Task,
    __version__,
    blend,
    carry,
    check,
    compare,
    compare_rsystems,
    compare_samples,
    compare_triangles,
    curvature,
    distances,
    evaluate,
    expected_triangles,
    field,
    grid,
    heal,
    intersection,
    join,
    merge,
    mesh,
    mesh_brick,
    node_classes,
    picture,
    plan,
    read_triangles,
    remesh,
    shortest_path,
    solid,
    step_check,
    step_info,
    triangles_info,
    union,
    x,
    y,
    z,
)
from ._rvachev import extruded as _extruded
from ._rvachev import made as _made
from ._rvachev import revolved as _revolved

__all__ = [
    "Built", "Cancelled", "Edges", "Error", "Expr", "Failed", "Filled", "Hexahedra", "InputError", "Mesh", "NotTraced", "Part", "Piece", "Prisms", "Shortfall", "Solid", "Task", "Told",
    "arc", "bezier", "bezier_surface", "bilinear", "blend", "box", "carry", "chain", "check", "circle", "compare", "compare_rsystems", "compare_samples", "compare_triangles", "cone", "conic", "curvature", "cylinder",
    "diamond", "distances", "ellipse", "ellipsoid", "evaluate", "expected_triangles", "extrude", "extrude_edges", "field", "fillet_surface", "flat_face", "grid",
    "gyroid", "half_space", "heal", "hermite", "hyperbola", "intersection", "join", "lagrange", "loft", "merge", "mesh", "mesh_brick",
    "node_classes", "nurbs", "nurbs_surface", "parabola", "picture", "plan", "polygon", "polyline", "polynomial", "read_triangles", "rectangle", "remesh", "revolve",
    "revolve_edges", "ruled", "schwarz_p", "sectorial", "sew", "shift", "shortest_path", "solid", "sphere", "spline", "spline_surface", "step_check",
    "step_info", "sweep_edges", "torus", "triangles_info", "union", "x", "y", "z",
]

# What part files call numpy's functions.
pi = _math.pi
sqrt, exp, log, sin, cos, tan, atan2 = _np.sqrt, _np.exp, _np.log, _np.sin, _np.cos, _np.tan, _np.arctan2


def _all(items):
    return items[0] if len(items) == 1 else items


def min(*items):  # noqa: A001 - the name part files have
    """The smallest of numbers and formulas."""
    return _reduce(_np.minimum, _all(items))


def max(*items):  # noqa: A001 - the name part files have
    """The largest of numbers and formulas."""
    return _reduce(_np.maximum, _all(items))


def hypot(*items):
    """The length of a vector of numbers or formulas."""
    return _reduce(_np.hypot, items) if len(items) > 1 else abs(*items)


def clamp(value, low, high):
    """A number or formula, but no less than low and no more than high."""
    return _np.minimum(_np.maximum(value, low), high)


# ----------------------------------------------------------------------------------------------------------- primitives


def box(size=None, at=None, *, lo=None, hi=None) -> Solid:
    """A box by its three sizes and its center (the origin), or by its extreme corners lo and hi. Faces xmin xmax ymin ymax zmin zmax."""
    return _made("solid", "box", size=size, at=at, lo=lo, hi=hi)


def sphere(r, at=None) -> Solid:
    """A sphere of radius r about a point. One face."""
    return _made("solid", "sphere", r=r, at=at)


def ellipsoid(radii, at=None) -> Solid:
    """An ellipsoid by its three half axes. One face."""
    return _made("solid", "ellipsoid", radii=radii, at=at)


def cylinder(r, axis=None, at=None, height=None) -> Solid:
    """A cylinder of radius r about an axis ("x", "y", "z" or a vector; z); infinite without a height. Faces side, bottom, top."""
    return _made("solid", "cylinder", r=r, axis=axis, at=at, height=height)


def cone(r0, r1, height, axis=None, at=None) -> Solid:
    """A truncated cone centered at a point: radius r0 at the bottom, r1 at the top; one may be 0. Faces side, bottom, top."""
    return _made("solid", "cone", r0=r0, r1=r1, height=height, axis=axis, at=at)


def torus(R, r, axis=None, at=None) -> Solid:
    """A torus: R from the axis to the middle of the tube, r the tube's radius. One face."""
    return _made("solid", "torus", R=R, r=r, axis=axis, at=at)


def half_space(normal, at=None) -> Solid:
    """The side of a plane through a point its normal points away from. One face."""
    return _made("solid", "half_space", normal=normal, at=at)


def gyroid(period, thickness, at=None) -> Solid:
    """The sheet of a gyroid. Faces plus and minus."""
    return _made("solid", "gyroid", period=period, thickness=thickness, at=at)


def schwarz_p(period, thickness, at=None) -> Solid:
    """The sheet of Schwarz' surface P. Faces plus and minus."""
    return _made("solid", "schwarz_p", period=period, thickness=thickness, at=at)


def diamond(period, thickness, at=None) -> Solid:
    """The sheet of Schwarz' surface D. Faces plus and minus."""
    return _made("solid", "diamond", period=period, thickness=thickness, at=at)


def polygon(points):
    """A simple polygon of points (x, y) in order, for extrude and revolve; gives the points."""
    points = tuple(tuple(float(c) for c in p) for p in points)
    _made("solid", "extrude", points, 1.0)
    return points


def rectangle(size, at=None) -> Solid:
    """A rectangle of two sizes around a point, the same at every z: a figure for extrude and revolve. Faces xmin xmax ymin ymax."""
    return _made("solid", "rectangle", size=size, at=at)


def extrude(figure, height, at=None) -> Solid:
    """A figure of the xy plane extruded along z, from -height / 2 to height / 2. Faces bottom, top and those of the figure.

    A figure is a polygon of points (x, y), a circle, an ellipse, or a solid that is the same at every z: rectangle(size),
    cylinder(r) without a height, comparisons of x and y, and set operations on them.
    """
    if isinstance(figure, (Solid, Expr)):
        made = _extruded(solid(figure), height)
        return made if at is None else made.move(at)
    return _made("solid", "extrude", figure=figure, height=height, at=at)


def revolve(figure) -> Solid:
    """A figure, as extrude takes it, turned about the z axis: x becomes the radius, y becomes z. Faces are those of the figure."""
    if isinstance(figure, (Solid, Expr)):
        return _revolved(solid(figure))
    return _made("solid", "revolve", figure=figure)


# ---------------------------------------------------------------------------------------------------- edges, and what they build


def polyline(points, closed=None) -> Edges:
    """Straight edges from point to point, (x, y) or (x, y, z)."""
    return _made("edges", "polyline", points=points, closed=closed)


def spline(points, closed=None, start=None, end=None, ends=None) -> Edges:
    """One cubic spline through points; start and end are derivatives there, both or neither.

    With ends="parabolic" the first and the last piece are parabolas.
    """
    return _made("edges", "spline", points=points, closed=closed, start=start, end=end, ends=ends)


def bezier(points, weights=None) -> Edges:
    """A Bezier curve by its control points, rational with weights."""
    return _made("edges", "bezier", points=points, weights=weights)


def chain(edges) -> Edges:
    """Joins chains of edges."""
    return _made("edges", "chain", edges)


def _edges(name, doc):
    def function(*args, **kwargs) -> Edges:
        return _made("edges", name, *args, **kwargs)

    function.__name__ = function.__qualname__ = name
    function.__doc__ = doc
    return function


def _built(name, doc):
    def function(*args, **kwargs) -> Built:
        return _made("built", name, *args, **kwargs)

    function.__name__ = function.__qualname__ = name
    function.__doc__ = doc
    return function


arc = _edges("arc", "A part of a circle; arguments as in part files.")
circle = _edges("circle", "A whole circle; arguments as in part files.")
ellipse = _edges("ellipse", "A whole ellipse; arguments as in part files.")
parabola = _edges("parabola", "An arc of a parabola by its focal length; arguments as in part files.")
hyperbola = _edges("hyperbola", "An arc of a hyperbola by its half axes; arguments as in part files.")
conic = _edges("conic", "An arc of a conic by its equation; arguments as in part files.")
polynomial = _edges("polynomial", "A curve by vectors times powers of a parameter; arguments as in part files.")
lagrange = _edges("lagrange", "One polynomial through points; arguments as in part files.")
nurbs = _edges("nurbs", "A NURBS curve by its control points; arguments as in part files.")
extrude_edges = _built("extrude_edges", "Edges extruded along a direction; arguments as in part files.")
revolve_edges = _built("revolve_edges", "Edges turned about an axis; arguments as in part files.")
loft = _built("loft", "A surface through sections; arguments as in part files.")
ruled = _built("ruled", "Straight surfaces from section to section; arguments as in part files.")
sweep_edges = _built("sweep_edges", "Edges moved along a path; arguments as in part files.")
flat_face = _built("flat_face", "A flat sheet within edges; arguments as in part files.")
sew = _built("sew", "Sheets joined where they meet; arguments as in part files.")
bilinear = _built("bilinear", "A sheet of straight lines between four corners; arguments as in part files.")
sectorial = _built("sectorial", "A sheet of straight lines from a curve to a point; arguments as in part files.")
shift = _built("shift", "A sheet: a profile shifted along a path; arguments as in part files.")
hermite = _built("hermite", "A sheet through chains by cubics; arguments as in part files.")
spline_surface = _built("spline_surface", "A NURBS sheet over chains; arguments as in part files.")
fillet_surface = _built("fillet_surface", "A sheet of circular arcs from chain to chain; arguments as in part files.")
bezier_surface = _built("bezier_surface", "A Bezier sheet by its net; arguments as in part files.")
nurbs_surface = _built("nurbs_surface", "A NURBS sheet by its net; arguments as in part files.")
