"""Holes of a horizon in plan: places that its outer boundary encloses and that it does not cover."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from scipy.spatial import cKDTree

from graben.arrays import BoolArray, FloatArray, IntArray
from graben.cutgraph import CutGraph
from graben.model import Horizon
from graben.proximity import nearest

#: Width over the step below which a hole is a crack between vertices that were meant to be one.
_CRACK = 1e-3
#: A point off the surface by more than this share of the step is not covered by it.
_OFF = 1e-6
#: How much further than the nearest of a hole's rim the places may lie that count as nearest, in steps.
_NEAREST = 0.02
#: Length over which a trace runs over a filled hole, in steps; one that ends at the rim only cuts a corner.
_OVER = 0.5


@dataclass(frozen=True, eq=False)
class Hole:
    """A hole.

    Parameters
    ----------
    area : shapely.Polygon
        In plan, model units.
    rim : (k, 3) array
        Nodes of the horizon around it.
    nodes : int
        Number of the undefined grid nodes in it; 0 for a horizon that is no grid.
    width : float
        Least distance between two parallel lines with the hole between them, model units.
    filled : bool
        Whether it is filled before the horizon is traced.
    """

    area: shapely.Polygon
    rim: FloatArray
    nodes: int
    width: float
    filled: bool

    def place(self, trace: shapely.Geometry, step: float) -> FloatArray:
        """Return the middle of what of the hole is nearest to a trace, (3,), at the elevation of the rim.

        A trace that meets the hole at two places, or runs over it, gives a place between them inside.
        """
        near = shapely.intersection(trace, self.area)
        if shapely.length(near) <= _OVER * step:
            reach = shapely.distance(self.area, trace) + _NEAREST * step
            near = shapely.intersection(shapely.buffer(trace, reach), self.area)
        plan = shapely.get_coordinates(shapely.centroid(near))[0]
        weight = 1.0 / np.maximum(((self.rim[:, :2] - plan) ** 2).sum(axis=1), (_OFF * step) ** 2)
        return np.array([*plan, weight @ self.rim[:, 2] / weight.sum()])


def distances(holes: Sequence[Hole], trace: shapely.Geometry) -> FloatArray:
    """Return the plan distance of holes to a trace, (h,), model units; 0 where it meets a hole."""
    return np.asarray(shapely.distance([hole.area for hole in holes], trace), dtype=np.float64)


def traced(graph: CutGraph, faults: Sequence[int]) -> shapely.MultiLineString:
    """Return the traces of some faults in plan."""
    mine = np.isin(graph.faults, faults)
    return shapely.multilinestrings(shapely.linestrings(graph.nodes[graph.edges[mine]][:, :, :2]))


def holes_of(horizon: Horizon, graph: CutGraph) -> tuple[Hole, ...]:
    """Return the holes of a horizon, a bay of its outer boundary not among them.

    The boundary edges are noded and joined to faces; those that the surface does not cover are holes. An
    undefined node is one, as wide as the triangles that it leaves out.

    Parameters
    ----------
    horizon : Horizon
        As given, its holes not filled.
    graph : CutGraph
        Its cut graph, which knows what was filled.
    """
    surface, step = horizon.surface, horizon.step
    ends = surface.vertices[surface.rim]
    if not len(ends):
        return ()
    faces = shapely.get_parts(shapely.polygonize([shapely.union_all(shapely.linestrings(ends[:, :, :2]))]))
    faces = faces[2.0 * shapely.area(faces) > _CRACK * step * shapely.length(faces)]
    if len(faces) < 2:  # the surface itself
        return ()
    inside = shapely.get_coordinates(shapely.point_on_surface(faces))
    faces = faces[nearest(inside, surface.vertices, surface.triangles).distance > _OFF * step]
    corners = np.unique(ends.reshape(-1, 3), axis=0)
    tree = cKDTree(corners[:, :2])
    found = []
    for face, nodes, filled in zip(faces, _undefined(horizon, faces), _filled(faces, graph), strict=True):
        rim = corners[np.unique(tree.query(shapely.get_coordinates(face))[1])]
        found.append(Hole(face, rim, int(nodes), _width(face), bool(filled)))
    return tuple(found)


def _undefined(horizon: Horizon, areas: Sequence[shapely.Polygon]) -> IntArray:
    """Return how many nodes of a horizon's own grid lie inside each of some areas that it does not cover."""
    if horizon.grid is None or len(horizon.picks) or not len(areas):
        return np.zeros(len(areas), dtype=np.int64)
    nodes = shapely.points(horizon.grid.nodes().reshape(-1, 2))
    inner = shapely.buffer(areas, -_OFF * horizon.step)
    within = shapely.STRtree(inner).query(nodes, predicate="within")[1]
    return np.bincount(within, minlength=len(areas))


def _filled(areas: Sequence[shapely.Polygon], graph: CutGraph) -> BoolArray:
    """Return which areas got nodes before the traces were drawn, (h,)."""
    filled = np.zeros(len(areas), dtype=bool)
    filled[shapely.STRtree(areas).query(shapely.points(graph.filled[:, :2]), predicate="within")[1]] = True
    return filled


def _width(face: shapely.Polygon) -> float:
    """Return the least width of a face, model units: that across one of the sides of its convex hull."""
    ring = shapely.get_coordinates(shapely.convex_hull(face))
    way = np.diff(ring, axis=0)
    way /= np.linalg.norm(way, axis=1)[:, None]
    across = np.stack([-way[:, 1], way[:, 0]], axis=1)
    off = ((ring[None] - ring[:-1, None]) * across[:, None]).sum(axis=2)
    return float(np.abs(off).max(axis=1).min())
