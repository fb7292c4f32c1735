"""The smear of faults that run close to each other, measured together and taken out between them.

Between two faults less than their gammas apart the steps of both are smeared over each other: no place shows
one of them alone. But what smears is linear. With d_j the distance to fault j, s the place along fault k, the
horizon around fault k is described as

    u = c(d_k, s) + sum over j of (2 Phi(d_j / w) - 1) h_j(|d_j|, s),

the step of each close fault beside its own: see :mod:`graben.validators.measuring.smear`, which this is with
one fault. The outer sides tell what both steps come to, the strip tells them apart, and both tell w.

With it known, a node of the strip that the smear still reaches is put where it would be without: each fault k
has moved it by sign(d_k) (2 Phi(|d_k| / w_k) - 2) h_k.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.special import ndtr

from graben.arrays import FloatArray, floats
from graben.cutgraph import CutGraph
from graben.model import Horizon
from graben.modeling.distance import distances
from graben.proximity import PlanIndex, nearest
from graben.validators.measuring.flanks import Flanks, Windows, flanks_of, hat, nodes_of, picks_of
from graben.validators.measuring.measures import remembered
from graben.validators.measuring.smear import (
    CLEARER,
    DONE,
    FINEST,
    INSIDE,
    LEAST,
    LEAST_A_SIDE,
    LEAST_SIGNAL,
    STRIPS,
    TRIED,
    spacing_of,
)

#: Share of a width to which it is sought: the shape of a smear that is not Gaussian tells it no better.
_CLOSE_ENOUGH = 0.01
#: Points that a window needs more for each close fault, which has three terms.
_LEAST_A_FAULT = 10


@dataclass(frozen=True, eq=False)
class CloseSmear:
    """How a horizon is smeared along a fault that runs close to others.

    Parameters
    ----------
    fault : int
        Index in the model.
    width : float
        Standard width of the Gaussian, model units.
    reach : float
        Half width of the strip that was looked at, model units.
    windows : Windows
        Windows along the trace that were fitted.
    halves : (w, 3) array
        Half the step at the trace in each, and what it grows by over ``reach`` across the trace and over the
        half width of the window along it; model units.
    """

    fault: int
    width: float
    reach: float
    windows: Windows
    halves: FloatArray

    def moved(self, flanks: Flanks) -> FloatArray:
        """Return by how much the smear of this fault has lifted points, (n,), 0 where no window reaches."""
        total, lift = np.zeros(len(flanks.index)), np.zeros(len(flanks.index))
        away = np.abs(flanks.across)
        for (centre, half), found in zip(self.windows, self.halves, strict=True):
            weight = hat(flanks.along, centre, half)
            along = (flanks.along - centre) / half
            lift += weight * (found[0] + found[1] * away / self.reach + found[2] * along)
            total += weight
        lift = np.divide(lift, total, out=np.zeros_like(lift), where=total > 0)
        left = np.sign(flanks.across) * (2.0 * ndtr(away / self.width) - 2.0)
        return np.asarray(flanks.share * left * lift, dtype=np.float64)


def close_faults(graph: CutGraph, fault: int, gammas: Mapping[int, float]) -> tuple[int, ...]:
    """Return the faults whose zones overlap that of a fault in the graph though they do not meet it.

    ``gammas``: of each fault of the graph, model units.
    """
    mine = np.unique(graph.edges[graph.faults == fault])
    found = []
    for other in sorted(set(gammas) - {fault}):
        theirs = graph.faults == other
        if np.isin(graph.edges[theirs], mine).any():
            continue
        room = gammas[fault] + gammas[other]
        if (distances(graph.nodes[mine, :2], graph, theirs, room)[0] < room).any():
            found.append(other)
    return tuple(found)


def close_smear(
    horizon: Horizon, graph: CutGraph, fault: int, gammas: Mapping[int, float]
) -> CloseSmear | None:
    """Return how a horizon is smeared along a fault that others run close to.

    Parameters
    ----------
    horizon : Horizon
        As given, in the frame of the graph.
    graph : CutGraph
        Of that horizon.
    fault : int
        Index in the model of a fault that the graph has edges of.
    gammas : mapping
        gamma of each fault of the graph, model units.

    Returns
    -------
    CloseSmear or None
        None where no fault is close, and where jumps describe the horizon nearly as well.
    """
    return _measured(horizon, graph, fault, tuple(sorted(gammas.items())))


def unsmeared(
    points: FloatArray, horizon: Horizon, graph: CutGraph, gammas: Mapping[int, float]
) -> FloatArray:
    """Return the elevations of points of a horizon without the smear of the faults that are close to others.

    Parameters
    ----------
    points : (n, 3) array
        On the horizon, model units.
    horizon, graph, gammas
        As of :func:`close_smear`.

    Returns
    -------
    (n,) array
        Model units.
    """
    z, index = points[:, 2].copy(), PlanIndex(points)
    for fault in sorted(gammas):
        smear = close_smear(horizon, graph, fault, gammas)
        if smear is not None:
            flanks = flanks_of(
                index, graph, fault, _seen(gammas, gammas, horizon.step), smear.reach, horizon.step
            )
            z[flanks.index] -= smear.moved(flanks)
    return floats(z)


@remembered
def _measured(
    horizon: Horizon, graph: CutGraph, fault: int, pairs: tuple[tuple[int, float], ...]
) -> CloseSmear | None:
    gammas = dict(pairs)
    close = {f: gammas[f] for f in close_faults(graph, fault, gammas)}
    if not close:
        return None
    points = picks_of(horizon) if len(horizon.picks) else nodes_of(horizon.surface)
    step = spacing_of(horizon)
    for steps in STRIPS:
        reach = steps * step
        flanks = flanks_of(points, graph, fault, _seen(gammas, close, step), reach, step)
        seen = _fitted_to(flanks, graph, close, reach, step)
        if not seen:
            continue
        tried = np.geomspace(FINEST * step, INSIDE * reach, TRIED)
        width = _least(seen, tried)
        if DONE * width <= INSIDE * reach:
            return _described(fault, seen, width, reach)
    return None


def _seen(gammas: Mapping[int, float], close: Mapping[int, float], step: float) -> dict[int, float]:
    """Return gammas that leave no point out, of :func:`flanks_of`, for being near to a close fault."""
    return {f: -step if f in close else gamma for f, gamma in gammas.items()}


@dataclass(frozen=True, eq=False)
class _Window:
    """Points in a window: place along it (-1 to 1), distances (1 + o, n) to its fault and to close ones,
    elevation, root of the weight; ``reach`` is the half width of the strip."""

    centre: float
    half: float
    along: FloatArray
    across: FloatArray
    z: FloatArray
    root: FloatArray
    reach: float

    def fit(self, width: float) -> tuple[FloatArray, float]:
        """Return h_k, as of ``CloseSmear.halves``, and the sum of squared residuals; width 0 is a jump."""
        d, s = self.across[0] / self.reach, self.along
        columns = [np.ones_like(d), d, d * d, s, s * d]
        smooth = len(columns)
        for away in self.across:
            step = np.sign(away) if width == 0.0 else 2.0 * ndtr(away / width) - 1.0
            columns += [step, step * np.abs(away) / self.reach, step * s]
        left, right = np.stack(columns, axis=1) * self.root[:, None], self.z * self.root
        found = np.linalg.lstsq(left, right, rcond=None)[0]
        return floats(found[smooth : smooth + 3]), float(((right - left @ found) ** 2).sum())


def _fitted_to(
    flanks: Flanks, graph: CutGraph, close: Mapping[int, float], reach: float, step: float
) -> list[_Window]:
    """Return the windows along a trace that have points enough; ``close``: gammas of the close faults."""
    share, across = flanks.share, [flanks.across]
    for other, gamma in close.items():
        away, beyond = _signed(flanks.points[:, :2], graph, other)
        # Beyond an end there is no step, nor a side.
        near = np.clip((gamma + step - np.abs(away)) / step, 0.0, 1.0)
        share = share * (1.0 - near * np.clip(beyond / step, 0.0, 1.0))
        across.append(away)
    distance = np.stack(across)
    found = []
    for centre, half in Windows.over(flanks, reach / 2):
        weight = share * hat(flanks.along, centre, half) * hat(flanks.across, 0.0, reach)
        used = np.flatnonzero(weight > 0)
        # The step of a fault further away is none here.
        near = distance[(np.abs(distance[:, used]) < reach).any(axis=1)]
        right = int(np.count_nonzero(flanks.across[used] > 0))
        least = LEAST + _LEAST_A_FAULT * (len(near) - 1)
        if len(used) >= least and min(right, len(used) - right) >= LEAST_A_SIDE:
            along, root = (flanks.along[used] - centre) / half, np.sqrt(weight[used])
            z = flanks.points[used, 2]
            found.append(_Window(centre, half, along, near[:, used], z, root, reach))
    return found


def _signed(plan: FloatArray, graph: CutGraph, fault: int) -> tuple[FloatArray, FloatArray]:
    """Return the distance of places (n, 2) to a trace, as ``Flanks.across``, and how far beyond an end."""
    edges = graph.edges[graph.faults == fault]
    near = nearest(plan, graph.nodes, edges)
    a, b = (graph.nodes[edges[near.simplex, k], :2] for k in (0, 1))
    way = (b - a) / np.maximum(np.linalg.norm(b - a, axis=1), np.finfo(float).tiny)[:, None]
    off = plan - near.place[:, :2]
    side = np.where((off * np.stack([way[:, 1], -way[:, 0]], axis=1)).sum(axis=1) > 0, 1.0, -1.0)
    return floats(side * near.distance), floats(np.abs((off * way).sum(axis=1)))


def _left(windows: list[_Window], width: float) -> float:
    """Return the sum of squared residuals over all windows."""
    return sum(w.fit(width)[1] for w in windows)


def _least(windows: list[_Window], tried: FloatArray) -> float:
    """Return the width that leaves the least residuals, between those tried."""
    best = int(np.argmin([_left(windows, width) for width in tried]))
    bounds = tried[max(best - 1, 0)], tried[min(best + 1, len(tried) - 1)]
    found = minimize_scalar(
        lambda width: _left(windows, width),
        bounds=bounds,
        method="bounded",
        options={"xatol": _CLOSE_ENOUGH * tried[best]},
    )
    return float(found.x)


def _described(fault: int, seen: list[_Window], width: float, reach: float) -> CloseSmear | None:
    """Return the smear of a standard width; None where there is no step, or jumps do nearly as well."""
    halves = np.array([w.fit(width)[0] for w in seen])
    left = _left(seen, width)
    scatter = float(np.sqrt(left / sum(w.root @ w.root for w in seen)))
    throw = 2.0 * float(np.sqrt((halves[:, 0] ** 2).mean()))
    if throw <= LEAST_SIGNAL * scatter or _left(seen, 0.0) < CLEARER * left:
        return None
    windows = Windows(np.array([w.centre for w in seen]), np.array([w.half for w in seen]))
    return CloseSmear(fault, width, reach, windows, floats(halves))
