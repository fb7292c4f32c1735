"""Picks of a horizon on the wrong side of a fault: next to one lip, at the elevation of the other."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from graben.arrays import FloatArray, IntArray, ints
from graben.cutgraph import CutGraph
from graben.model import Horizon
from graben.proximity import nearest
from graben.surface import Surface, triangle_normals
from graben.validators.measuring.flanks import Flanks, Windows, flanks_of, picks_of, planes

#: The trend of each lip is that of its picks between these distances from the trace, in gammas.
_NEAR, _FAR = 0.25, 1.25
#: Share of the way from the other lip (0) to its own (1) up to which a pick belongs to the other; to as much
#: from its own it belongs to that, and between them to neither.
_OTHER = 0.25
#: A pick further beyond the other lip than this share of the throw is an outlier, not a pick of that lip.
_BEYOND = 0.5
#: The throw over the scatter of the picks below which the lips cannot be told apart.
_CLEAR = 6.0
#: Picks nearer to the fault than this many steps, or this many times their scatter, lie on neither side.
_ON, _BLUR = 0.1, 2.0


@dataclass(frozen=True, eq=False)
class Strays:
    """Picks on the wrong side.

    ``picks`` (k,) are their indices, ``misfit`` (k,) how far they are off the lip of the side they lie on,
    in elevation, and ``beyond`` (k,) how far on the wrong side of the fault, in space; model units.
    """

    picks: IntArray
    misfit: FloatArray
    beyond: FloatArray


def strays(
    horizon: Horizon, fault: Surface, graph: CutGraph, number: int, gammas: Mapping[int, float]
) -> Strays:
    """Return the picks within gamma of a trace that lie on one side of the fault and belong to the other.

    The side is that on which a pick lies of the fault itself, in space; the lips are robust planes through
    the picks further out. A horizon that is smeared has as many picks between its lips as at the wrong one,
    and nothing is said of it; neither where the throw is small against the scatter of the picks.

    Parameters as for :func:`graben.validators.measuring.parallel.slope_ratios`.
    """
    nothing = Strays(ints([]), np.zeros(0), np.zeros(0))
    if not len(horizon.picks):
        return nothing
    gamma = gammas[number]
    flanks = flanks_of(picks_of(horizon), graph, number, gammas, _FAR * gamma, horizon.step)
    windows = Windows.over(flanks, max(gamma, horizon.step))
    plan, z = flanks.points[:, :2], flanks.points[:, 2]
    lips = [planes(flanks, windows, side, _NEAR * gamma, _FAR * gamma) for side in (-1, 1)]
    (foot, _, foot_scatter), (hanging, _, scatter) = (lip.at(flanks.along, plan) for lip in lips)
    away = _above(flanks, fault)
    blur = np.maximum(scatter, foot_scatter)
    side = np.where(np.abs(away) > np.maximum(_ON * horizon.step, _BLUR * blur), np.sign(away), 0.0)
    own, other = np.where(side > 0, hanging, foot), np.where(side > 0, foot, hanging)
    clear = (side != 0) & (np.abs(own - other) > _CLEAR * blur)
    clear &= (flanks.share == 1.0) & (np.abs(flanks.across) < gamma)
    with np.errstate(invalid="ignore", divide="ignore"):
        way = (z - other) / (own - other)
    wrong = clear & (way < _OTHER) & (way > -_BEYOND)
    between = clear & (way >= _OTHER) & (way <= 1.0 - _OTHER)
    if np.count_nonzero(wrong) <= np.count_nonzero(between):
        return nothing
    chosen = np.flatnonzero(wrong)
    chosen = chosen[np.argsort(flanks.index[chosen])]
    return Strays(ints(flanks.index[chosen]), np.abs(z - own)[chosen], np.abs(away)[chosen])


def _above(flanks: Flanks, fault: Surface) -> FloatArray:
    """Return the distance of points to a fault, (n,), positive on the side towards which it dips."""
    near = nearest(flanks.points, fault.vertices, fault.triangles)
    normals = triangle_normals(fault.vertices, fault.triangles)[near.simplex]
    off = ((flanks.points - near.place) * normals).sum(axis=1) * (normals[:, :2] * flanks.right).sum(axis=1)
    return np.where(off > 0, 1.0, -1.0) * near.distance
