"""Surfaces as far as they can be drawn, and how a fault looks face-on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from matplotlib.ticker import MaxNLocator

from graben.arrays import BoolArray, FloatArray, IntArray, bools, floats, ints
from graben.cutgraph import CutGraph
from graben.model import UNDEFINED
from graben.reports.map_parts import Window
from graben.reports.scene import thinned_surface
from graben.surface import Surface, boundary_edges, chained, edge_sharing, edge_table, mean_dip_direction

#: Turns points (..., 3) into places of a drawing (..., 2).
Projection = Callable[[FloatArray], FloatArray]

#: Drawings of a fault have about so many triangles at most.
_MOST_DRAWN = 4_000
#: A rim edge belongs to the upper rim where its outward normal, seen face-on, rises above this sine.
_UPWARDS = 0.7
#: Below this dip, degrees, a surface is looked at from above with north up.
_LEVEL = 1.0
_COMPASS = (
    "N",
    "NNE",
    "NE",
    "ENE",
    "E",
    "ESE",
    "SE",
    "SSE",
    "S",
    "SSW",
    "SW",
    "WSW",
    "W",
    "WNW",
    "NW",
    "NNW",
)


def drawable(points: FloatArray) -> BoolArray:
    """Return which points (..., 3) are finite and no marks for undefined, shape (...)."""
    with np.errstate(invalid="ignore"):
        return bools((np.abs(points) < UNDEFINED).all(axis=-1))


def usable(surface: Surface) -> Surface:
    """Return a surface without the triangles and vertices that cannot be drawn."""
    t, count = surface.triangles, len(surface.vertices)
    known = ((t >= 0) & (t < count)).all(axis=1)
    fit = drawable(surface.vertices)
    t = t[known]
    t = t[fit[t].all(axis=1)] if count else t[:0]
    used, inverse = np.unique(t, return_inverse=True)
    return Surface(surface.name, surface.vertices[used], inverse.reshape(-1, 3), file=surface.file)


def crossings(points: FloatArray, triangles: IntArray, values: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return where a function that is linear on each triangle vanishes.

    Parameters
    ----------
    points : (n, d) array
        Vertices.
    triangles : (m, 3) array
        Vertex indices.
    values : (n,) array
        The function at the vertices; a zero counts as positive.

    Returns
    -------
    segments : (k, 2, d) array
        Ends of each segment.
    triangles : (k,) array
        The triangle of each.

    >>> corners = floats([[0, 0], [2, 0], [0, 2]])
    >>> crossings(corners, ints([[0, 1, 2]]), corners[:, 0] - 1)[0].tolist()
    [[[1.0, 1.0], [1.0, 0.0]]]
    """
    off = np.where(values == 0.0, np.finfo(np.float64).tiny, values)
    cut = np.flatnonzero((off[triangles] > 0).any(axis=1) & (off[triangles] < 0).any(axis=1))
    t = triangles[cut]
    # The corner that lies alone on its side, then the other two: both edges from it are cut.
    positive = off[t] > 0
    alone = np.argmax(positive == (positive.sum(axis=1) == 1)[:, None], axis=1)
    rows = np.arange(len(t))
    ends = []
    for k in (1, 2):
        a, b = t[rows, alone], t[rows, (alone + k) % 3]
        share = (off[a] / (off[a] - off[b]))[:, None]
        ends.append(points[a] + share * (points[b] - points[a]))
    return floats(np.stack(ends, axis=1)), ints(cut)


def level_lines(surface: Surface, most: int) -> tuple[FloatArray, FloatArray]:
    """Return structure contours of a surface at about ``most`` round elevations.

    Returns
    -------
    segments : (k, 2, 3) array
        Ends of each segment.
    levels : (k,) array
        The elevation of each.
    """
    z = surface.vertices[:, 2]
    if not len(surface.triangles) or z.min() == z.max():
        return floats([], 0, 2, 3), floats([])
    ticks = MaxNLocator(most, steps=[1, 2, 2.5, 5, 10]).tick_values(float(z.min()), float(z.max()))
    parts = [crossings(surface.vertices, surface.triangles, z - level)[0] for level in ticks]
    return floats(np.concatenate(parts)), floats(np.repeat(ticks, [len(p) for p in parts]))


def compass(direction: FloatArray) -> str:
    """Return the name of a direction in plan.

    >>> compass(floats([1.0, 1.0]))
    'NE'
    """
    return _COMPASS[round(float(np.degrees(np.arctan2(direction[0], direction[1]))) / 22.5) % 16]


@dataclass(frozen=True, eq=False)
class FaceOn:
    """How a fault is seen square to its mean plane, from the side towards which it dips.

    Parameters
    ----------
    origin : (3,) array
        What stands at (0, 0), model units.
    along, up, towards : (3,) array
        Unit vectors: to the right along strike, up-dip, and out of the picture towards the viewer.
    """

    origin: FloatArray
    along: FloatArray
    up: FloatArray
    towards: FloatArray

    @classmethod
    def of(cls, surface: Surface) -> FaceOn:
        """Return the view of a surface whose least coordinates are zero; it has at least one triangle."""
        (dx, dy), dip = mean_dip_direction(surface.vertices, surface.triangles)
        if dip < _LEVEL:
            dx, dy = 0.0, -1.0
        s, c = np.sin(np.radians(dip)), np.cos(np.radians(dip))
        along, up = np.array([-dy, dx, 0.0]), np.array([-dx * c, -dy * c, s])
        middle = surface.vertices.mean(axis=0)
        way = surface.vertices - middle
        origin = middle + (way @ along).min() * along + (way @ up).min() * up
        return cls(floats(origin), floats(along), floats(up), floats(np.cross(along, up)))

    def __call__(self, points: FloatArray) -> FloatArray:
        """Return points (..., 3) as seen: distance along strike and up-dip, model units, shape (..., 2)."""
        way = points - self.origin
        return np.stack([way @ self.along, way @ self.up], axis=-1)

    def depth(self, points: FloatArray) -> FloatArray:
        """Return how near points (..., 3) are to the viewer, model units, shape (...)."""
        return np.asarray((points - self.origin) @ self.towards)


@dataclass(frozen=True, eq=False)
class Shape:
    """A fault or horizon prepared for drawings.

    Parameters
    ----------
    surface : Surface
        Usable triangles alone.
    original : Surface
        As it stands in the model: element indices number its triangles and vertices.
    """

    surface: Surface
    original: Surface

    @classmethod
    def of(cls, original: Surface) -> Shape:
        """Return the shape of a surface of the model."""
        return cls(usable(original), original)

    @cached_property
    def drawn(self) -> Surface:
        """The surface thinned for drawings."""
        share = _MOST_DRAWN / max(len(self.surface.triangles), 1)
        if share >= 1.0:
            return self.surface
        kept, triangles = thinned_surface(self.surface, share)
        return Surface(self.surface.name, self.surface.vertices[kept], triangles)

    @cached_property
    def face(self) -> FaceOn:
        """The view face-on; only where there are triangles."""
        return FaceOn.of(self.surface)

    @cached_property
    def median_edge(self) -> float:
        """Median length of its triangles' sides, model units."""
        return self.surface.median_edge

    @cached_property
    def rim(self) -> tuple[FloatArray, ...]:
        """The boundary: lines (k, 3)."""
        return self._lines(boundary_edges(self.surface.triangles))

    @cached_property
    def upper_rim(self) -> tuple[FloatArray, ...]:
        """The part of the boundary that is up-dip of the fault: lines (k, 3)."""
        t = self.surface.triangles
        edges, sides = edge_table(t)
        row, k = np.nonzero(edge_sharing(sides, len(edges))[sides] == 1)
        opposite, a, b = (t[row, (k + turn) % 3] for turn in range(3))
        seen = self.face(self.surface.vertices)
        way, inwards = seen[b] - seen[a], seen[opposite] - seen[a]
        normal = way[:, ::-1] * [-1.0, 1.0]
        outward = np.where((normal * inwards).sum(axis=1) > 0, -normal[:, 1], normal[:, 1])
        up = outward > _UPWARDS * np.hypot(way[:, 0], way[:, 1])
        return self._lines(ints(np.stack([a[up], b[up]], axis=1)))

    def _lines(self, edges: IntArray) -> tuple[FloatArray, ...]:
        return tuple(floats(self.surface.vertices[chain]) for chain in chained(edges))

    def within(self, project: Projection, window: Window) -> IntArray:
        """Return the triangles whose box meets a window of a drawing, shape (k, 3)."""
        t = self.surface.triangles
        corners = project(self.surface.vertices)[t]
        low, high = np.array([window[0], window[2]]), np.array([window[1], window[3]])
        return ints(t[((corners.max(axis=1) >= low) & (corners.min(axis=1) <= high)).all(axis=1)], -1, 3)


def trace_of(graph: CutGraph, fault: int) -> FloatArray:
    """Return the trace of a fault on a horizon: ends of its edges, shape (k, 2, 3)."""
    edges = graph.edges[graph.faults == fault]
    return floats(graph.nodes[edges], -1, 2, 3)
