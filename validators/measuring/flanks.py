"""The points of a horizon beside the trace of a fault, along it and across it, and planes through them.

Everything here is weighted smoothly: windows along the trace overlap, and what lies near another fault or
beyond an end of the trace fades out. So a point that a rotation puts on the other side of a limit changes
nothing.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from graben.arrays import FloatArray, IntArray, floats
from graben.cutgraph import CutGraph
from graben.model import Horizon
from graben.proximity import PlanIndex, nearest
from graben.surface import Surface, chained
from graben.validators.measuring.measures import remembered

#: Points that a plane is fitted to, at least.
_LEAST = 6
#: Spread of those points across their longest direction over that along it, at least.
_SPREAD = 0.05
#: Residuals above this many standard deviations lose weight, and how often the weights are renewed.
_CLIP = 1.5
_ROUNDS = 15
#: Mean square of normal deviates cut at 1.5 standard deviations.
_CLIPPED_VARIANCE = 0.7785


def ways(line: FloatArray) -> FloatArray:
    """Return the distance in plan of each point of a line (k, 3) from its first, along it, shape (k,)."""
    return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line[:, :2], axis=0).T))])


def at_way(line: FloatArray, way: float) -> FloatArray:
    """Return the point of a line (k, 3) at a distance in plan along it, shape (3,)."""
    along = ways(line)
    return np.array([np.interp(way, along, line[:, c]) for c in range(3)])


@dataclass(frozen=True, eq=False)
class Flanks:
    """Points beside the trace of a fault.

    Parameters
    ----------
    index : (n,) array
        Which points of the horizon they are.
    points : (n, 3) array
        Model units.
    along : (n,) array
        Distance in plan along the trace of the place nearest to each; pieces of a trace follow each other
        with wide gaps between them.
    across : (n,) array
        Plan distance to the trace, positive on the side towards which the fault dips.
    right : (n, 2) array
        Unit vector in plan across the trace there, towards that side.
    share : (n,) array
        What each counts: 1, and 0 within gamma of another fault's trace or a step beyond an end.
    pieces : (p, 2) array
        Where each piece of the trace begins, as ``along``, and its length.
    lines : tuple of (k, 3) arrays
        The pieces, directed so that the fault dips to the right of the way.
    """

    index: IntArray
    points: FloatArray
    along: FloatArray
    across: FloatArray
    right: FloatArray
    share: FloatArray
    pieces: FloatArray
    lines: tuple[FloatArray, ...]

    def piece(self, along: float) -> int:
        """Return the piece of the trace to which a distance along it belongs."""
        return int(np.clip(np.searchsorted(self.pieces[:, 0], along, side="right") - 1, 0, None))

    def place(self, along: float) -> FloatArray:
        """Return the point of the trace at a distance along it, shape (3,)."""
        k = self.piece(along)
        return at_way(self.lines[k], along - float(self.pieces[k, 0]))

    def stretch(self, first: float, last: float) -> FloatArray:
        """Return the line of the trace between two distances along one of its pieces, shape (k, 3)."""
        k = self.piece(first)
        at = self.pieces[k, 0] + ways(self.lines[k])
        inner = self.lines[k][(at > first) & (at < last)]
        return np.concatenate([self.place(first)[None], inner, self.place(last)[None]])


@dataclass(frozen=True, eq=False)
class Windows:
    """Overlapping windows on a trace: ``centres`` (w,) and half widths ``reach`` (w,), as ``along``."""

    centres: FloatArray
    reach: FloatArray

    @staticmethod
    def over(flanks: Flanks, spacing: float) -> Windows:
        """Return windows at about ``spacing``, model units, that together count each place once."""
        parts = np.maximum(np.round(flanks.pieces[:, 1] / spacing), 1).astype(np.int64)
        reach = np.repeat(flanks.pieces[:, 1] / parts, parts)
        number = np.concatenate([np.arange(n) for n in parts])
        return Windows(np.repeat(flanks.pieces[:, 0], parts) + (number + 0.5) * reach, reach)

    def __iter__(self) -> Iterator[tuple[float, float]]:
        return zip(self.centres.tolist(), self.reach.tolist(), strict=True)


def hat(along: FloatArray, centre: float, reach: float) -> FloatArray:
    """Return the weight of places in a window, shape (n,): 1 in its middle, 0 at its ends."""
    return np.clip(1.0 - np.abs(along - centre) / max(reach, np.finfo(float).tiny), 0.0, 1.0)


@remembered
def nodes_of(surface: Surface) -> PlanIndex:
    """Return the vertices of a surface, for :func:`flanks_of`."""
    return PlanIndex(surface.vertices)


@remembered
def picks_of(horizon: Horizon) -> PlanIndex:
    """Return the picks of a horizon, for :func:`flanks_of`."""
    return PlanIndex(horizon.picks)


def flanks_of(
    points: PlanIndex, graph: CutGraph, fault: int, gammas: Mapping[int, float], reach: float, step: float
) -> Flanks:
    """Return the points of a horizon within ``reach`` of the trace of a fault in plan.

    Parameters
    ----------
    points : PlanIndex
        Nodes or picks of the horizon, see :func:`nodes_of` and :func:`picks_of`.
    graph : CutGraph
        Of the horizon.
    fault : int
        Index of a fault that has edges in the graph.
    gammas : mapping
        gamma of each fault of the graph, model units.
    reach, step : float
        Model units.
    """
    edges, starts, pieces, lines = _pieces(graph, fault)
    chosen = points.within(*_box(graph.nodes[edges], reach))
    near = nearest(points.points[chosen, :2], graph.nodes, edges)
    close = near.distance < reach
    chosen, edge, foot = chosen[close], near.simplex[close], near.place[close]
    at = points.points[chosen]
    a, b = graph.nodes[edges[edge, 0], :2], graph.nodes[edges[edge, 1], :2]
    way = (b - a) / np.maximum(np.linalg.norm(b - a, axis=1), np.finfo(float).tiny)[:, None]
    right = np.stack([way[:, 1], -way[:, 0]], axis=1)
    off = at[:, :2] - foot
    side = np.where((off * right).sum(axis=1) > 0, 1.0, -1.0)
    beyond = np.abs((off * way).sum(axis=1)) * _at_an_end(foot, lines, step)
    share = np.clip(1.0 - beyond / step, 0.0, 1.0)
    least, most = _box(at, 0.0) if len(at) else (np.full(2, np.inf), np.full(2, -np.inf))
    for other in np.setdiff1d(graph.faults, [fault]):
        theirs = graph.edges[graph.faults == other]
        low, high = _box(graph.nodes[theirs], gammas[int(other)] + step)
        if (low > most).any() or (high < least).any():
            continue
        within = np.flatnonzero(((at[:, :2] >= low) & (at[:, :2] <= high)).all(axis=1))
        away = nearest(at[within, :2], graph.nodes, theirs).distance
        share[within] *= np.clip((away - gammas[int(other)]) / step, 0.0, 1.0)
    return Flanks(
        chosen,
        at,
        starts[edge] + ((foot - a) * way).sum(axis=1),
        side * near.distance[close],
        right,
        share,
        pieces,
        lines,
    )


def _pieces(graph: CutGraph, fault: int) -> tuple[IntArray, FloatArray, FloatArray, tuple[FloatArray, ...]]:
    """Return the edges of a fault in order, where each begins along the trace, the pieces and their lines."""
    mine = graph.edges[graph.faults == fault]
    forward = set(map(tuple, mine.tolist()))
    edges, starts, pieces, lines = [], [], [], []
    # windows reach half a piece beyond its ends: none meets the next
    begin, gap = 0.0, 2.0 * float(np.hypot(*np.diff(graph.nodes[mine][:, :, :2], axis=1)[:, 0].T).sum())
    for chain in chained(mine):
        path = chain if (int(chain[0]), int(chain[1])) in forward else chain[::-1]
        along = ways(graph.nodes[path])
        edges.append(np.stack([path[:-1], path[1:]], axis=1))
        starts.append(begin + along[:-1])
        pieces.append((begin, along[-1]))
        lines.append(graph.nodes[path])
        begin += along[-1] + gap
    return np.concatenate(edges), np.concatenate(starts), np.array(pieces), tuple(lines)


def _box(places: FloatArray, reach: float) -> tuple[FloatArray, FloatArray]:
    """Return the least and greatest corner in plan, (2,), of what is within ``reach`` of places (..., 3)."""
    flat = places.reshape(-1, 3)[:, :2]
    return floats(flat.min(axis=0) - reach), floats(flat.max(axis=0) + reach)


def _at_an_end(feet: FloatArray, lines: tuple[FloatArray, ...], step: float) -> FloatArray:
    """Return 1 where a foot (n, 2) is an end of the trace, 0 elsewhere."""
    ends = [line[k, :2] for line in lines if (line[0] != line[-1]).any() for k in (0, -1)]
    result = np.zeros(len(feet))
    for end in ends:
        result[np.linalg.norm(feet - end, axis=1) <= 1e-6 * step] = 1.0
    return result


@dataclass(frozen=True, eq=False)
class Planes:
    """A plane on one flank for each window: ``middle`` (w, 2), ``height`` (w,) there, ``slope`` (w, 2).

    ``scatter`` (w,) is the standard deviation about it; all are NaN where there are not enough points.
    """

    windows: Windows
    middle: FloatArray
    height: FloatArray
    slope: FloatArray
    scatter: FloatArray

    def at(self, along: FloatArray, plan: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return elevation (n,), slope (n, 2) and scatter (n,) at plan places (n, 2), windows blended."""
        total = np.zeros(len(along))
        sums = np.zeros((len(along), 4))
        known = np.flatnonzero(np.isfinite(self.height))
        for k in known:
            weight = hat(along, self.windows.centres[k], self.windows.reach[k])
            heights = self.height[k] + (plan - self.middle[k]) @ self.slope[k]
            constant = np.broadcast_to([*self.slope[k], self.scatter[k]], (len(along), 3))
            sums += weight[:, None] * np.column_stack([heights, constant])
            total += weight
        with np.errstate(invalid="ignore", divide="ignore"):
            mean = np.where(total[:, None] > 0, sums / total[:, None], np.nan)
        return mean[:, 0], mean[:, 1:3], mean[:, 3]


def planes(flanks: Flanks, windows: Windows, side: int, near: float, far: float) -> Planes:
    """Return robust planes through the points of one flank between two distances from the trace.

    Fitted with Huber's weights, so that a few wrong points do not turn a plane. The points' own weight is
    largest halfway between the two distances.

    Parameters
    ----------
    side : int
        1 for the side towards which the fault dips, -1 for the other.
    near, far : float
        Plan distances from the trace, model units.
    """
    count = len(windows.centres)
    middle, slope = np.full((count, 2), np.nan), np.full((count, 2), np.nan)
    height, scatter = np.full(count, np.nan), np.full(count, np.nan)
    between = hat(side * flanks.across, (near + far) / 2, (far - near) / 2) * flanks.share
    for k, (centre, reach) in enumerate(windows):
        weight = between * hat(flanks.along, centre, reach)
        used = np.flatnonzero(weight > 0)
        if len(used) < _LEAST:
            continue
        plan, z, weight = flanks.points[used, :2], flanks.points[used, 2], weight[used]
        centroid = weight @ plan / weight.sum()
        rel = (plan - centroid) * np.sqrt(weight / weight.sum())[:, None]
        long, short = np.linalg.svd(rel, compute_uv=False)
        if short <= _SPREAD * long:
            continue
        basis = np.column_stack([np.ones(len(z)), (plan - centroid) / long])
        found, scatter[k] = robust_fit(basis, z, weight)
        middle[k], height[k], slope[k] = centroid, found[0], found[1:] / long
    return Planes(windows, middle, height, slope, scatter)


def robust_fit(basis: FloatArray, values: FloatArray, weight: FloatArray) -> tuple[FloatArray, float]:
    """Return the coefficients (c,) of a weighted fit that large residuals pull little, and its scatter.

    Huber's proposal 2 by repeated least squares: the scatter is the root mean square of the residuals cut
    at 1.5 times itself (P. J. Huber, Robust estimation of a location parameter, Ann. Math. Stat. 35, 1964).
    """
    found: FloatArray = np.zeros(basis.shape[1])
    counted, scatter = weight, np.inf
    for _ in range(_ROUNDS):
        weighted = basis * counted[:, None]
        # few columns of one size: their products lose no digit that counts, and take a fifth of the time
        found = floats(np.linalg.lstsq(weighted.T @ basis, weighted.T @ values, rcond=None)[0])
        off = np.abs(values - basis @ found)
        cut = np.minimum(off, _CLIP * scatter)
        scatter = float(np.sqrt(weight @ cut**2 / (_CLIPPED_VARIANCE * weight.sum())))
        if scatter == 0.0:
            break
        counted = weight * np.minimum(1.0, _CLIP * scatter / np.maximum(off, np.finfo(float).tiny))
    return found, scatter
