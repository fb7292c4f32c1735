"""Measures of the trace of a fault: ends that lie where none may, and pieces with the gaps between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import combinations
from typing import Any

import numpy as np
import shapely

from graben.arrays import BoolArray, FloatArray, IntArray, floats, ints
from graben.cutgraph import CutGraph, NodeKind
from graben.finding import Part
from graben.model import Horizon
from graben.proximity import nearest
from graben.surface import Surface, chained, triangle_normals
from graben.validators.measuring.measures import components

#: An end lies on the boundary of a horizon within this many steps of it, as the cut graph has it.
ON_BOUNDARY = 1e-3
#: A place lies behind an end where the way to it turns back from that of the trace by more than this cosine:
#: 107 degrees, so that no place straight to the side is in doubt.
BEHIND = -0.3


class Goal(Enum):
    """Where a trace may end."""

    RIM = "the rim of "  #: of its own fault
    BOUNDARY = "the outer boundary of "  #: of the horizon
    FAULT = ""  #: another fault


@dataclass(frozen=True)
class LooseEnd:
    """An end of a trace that lies where none may.

    Parameters
    ----------
    node : int
        Its node in the cut graph.
    at_hole : bool
        Whether it lies at a hole of the horizon; else within the horizon.
    distance : float
        To the nearest place where it might end, model units.
    goal : Goal
        What that place is.
    name : str
        The surface on which it is.
    """

    node: int
    at_hole: bool
    distance: float
    goal: Goal
    name: str


@dataclass(frozen=True, eq=False)
class Piece:
    """A connected piece of a trace: its edges of the cut graph, plan length, middle (3,) and lines."""

    edges: IntArray
    length: float
    middle: FloatArray
    paths: tuple[FloatArray, ...]

    def part(self, kind: str, unit: str) -> Part:
        """Return it as a part of a finding."""
        x, y, z = (float(c) for c in self.middle)
        return Part(kind, 1, (x, y, z), self.length, unit)


@dataclass(frozen=True, eq=False)
class Gap:
    """The gap between two pieces of a trace: its plan width, and where the shorter piece begins (3,)."""

    width: float
    place: FloatArray


def outline(horizon: Surface) -> list[Any]:
    """Return the parts of a horizon in plan as polygons with holes, from its boundary edges.

    Parameters
    ----------
    horizon : Surface
        A function of x and y.
    """
    edges = horizon.vertices[horizon.rim][:, :, :2]
    area = shapely.build_area(shapely.multilinestrings(shapely.linestrings(edges)))
    return [part for part in shapely.get_parts(area) if not part.is_empty]


def above(points: FloatArray, horizon: Surface) -> FloatArray:
    """Return how far points (n, 3) lie above a horizon, a function of x and y, shape (n,), model units."""
    near = nearest(points[:, :2], horizon.vertices, horizon.triangles)
    normal = triangle_normals(horizon.vertices, horizon.triangles[near.simplex])
    away = points - horizon.vertices[horizon.triangles[near.simplex, 0]]
    up = np.where(normal[:, 2] == 0.0, np.finfo(float).tiny, normal[:, 2])
    return np.asarray((normal * away).sum(axis=1) / up, dtype=np.float64)


def loose_ends(
    horizon: Horizon, graph: CutGraph, fault: int, faults: Sequence[Surface], parts: Sequence[Any]
) -> list[LooseEnd]:
    """Return the ends of the trace of a fault that lie on no legal place.

    Legal are the rim of the fault, another fault, and the outer boundary of the horizon; the rim of a hole
    in the horizon is not.

    Parameters
    ----------
    horizon : Horizon
        The horizon.
    graph : CutGraph
        Its cut graph.
    fault : int
        Index of the fault.
    faults : sequence of Surface
        All faults of the model.
    parts : sequence of shapely.Polygon
        The :func:`outline` of the horizon.
    """
    nodes = np.unique(graph.edges[graph.faults == fault])
    exits = nodes[graph.kinds[nodes] == NodeKind.EXIT]
    at_hole = exits[_at_hole(graph.nodes[exits], parts, ON_BOUNDARY * horizon.step)]
    ends = ints(np.concatenate([nodes[graph.kinds[nodes] == NodeKind.LOOSE], at_hole]))
    if not len(ends):
        return []
    others = [f for k, f in enumerate(faults) if k != fault]
    points, ahead = graph.nodes[ends], _ways(graph, fault, ends)
    places = [_on_rim(points, ahead, faults[fault], horizon.surface), _on_outer(points, ahead, parts)]
    places += [nearest(points, other.vertices, other.triangles).place for other in others]
    goals = [(Goal.RIM, faults[fault].name), (Goal.BOUNDARY, horizon.name)]
    goals += [(Goal.FAULT, other.name) for other in others]
    ways = np.stack(places) - points
    away = np.nan_to_num(np.linalg.norm(ways, axis=2), nan=np.inf)
    forward = _forward(ways, ahead)
    # What lies behind an end its trace has passed, unless nothing lies ahead.
    best = np.argmin(np.where(forward | ~forward.any(axis=0), away, np.inf), axis=0)
    found = [
        LooseEnd(int(node), bool(np.isin(node, at_hole)), float(away[k, n]), *goals[k])
        for n, (node, k) in enumerate(zip(ends, best, strict=True))
    ]
    return [end for end in found if end.distance > ON_BOUNDARY * horizon.step]


def _ways(graph: CutGraph, fault: int, ends: IntArray) -> FloatArray:
    """Return the plan directions in which the trace of a fault reaches its ends, unit vectors (n, 2)."""
    edges = graph.edges[graph.faults == fault]
    both = np.concatenate([edges, edges[:, ::-1]])
    order = np.argsort(both[:, 0], kind="stable")
    before = both[order[np.searchsorted(both[order, 0], ends)], 1]
    way = graph.nodes[ends, :2] - graph.nodes[before, :2]
    return np.asarray(way / np.linalg.norm(way, axis=1)[:, None], dtype=np.float64)


def _forward(ways: FloatArray, ahead: FloatArray) -> BoolArray:
    """Return which ways (..., 3) do not lead back in plan from the directions ``ahead`` (..., 2)."""
    onward = (ways[..., :2] * ahead).sum(axis=-1)
    return np.asarray(onward > BEHIND * np.linalg.norm(ways, axis=-1), dtype=bool)


def _at_hole(points: FloatArray, parts: Sequence[Any], reach: float) -> BoolArray:
    """Return which points (n, 3) lie on the rim of a hole and not on an outer boundary."""
    holes = [ring for part in parts for ring in part.interiors]
    if not holes:
        return np.zeros(len(points), dtype=bool)
    places = shapely.points(points[:, :2])
    inner = shapely.distance(places, shapely.multilinestrings(holes)) <= reach
    outer = shapely.distance(places, shapely.multilinestrings([part.exterior for part in parts])) <= reach
    return np.asarray(inner & ~outer, dtype=bool)


def _on_outer(points: FloatArray, ahead: FloatArray, parts: Sequence[Any]) -> FloatArray:
    """Return the nearest places ahead of points (n, 3) on the outer boundary of a horizon; NaN where none is.

    They are given at the elevation of their point: what counts is the way in plan.
    """
    outer = shapely.multilinestrings([part.exterior for part in parts])
    far = 2.0 * float(np.hypot(*np.ptp(shapely.get_coordinates(outer), axis=0)))
    turn = np.arccos(BEHIND) * np.linspace(-1.0, 1.0, 5)
    angles = np.arctan2(ahead[:, 1], ahead[:, 0])[:, None] + turn
    fans = points[:, None, :2] + far * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    found = np.full((len(points), 3), np.nan)
    for n, fan in enumerate(fans):
        seen = shapely.intersection(outer, shapely.Polygon([points[n, :2], *fan]))
        if not seen.is_empty:
            across = shapely.get_coordinates(shapely.shortest_line(shapely.Point(points[n, :2]), seen))
            found[n] = [*across[1], points[n, 2]]
    return found


def _on_rim(points: FloatArray, ahead: FloatArray, fault: Surface, horizon: Surface) -> FloatArray:
    """Return the nearest places ahead of points (n, 3) on the rim of a fault where the horizon could meet it.

    That is where the rim passes through the plane that has the mean slope of the horizon and runs through
    the point; NaN where it does not.
    """
    centred = horizon.vertices - horizon.vertices.mean(axis=0)
    slope = np.linalg.lstsq(centred[:, :2], centred[:, 2], rcond=None)[0]
    a, b = (fault.vertices[fault.rim[:, k]] for k in (0, 1))
    height_a, height_b = (end[:, 2] - end[:, :2] @ slope for end in (a, b))
    level = (points[:, 2] - points[:, :2] @ slope)[:, None]
    through = (height_a <= level) != (height_b <= level)
    rise = np.where(height_b == height_a, 1.0, height_b - height_a)
    met = a + ((level - height_a) / rise)[:, :, None] * (b - a)
    way = met - points[:, None]
    through &= _forward(way, ahead[:, None])
    away = np.where(through, np.linalg.norm(way, axis=2), np.inf)
    found = np.full((len(points), 3), np.nan)
    if len(a):
        some = through.any(axis=1)
        found[some] = met[some, np.argmin(away[some], axis=1)]
    return found


def pieces_of(graph: CutGraph, fault: int) -> list[Piece]:
    """Return the connected pieces of the trace of a fault, the longest first."""
    return pieces(graph, np.flatnonzero(graph.faults == fault))


def pieces(graph: CutGraph, edges: IntArray) -> list[Piece]:
    """Return the connected pieces of some edges of a cut graph, given by index, the longest first."""
    if not len(edges):
        return []
    nodes, local = np.unique(graph.edges[edges], return_inverse=True)
    local = local.reshape(-1, 2)
    labels = components(len(nodes), local)[local[:, 0]]
    found = [_piece(graph, edges[labels == k]) for k in range(int(labels.max()) + 1)]
    return sorted(found, key=lambda piece: -piece.length)


def _piece(graph: CutGraph, edges: IntArray) -> Piece:
    """Return one piece; its middle is that of its longest part without a branch."""
    paths = tuple(floats(graph.nodes[chain]) for chain in chained(graph.edges[edges]))
    ways = [np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path[:, :2], axis=0).T))]) for path in paths]
    longest = int(np.argmax([way[-1] for way in ways]))
    path, way = paths[longest], ways[longest]
    middle = floats([np.interp(way[-1] / 2.0, way, path[:, k]) for k in range(3)])
    return Piece(ints(edges), float(sum(way[-1] for way in ways)), middle, paths)


def gaps_between(pieces: Sequence[Piece]) -> list[Gap]:
    """Return the gaps that join pieces of a trace to their neighbours, one fewer than pieces.

    They are those of the shortest tree that joins all pieces, measured in plan, the narrowest first.
    """
    lines = [shapely.MultiLineString([path[:, :2] for path in piece.paths]) for piece in pieces]
    pairs = np.array(list(combinations(range(len(pieces)), 2)), dtype=np.int64).reshape(-1, 2)
    widths = np.array([lines[a].distance(lines[b]) for a, b in pairs])
    joined = np.arange(len(pieces))
    found = []
    for k in np.argsort(widths, kind="stable"):
        a, b = pairs[k]
        if joined[a] == joined[b]:
            continue
        joined[joined == joined[b]] = joined[a]
        # The pieces come longest first: the second is the shorter.
        x, y = shapely.get_coordinates(shapely.shortest_line(lines[a], lines[b]))[1]
        nodes = np.concatenate(pieces[b].paths)
        z = nodes[np.argmin((nodes[:, 0] - x) ** 2 + (nodes[:, 1] - y) ** 2), 2]
        found.append(Gap(float(widths[k]), floats([x, y, z])))
    return found
