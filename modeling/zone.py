"""The nodes of the modeling zone: a hexagonal lattice inside, a ring of fixed nodes at its rim.

The input's own nodes would make the zone end anywhere between gamma and gamma plus a step, as the grid
happens to lie, and the error of an extrapolation grows with the square of its width. The ring makes gamma
mean gamma, whatever the grid's direction; the lattice makes the energy isotropic.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
import shapely
from scipy.spatial import cKDTree

from graben.arrays import BoolArray, FloatArray, IntArray
from graben.beside import beside
from graben.cutgraph import CutGraph
from graben.modeling.distance import distances, outside
from graben.proximity import Simplices
from graben.surface import Surface

#: Least distance between nodes of different origin, in steps.
CLEARANCE = 0.6
#: The ring stands outside gamma by this share of it, more than its chords cut into it.
_OUTSIDE = 1e-3
_QUADRANT_SEGMENTS = 64
#: Edges of the cut from which on the area around it is made on a second core.
_WORTH = 2000
#: Points off the horizon by less than this many steps lie on it.
_ON = 1e-6
#: Input nodes that a quadratic surface is fitted to for each node of the ring.
_NEIGHBOURS = 14
#: A fit whose shares add up to more than this in magnitude multiplies the errors of its nodes; on a straight
#: rim they add up to 3 or 4, in corners to 8.
_MOST_GAIN = 10.0
#: To this the shares of a fit give back the terms of a quadratic.
_EXACT = 1e-6


@dataclass(frozen=True, eq=False)
class Zone:
    """Nodes of the modeling zone, x, y and elevation of the input horizon.

    ``inner`` (k, 3) lie within gamma of a cut, ``ring`` (r, 3) just outside; ``beyond`` (n,) marks the
    input's nodes that lie clear outside the ring.
    """

    inner: FloatArray
    ring: FloatArray
    beyond: BoolArray


def zone_of(
    horizon: Surface,
    faces: IntArray,
    graph: CutGraph,
    step: float,
    gammas: FloatArray,
    plan: Simplices | None = None,
) -> Zone:
    """Return the nodes of the modeling zone of a horizon.

    Parameters
    ----------
    horizon : Surface
        The input.
    faces : (m, 3) array
        Its triangles that make way for new ones.
    graph : CutGraph
        The cut graph, with at least one edge.
    step : float
        Model units.
    gammas : (f,) array
        gamma of each fault in ``np.unique(graph.faults)``, model units.
    plan : Simplices, optional
        The triangles ``faces`` in plan, if they are at hand.
    """
    plan = plan or Simplices(horizon.vertices[:, :2], faces)
    side = step * float(np.sqrt(2 / np.sqrt(3)))
    # A zone wider than the horizon is the horizon; without this bound its lattice could have any size.
    gammas = np.minimum(gammas, np.linalg.norm(np.ptp(horizon.vertices[:, :2], axis=0)))
    outline = partial(_ring, graph, gammas * (1 + _OUTSIDE), side)
    later = beside(outline) if len(graph.edges) > _WORTH else outline
    inner = _lattice(graph, side, gammas.max())
    inside = outside(inner, graph, gammas) < -CLEARANCE * step
    inner = inner[inside]
    inner = inner[distances(inner, graph)[0] > CLEARANCE * step]
    away = outside(horizon.vertices[:, :2], graph, gammas, CLEARANCE * step)
    inner_z, inner_in = _linear(horizon, faces, plan, inner, step)
    ring = later()
    ring_z, ring_in = _linear(horizon, faces, plan, ring, step)
    ring, ring_z = ring[ring_in], ring_z[ring_in]
    reliable = horizon.vertices[away >= 0]
    if len(ring) and len(reliable) >= _NEIGHBOURS:
        ring_z = _quadratic(reliable, ring, ring_z, graph)
    return Zone(
        np.column_stack([inner, inner_z])[inner_in],
        np.column_stack([ring, ring_z]),
        away > CLEARANCE * step,
    )


def _ring(graph: CutGraph, gammas: FloatArray, side: float) -> FloatArray:
    """Return points at about ``side`` on the outlines of the area within gamma of the cuts, (r, 2)."""
    return _on_rings(_within(graph, gammas), side)


def _within(graph: CutGraph, gammas: FloatArray) -> shapely.Geometry:
    """Return the area within gamma of the cut of each fault."""
    lines = shapely.linestrings(graph.nodes[graph.edges][:, :, :2])
    parts = [
        shapely.buffer(shapely.union_all(lines[graph.faults == f]), gamma, quad_segs=_QUADRANT_SEGMENTS)
        for f, gamma in zip(np.unique(graph.faults), gammas, strict=True)
    ]
    return shapely.union_all(parts)


def _on_rings(area: shapely.Geometry, side: float) -> FloatArray:
    """Return points on the outlines of an area at about ``side``, shape (r, 2)."""
    found = [np.zeros((0, 2))]
    for part in shapely.get_parts(shapely.get_parts(area.boundary)):
        count = max(3, round(part.length / side))
        found.append(
            shapely.get_coordinates(
                shapely.line_interpolate_point(part, np.arange(count) * part.length / count)
            )
        )
    return np.concatenate(found)


def _lattice(graph: CutGraph, side: float, gamma: float) -> FloatArray:
    """Return a hexagonal lattice over the zone, (k, 2), along the cut's mean direction from its centre."""
    ends = graph.nodes[graph.edges][:, :, :2]
    way = ends[:, 1] - ends[:, 0]
    length = np.hypot(*way.T)
    double = 2 * np.arctan2(way[:, 1], way[:, 0])
    angle = 0.5 * float(np.arctan2((length * np.sin(double)).sum(), (length * np.cos(double)).sum()))
    centre = (ends.mean(axis=1) * length[:, None]).sum(axis=0) / length.sum()
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    place = (graph.nodes[:, :2] - centre) @ turn.T
    rise = side * np.sqrt(3) / 2
    low = np.floor((place.min(axis=0) - gamma) / (side, rise)) - 1
    high = np.ceil((place.max(axis=0) + gamma) / (side, rise)) + 1
    i, j = np.meshgrid(np.arange(low[0], high[0] + 1), np.arange(low[1], high[1] + 1), indexing="ij")
    local = np.stack([(i + 0.5 * (j % 2)) * side, (j + 0.5) * rise], axis=-1)
    return np.asarray(local.reshape(-1, 2) @ turn + centre)


def _linear(
    horizon: Surface, faces: IntArray, plan: Simplices, points: FloatArray, step: float
) -> tuple[FloatArray, BoolArray]:
    """Return the elevation of the input at plan points, (k,), and whether they lie on it."""
    near = plan.nearest(points)
    a, b, c = (horizon.vertices[faces[near.simplex, k]] for k in range(3))
    first, second, rel = b - a, c - a, points - a[:, :2]
    det = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    s = (rel[:, 0] * second[:, 1] - rel[:, 1] * second[:, 0]) / det
    t = (first[:, 0] * rel[:, 1] - first[:, 1] * rel[:, 0]) / det
    return a[:, 2] + s * first[:, 2] + t * second[:, 2], near.distance <= _ON * step


def _quadratic(nodes: FloatArray, points: FloatArray, linear: FloatArray, graph: CutGraph) -> FloatArray:
    """Return the elevation at plan points, (k,), of quadratic surfaces through reliable nodes (n, 3).

    Linear interpolation, ``linear`` (k,), would bend the slope that the energy sees at the rim of the zone.
    It stays where the nodes on a point's own side of the cut determine no quadratic: in a corridor between
    two faults that is no wider than a row of nodes.
    """
    away, near = cKDTree(nodes[:, :2]).query(points, k=_NEIGHBOURS)
    scale = away[:, -1:]
    x, y = np.moveaxis((nodes[near, :2] - points[:, None]) / scale[:, :, None], -1, 0)
    weight = np.exp(-2 * (x**2 + y**2)) * _same_side(nodes, points, near, away, graph)
    basis = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=-1)
    share = np.linalg.pinv(basis * weight[:, :, None])[:, 0] * weight
    # Of a quadratic that is determined the shares give back every term of it: 1, and 0 for the others.
    off = np.abs((share[:, :, None] * basis).sum(axis=1) - np.eye(1, basis.shape[2])).max(axis=1)
    sound = (off <= _EXACT) & (np.abs(share).sum(axis=1) <= _MOST_GAIN)
    return np.where(sound, (share * nodes[near, 2]).sum(axis=1), linear)


def _same_side(
    nodes: FloatArray, points: FloatArray, near: IntArray, away: FloatArray, graph: CutGraph
) -> BoolArray:
    """Return which nodes ``near`` (k, m), so far ``away``, no cut parts from their points: (k, m).

    The disc around either of the two that reaches to the cut is free of cuts: the other lies in it.
    """
    used, index = np.unique(near, return_inverse=True)
    room = distances(nodes[used], graph)[0][index.reshape(near.shape)]
    return np.asarray(away < np.maximum(room, distances(points, graph)[0][:, None]), dtype=bool)
