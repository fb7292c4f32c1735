"""Measures of triangles that several checks share, over whole arrays."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass
from functools import cached_property, wraps
from typing import Concatenate, ParamSpec, TypeVar
from weakref import WeakKeyDictionary

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from graben.arrays import BoolArray, FloatArray, IntArray, floats, ints
from graben.complexes import Complex
from graben.finding import Part
from graben.model import Horizon
from graben.surface import Surface, edge_sharing, edge_table, triangle_normals

#: Height over the longest side below which a triangle counts as having no area: above the rounding of
#: coordinates of hundreds of kilometres (1e-11 of a side of metres), far below any sliver.
ZERO_HEIGHT = 1e-9

#: Parts of one kind that a finding lists one by one.
MOST_PARTS = 50

#: Square metres from which on an area is told in square kilometres.
_KM2 = 1e5

#: Angle below which two angles are equal, degrees: above what rounding makes of coordinates of 500 km.
ANGLE_ROUNDING = 1e-6

Subject = TypeVar("Subject", Surface, Complex, Horizon)
Settings = ParamSpec("Settings")
Value = TypeVar("Value")


def remembered(
    function: Callable[Concatenate[Subject, Settings], Value],
) -> Callable[Concatenate[Subject, Settings], Value]:
    """Return a function of a surface, a complex or a horizon that keeps each result as long as that lives.

    They are immutable and told apart by identity, so several checks share what one has computed. What else
    the function is given must be hashable.
    """
    known: WeakKeyDictionary[Subject, dict[Hashable, Value]] = WeakKeyDictionary()

    @wraps(function)
    def recalled(subject: Subject, /, *args: Settings.args, **kwargs: Settings.kwargs) -> Value:
        """Return what is known, else the function's value."""
        own = known.setdefault(subject, {})
        key = args, *sorted(kwargs.items())
        if key not in own:
            own[key] = function(subject, *args, **kwargs)
        return own[key]

    return recalled


@dataclass(frozen=True, eq=False)
class Mesh:
    """The triangles of a surface that have three different corners, and their edges.

    Parameters
    ----------
    kept : (m,) array
        Their indices in the surface.
    triangles : (m, 3) array
        Vertex indices.
    edges : (e, 2) array
        Vertex indices, the smaller first.
    sides : (m, 3) array
        Edge opposite to each corner.
    sharing : (e,) array
        How many triangles share each edge.
    """

    kept: IntArray
    triangles: IntArray
    edges: IntArray
    sides: IntArray
    sharing: IntArray

    @cached_property
    def upward(self) -> BoolArray:
        """Whether the side opposite to each corner runs from its smaller vertex index, shape (m, 3)."""
        return np.asarray(self.triangles[:, [1, 2, 0]] < self.triangles[:, [2, 0, 1]])

    @cached_property
    def joints(self) -> IntArray:
        """The two sides of each edge with two triangles, as 3 times the triangle and the corner, (q, 2)."""
        inner = np.flatnonzero(self.sharing[self.sides.ravel()] == 2)
        order = np.argsort(self.sides.ravel()[inner], kind="stable")
        return inner[order].reshape(-1, 2)


@remembered
def mesh_of(surface: Surface) -> Mesh:
    """Return the triangles of a surface by vertex index, with their edges."""
    return meshed(surface.triangles, np.arange(len(surface.triangles)))


@remembered
def welded_mesh_of(surface: Surface) -> Mesh:
    """Return the triangles of a surface with vertices at one place, equal to the bit, taken as one.

    The first vertex of each place stands for it; of triangles on the same three places the first is kept.
    """
    place, once = places_of(surface), once_of(surface)
    if len(once) == len(surface.triangles) and np.array_equal(place, np.arange(len(place))):
        return mesh_of(surface)
    return meshed(place[surface.triangles], once)


def meshed(triangles: IntArray, among: IntArray) -> Mesh:
    """Return those of some triangles (m, 3), given by index, that have three different corners."""
    t = triangles[among]
    whole = (t[:, 0] != t[:, 1]) & (t[:, 1] != t[:, 2]) & (t[:, 2] != t[:, 0])
    t = ints(t[whole], -1, 3)
    edges, sides = edge_table(t)
    return Mesh(ints(among[whole]), t, edges, sides, edge_sharing(sides, len(edges)))


@remembered
def places_of(surface: Surface) -> IntArray:
    """Return the first vertex equal to the bit (0 and -0 are equal) for each vertex, shape (n,)."""
    points = surface.vertices + 0.0
    order = np.lexsort(points.T[::-1])
    new = np.ones(len(order), dtype=bool)
    new[1:] = (np.diff(points[order], axis=0) != 0).any(axis=1)
    # the sort is stable: the first of a place has the least index
    place = np.empty(len(order), dtype=np.int64)
    place[order] = order[new][np.cumsum(new) - 1]
    return ints(place)


@remembered
def once_of(surface: Surface) -> IntArray:
    """Return the triangles of a surface without those on the places of an earlier one, ascending, (k,)."""
    corners = np.sort(places_of(surface)[surface.triangles], axis=1)
    order = np.lexsort((corners[:, 1], corners[:, 0]))
    # runs of two equal corners are short: only in them the third is compared
    same = (np.diff(corners[order, :2], axis=0) == 0).all(axis=1)
    unclear = np.zeros(len(order), dtype=bool)
    unclear[1:] = same
    unclear[:-1] |= same
    asked = np.sort(order[unclear])
    first = np.unique(corners[asked], axis=0, return_index=True)[1]
    return ints(np.sort(np.concatenate([order[~unclear], asked[first]])))


def lengths(vectors: FloatArray) -> FloatArray:
    """Return the lengths of vectors (..., 3); several times as fast as a norm over the last axis."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    return np.asarray(np.sqrt(x * x + y * y + z * z))


@remembered
def sides_of(surface: Surface) -> FloatArray:
    """Return the length of the side opposite to each corner of a surface's triangles, shape (m, 3)."""
    return floats(side_lengths(surface.vertices, surface.triangles))


@remembered
def normals_of(surface: Surface) -> FloatArray:
    """Return the normals of a surface's triangles, length twice the area, shape (m, 3)."""
    return triangle_normals(surface.vertices, surface.triangles)


@remembered
def areas_of(surface: Surface) -> FloatArray:
    """Return the areas of a surface's triangles, shape (m,), square model units."""
    return floats(0.5 * lengths(normals_of(surface)))


def side_lengths(vertices: FloatArray, triangles: IntArray) -> FloatArray:
    """Return the length of the side opposite to each corner, shape (m, 3), model units."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    return np.stack([lengths(c - b), lengths(a - c), lengths(b - a)], axis=1)


def smallest_angles(vertices: FloatArray, triangles: IntArray) -> FloatArray:
    """Return the smallest angle of each triangle, shape (m,), degrees; 0 where there is no area."""
    normals = triangle_normals(vertices, triangles)
    return _smallest_angles(side_lengths(vertices, triangles), lengths(normals))


@remembered
def angles_of(surface: Surface) -> FloatArray:
    """Return the smallest angle of each triangle of a surface, see :func:`smallest_angles`."""
    return floats(_smallest_angles(sides_of(surface), 2.0 * areas_of(surface)))


def _smallest_angles(sides: FloatArray, double_area: FloatArray) -> FloatArray:
    a, b, c = sides.T
    longest = np.maximum(np.maximum(a, b), c)
    flat = double_area <= ZERO_HEIGHT * longest * longest
    # the smallest angle lies between the two longer sides: its sine is 2 A / (b c), its cosine is positive
    middle = np.maximum(np.minimum(a, b), np.minimum(np.maximum(a, b), c))
    sine = np.divide(double_area, middle * longest, out=np.zeros_like(a), where=~flat)
    return np.asarray(np.degrees(np.arcsin(np.minimum(sine, 1.0))), dtype=np.float64)


def centroids(vertices: FloatArray, triangles: IntArray) -> FloatArray:
    """Return the centroids of triangles, shape (m, 3), model units."""
    return np.asarray(vertices[triangles].mean(axis=1), dtype=np.float64).reshape(-1, 3)


@remembered
def centroids_of(surface: Surface) -> FloatArray:
    """Return the centroids of a surface's triangles, shape (m, 3), model units."""
    return floats(centroids(surface.vertices, surface.triangles))


def with_three_corners(surface: Surface) -> IntArray:
    """Return the indices of the triangles whose three vertex indices differ, shape (k,)."""
    t = surface.triangles
    return np.flatnonzero((t[:, 0] != t[:, 1]) & (t[:, 1] != t[:, 2]) & (t[:, 2] != t[:, 0]))


def components(count: int, pairs: IntArray) -> IntArray:
    """Return the connected component of each of ``count`` items joined by ``pairs`` (p, 2)."""
    links = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    return np.asarray(connected_components(links, directed=False)[1], dtype=np.int64)


def part_at(kind: str, count: int, place: FloatArray, value: float | None = None, unit: str = "") -> Part:
    """Return a part of a finding with its place given as an array, shape (3,)."""
    x, y, z = (float(c) for c in place)
    return Part(kind, count, (x, y, z), value, unit)


def inner_points(points: FloatArray, group: IntArray) -> FloatArray:
    """Return for each group of points the one nearest to their middle, shape (g, 3).

    ``points`` has shape (p, 3), ``group`` (p,) numbers the groups from 0, none of them empty.
    """
    size = np.bincount(group)
    middle = np.stack([np.bincount(group, points[:, k]) / size for k in range(3)], axis=1)
    order = np.lexsort((np.linalg.norm(points - middle[group], axis=1), group))
    return np.asarray(points[order[np.cumsum(size) - size]])


def largest_parts(
    kind: str, sizes: FloatArray, counts: IntArray, places: FloatArray, unit: str
) -> tuple[Part, ...]:
    """Return parts of one kind, the largest first, the smaller ones of many in one part.

    Parameters
    ----------
    kind : str
        What each is.
    sizes, counts : (g,) arrays
        Their sizes in ``unit``, and how many elements each has.
    places : (g, 3) array
        A place in each.
    """
    order = np.argsort(-sizes, kind="stable")
    alone, rest = order[:MOST_PARTS], order[MOST_PARTS:]
    parts = [part_at(kind, int(counts[k]), places[k], float(sizes[k]), unit) for k in alone]
    if len(rest):
        total = float(sizes[rest].sum())
        parts.append(
            part_at(f"{kind}, {len(rest)} smaller", int(counts[rest].sum()), places[rest[0]], total, unit)
        )
    return tuple(parts)


def amount(value: float, unit: str = "") -> str:
    """Return a number with three digits and its unit, without an exponent where it can be read without.

    >>> amount(31168.6, "m"), amount(0.81223, "m"), amount(2.0), amount(881400.0, "m²")
    ('31200 m', '0.812 m', '2', '0.881 km²')
    """
    if unit == "m²" and abs(value) >= _KM2:
        value, unit = value / 1e6, "km²"
    return f"{float(f'{value:.3g}'):.12g} {unit}".rstrip()


def percent(part: float, whole: float) -> str:
    """Return a share in percent with two digits, as in ``3.4 %``; 0 where the whole is 0."""
    share = 100.0 * part / whole if whole > 0 else 0.0
    return f"{share:.0f} %" if share >= 10 else f"{share:.2g} %"
