"""The cut graph resampled to about the step of its horizon (paper Sect. 3.3)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from graben.arrays import FloatArray, IntArray
from graben.cutgraph import CutGraph, DroppedTrace, NodeKind
from graben.surface import chained

#: Cosine of the turn in plan above which a resampled node is left out: 60 degrees.
_KINK = 0.5


@dataclass(frozen=True, eq=False)
class Trace:
    """The exact intersection of a horizon with the faults, before resampling.

    ``edges`` (e, 2) index ``points`` (n, 3); ``faults`` (e,) is the fault of each edge; an edge that lies
    on two faults stands twice. ``outer`` (n,) marks points on the boundary of the horizon, ``rim`` (e, 2)
    ends that lie on the boundary of the edge's fault.
    """

    points: FloatArray
    edges: IntArray
    faults: IntArray
    outer: IntArray
    rim: IntArray


def node_kinds(count: int, edges: IntArray, faults: IntArray, outer: IntArray, rim: IntArray) -> IntArray:
    """Return the :class:`NodeKind` of each node from the faults that meet in it.

    A node of degree 2 on one fault is interior; faults that meet make a junction; an end is an exit on
    the outer boundary, a tip on the rim of its fault, and otherwise loose.
    """
    degree = np.bincount(edges.ravel(), minlength=count)
    first = np.full(count, np.iinfo(np.int64).max)
    last = np.full(count, -1)
    np.minimum.at(first, edges.ravel(), np.repeat(faults, 2))
    np.maximum.at(last, edges.ravel(), np.repeat(faults, 2))
    on_rim = np.zeros(count, dtype=bool)
    on_rim[edges[rim == 1]] = True
    kinds = np.full(count, int(NodeKind.INTERIOR))
    # A node that a dropped piece left without edges is none.
    kinds[((first != last) & (degree > 0)) | (degree > 2)] = NodeKind.JUNCTION
    end = degree == 1
    kinds[end] = np.where(on_rim[end], int(NodeKind.TIP), int(NodeKind.LOOSE))
    kinds[(outer == 1) & (degree > 0)] = NodeKind.EXIT
    return np.asarray(kinds, dtype=np.int64)


def resampled(
    horizon: str,
    trace: Trace,
    step: float,
    directions: Sequence[FloatArray],
    dropped: tuple[DroppedTrace, ...],
) -> CutGraph:
    """Return the cut graph with nodes at about ``step`` along each chain.

    Tips, junctions, exits and loose ends stay where they are; the nodes between lie on the exact
    polyline, so on the horizon and on the fault. Each chain is directed so that its fault dips to the
    right of the way.

    Parameters
    ----------
    horizon : str
        Name of the horizon.
    trace : Trace
        The exact intersection.
    step : float
        Model units.
    directions : sequence of (2,) arrays
        Mean plan dip direction of each fault.
    dropped : tuple of DroppedTrace
        What was left out before, carried through.
    """
    count = len(trace.points)
    kinds = node_kinds(count, trace.edges, trace.faults, trace.outer, trace.rim)
    points: list[FloatArray] = []
    edges: list[IntArray] = []
    faults: list[IntArray] = []
    held = np.flatnonzero(kinds != NodeKind.INTERIOR)
    index = np.full(count, -1)
    index[held] = np.arange(len(held))
    points.append(trace.points[held])
    out_kinds = [kinds[held]]
    size = len(held)
    for fault in np.unique(trace.faults):
        mine = trace.edges[trace.faults == fault]
        for chain in _split(_dip_right(chained(mine), trace.points, directions[fault]), kinds):
            line = trace.points[chain]
            closed = bool(chain[0] == chain[-1])
            ring = closed and index[chain[0]] < 0
            line = _from_corner(line) if ring else line
            inner = _points_between(line, step, ring, 3 if closed else 1)
            if not closed:
                inner = _unkinked(line[0], inner, line[-1])
            nodes = np.arange(size, size + len(inner))
            size += len(inner)
            points.append(inner)
            out_kinds.append(np.full(len(inner), int(NodeKind.INTERIOR)))
            path = (
                np.append(nodes, nodes[0])
                if ring
                else np.concatenate([[index[chain[0]]], nodes, [index[chain[-1]]]])
            )
            edges.append(np.stack([path[:-1], path[1:]], axis=1))
            faults.append(np.full(len(path) - 1, fault))
    return CutGraph(
        horizon,
        np.concatenate(points),
        np.concatenate(out_kinds),
        np.concatenate(edges) if edges else np.zeros((0, 2), dtype=np.int64),
        np.concatenate(faults) if faults else np.zeros(0, dtype=np.int64),
        dropped,
    )


def _split(chains: list[IntArray], kinds: IntArray) -> list[IntArray]:
    """Split chains at nodes that are not interior; a closed chain then starts at such a node."""
    parts: list[IntArray] = []
    for whole in chains:
        held = np.flatnonzero(kinds[whole] != NodeKind.INTERIOR)
        closed = whole[0] == whole[-1] and len(held) > 0
        chain = np.append(np.roll(whole[:-1], -held[0]), whole[held[0]]) if closed else whole
        at = [k for k in range(1, len(chain) - 1) if kinds[chain[k]] != NodeKind.INTERIOR]
        for a, b in zip([0, *at], [*at, len(chain) - 1], strict=True):
            parts.append(chain[a : b + 1])
    return parts


def _dip_right(chains: list[IntArray], points: FloatArray, direction: FloatArray) -> list[IntArray]:
    """Return chains turned so that ``direction``, (2,), lies to the right of the way from end to end.

    A closed chain has no such way: it is turned counter-clockwise, the outside to its right.
    """
    turned = []
    for chain in chains:
        x, y = points[chain, :2].T
        right = (y[-1] - y[0]) * direction[0] - (x[-1] - x[0]) * direction[1]
        if chain[0] == chain[-1]:
            right = ((x[:-1] - x[0]) * np.diff(y) - (y[:-1] - y[0]) * np.diff(x)).sum()
        turned.append(chain[::-1] if right < 0 else chain)
    return turned


def _from_corner(ring: FloatArray) -> FloatArray:
    """Return a closed polyline (k, 3) that starts where it turns most in plan, whatever its first point was.

    A ring without a junction has no node of its own to start from; its sharpest corner it should keep.
    """
    way = np.diff(ring[:, :2], axis=0)
    way /= np.maximum(np.hypot(*way.T), np.finfo(float).tiny)[:, None]
    start = int(np.argmin((way * np.roll(way, 1, axis=0)).sum(axis=1)))
    return np.concatenate([ring[start:-1], ring[: start + 1]])


def _points_between(line: FloatArray, step: float, ring: bool, least: int) -> FloatArray:
    """Return the points inside a polyline (of a ring: all) at equal shares of its plan length, (k, 3).

    The shares are of about ``step``, model units, and at least ``least`` in number.
    """
    way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line[:, :2], axis=0).T))])
    parts = max(round(way[-1] / step), least)
    at = np.linspace(0.0, way[-1], parts + 1)[(0 if ring else 1) : -1]
    return np.stack([np.interp(at, way, line[:, k]) for k in range(3)], axis=1)


def _unkinked(start: FloatArray, inner: FloatArray, end: FloatArray) -> FloatArray:
    """Return the inner points (k, 3) of a line without those at which it turns back in plan, sharpest first.

    Where a smeared horizon runs nearly along its fault, their intersection wanders to and fro; a lip that
    started from such a line would fold when it moves.
    """
    points = np.concatenate([start[None], inner, end[None]])
    while len(points) > 3:
        way = np.diff(points[:, :2], axis=0)
        way /= np.maximum(np.hypot(*way.T), np.finfo(float).tiny)[:, None]
        bend = (way[1:] * way[:-1]).sum(axis=1)
        sharpest = int(np.argmin(bend))
        if bend[sharpest] > _KINK:
            break
        points = np.delete(points, sharpest + 1, axis=0)
    return points[1:-1]
