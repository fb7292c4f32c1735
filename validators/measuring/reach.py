"""Whether a fault reaches as far up and down dip as a horizon will move along it when it is cut.

On either side of a trace the horizon beyond gamma is taken on, as a plane, to the fault: there its cutoff
will lie. A fault that ends between the trace and a cutoff is too short, and the cut would leave it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from graben.arrays import BoolArray, FloatArray, IntArray, bools, floats
from graben.cutgraph import CutGraph
from graben.model import Horizon
from graben.proximity import nearest
from graben.surface import Surface, triangle_normals
from graben.validators.measuring.flanks import Windows, flanks_of, nodes_of, planes, ways

#: The trend of each side is that of its nodes up to this many gammas from the trace.
_FAR = 2.0
#: A window, twice as long as its spacing and a gamma wide, holds about so many nodes at least: twice those
#: that a plane takes, since their weights fall to its ends.
_NODES = 12.0
#: Least slope of the fault against the side of the horizon, as a tangent, at which their cutoff is told.
_CLEAR = 0.1
#: Share of the elevation between the two sides that a fault must reach beyond them: as sure as planes tell.
_SAFETY = 0.05


@dataclass(frozen=True, eq=False)
class Reach:
    """How far a fault reaches at places of its trace, and how far it should; only places where that is known.

    Parameters
    ----------
    places : (n, 3) array
        On the trace, model units.
    length : (n,) array
        Length of the trace that each stands for, model units.
    dip : (n, 3) array
        Unit vector down the fault.
    above, below : (n, 3) arrays
        Where the fault ends up and down dip.
    missing_above, missing_below : (n,) arrays
        By how much in elevation it ends too early; negative where it reaches further, -inf where it ends on
        another fault.
    sure : (n,) array
        Which places lie further than gamma from the trace of another fault: both sides are seen there.
    """

    places: FloatArray
    length: FloatArray
    dip: FloatArray
    above: FloatArray
    below: FloatArray
    missing_above: FloatArray
    missing_below: FloatArray
    sure: BoolArray


def reach_of(
    horizon: Horizon,
    faults: Sequence[Surface],
    graph: CutGraph,
    number: int,
    gammas: Mapping[int, float],
    contact: float,
) -> Reach:
    """Return how far a fault reaches along its trace on a horizon, and how far it should.

    Left out are places beside which no horizon is seen, and where the fault is vertical or as good as
    parallel to the horizon. A rim that lies on another fault is where it should end: nothing is missing
    there.

    Parameters
    ----------
    horizon : Horizon
        Its nodes within 2 gamma of the trace are looked at.
    faults : sequence of Surface
        All faults of the model.
    graph : CutGraph
        Of that horizon.
    number : int
        Index of a fault that has edges in the graph.
    gammas : mapping
        gamma of each fault of the graph, model units.
    contact : float
        Distance at which two surfaces touch, model units.
    """
    fault, gamma = faults[number], gammas[number]
    flanks = flanks_of(nodes_of(horizon.surface), graph, number, gammas, _FAR * gamma, horizon.step)
    windows = Windows.over(flanks, max(gamma, horizon.step, _NODES * horizon.step**2 / (2.0 * gamma)))
    lips = [planes(flanks, windows, side, gamma, _FAR * gamma) for side in (-1, 1)]
    at = floats(np.concatenate([line[:-1] / 2 + line[1:] / 2 for line in flanks.lines]))
    size = [np.diff(ways(line)) for line in flanks.lines]
    along = floats(
        np.concatenate([b + np.cumsum(s) - s / 2 for b, s in zip(flanks.pieces[:, 0], size, strict=True)])
    )
    dip = dips_at(at, fault)
    level = np.hypot(dip[:, 0], dip[:, 1])
    onward = dip[:, :2] / np.where(level > 0, level, 1.0)[:, None]
    fall = -dip[:, 2] / np.where(level > 0, level, np.inf)
    cutoffs = []
    for lip in lips:
        height, slope, _ = lip.at(along, at[:, :2])
        rise = (slope * onward).sum(axis=1)
        clear = (level > 0) & (fall + rise > _CLEAR)
        with np.errstate(invalid="ignore", divide="ignore"):
            cutoffs.append(np.where(clear, height + rise * (at[:, 2] - height) / (fall + rise), np.nan))
    above, below = (_ends(at, sign * onward, fault) for sign in (-1.0, 1.0))
    top, bottom = np.maximum(*cutoffs), np.minimum(*cutoffs)
    safety = _SAFETY * (top - bottom)
    known = np.isfinite(top) & np.isfinite(above[:, 2]) & np.isfinite(below[:, 2])
    at, length, dip, above, below = (x[known] for x in (at, np.concatenate(size), dip, above, below))
    others = graph.edges[graph.faults != number]
    sure = np.ones(len(at), dtype=np.bool_)
    if len(others):
        sure = bools(nearest(at[:, :2], graph.nodes, others).distance > gamma)
    up, down = (top + safety)[known] - above[:, 2], below[:, 2] - (bottom - safety)[known]
    for k, other in enumerate(faults):
        if k != number:
            for rim, missing in ((above, up), (below, down)):
                missing[touching(rim, other, contact)] = -np.inf
    return Reach(
        floats(at), floats(length), floats(dip), floats(above), floats(below), floats(up), floats(down), sure
    )


def touching(places: FloatArray, fault: Surface, contact: float) -> IntArray:
    """Return which places (n, 3) lie within ``contact`` of a fault."""
    low, high = fault.vertices.min(axis=0) - contact, fault.vertices.max(axis=0) + contact
    close = np.flatnonzero(((places >= low) & (places <= high)).all(axis=1))
    return close[nearest(places[close], fault.vertices, fault.triangles).distance <= contact]


def dips_at(places: FloatArray, fault: Surface) -> FloatArray:
    """Return the unit vectors down dip of a fault at places on it, (n, 3); 0 where it is level."""
    near = nearest(places, fault.vertices, fault.triangles).simplex
    n = triangle_normals(fault.vertices, fault.triangles)[near]
    n = n * np.where(n[:, 2] < 0, -1.0, 1.0)[:, None]
    down = np.column_stack([n[:, 0] * n[:, 2], n[:, 1] * n[:, 2], -(n[:, 0] ** 2 + n[:, 1] ** 2)])
    size = np.linalg.norm(down, axis=1)
    return floats(down / np.where(size > 0, size, 1.0)[:, None])


def _ends(places: FloatArray, onward: FloatArray, fault: Surface) -> FloatArray:
    """Return where a fault ends on the way from places in plan directions, (n, 3): first of its rim."""
    edges = fault.rim
    a, b = fault.vertices[edges[:, 0]], fault.vertices[edges[:, 1]]
    found = np.full((len(places), 3), np.nan)
    for k, (place, way) in enumerate(zip(places, onward, strict=True)):
        off_a, off_b = ((end[:, :2] - place[:2]) @ [-way[1], way[0]] for end in (a, b))
        cross = np.flatnonzero((off_a <= 0) != (off_b <= 0))
        share = off_a[cross] / (off_a[cross] - off_b[cross])
        met = a[cross] + share[:, None] * (b[cross] - a[cross])
        ahead = (met[:, :2] - place[:2]) @ way
        ahead = np.where(ahead >= 0, ahead, np.inf)
        if len(ahead) and np.isfinite(ahead.min()):
            found[k] = met[np.argmin(ahead)]
    return found
