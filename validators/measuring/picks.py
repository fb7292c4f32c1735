"""Whether the input points of a horizon can be one function of x and y at its step, and where not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from graben.arrays import BoolArray, FloatArray, IntArray, ints
from graben.model import Fault, Horizon, Model
from graben.proximity import nearest
from graben.validators.measuring.measures import smallest_angles

#: Slope in degrees that a function on nodes of one step may have between two points.
STEEPEST = 85.0
#: Difference in elevation, in steps, that two points at one place may have besides.
JUMP = 1.0
#: The same in standard deviations of the horizon's noise, where that is more.
NOISE_JUMP = 6.0
#: So many others must agree that a point alone strays from them.
OTHERS = 3
#: Points are compared as far as their eighth neighbours lie, twice over: some thirty each.
NEIGHBOURS = 8
REACH = 2.0
#: Share by which points may lie further: those at that very distance, as on a grid, belong to it wherever
#: north is.
ROUNDING = 1e-9
#: Ordered pairs, each point with itself among them, above which only points at one place are compared.
MOST_PAIRS = 2e8
#: Places on the way from one point to the other that are compared with the faults.
PLACES_BETWEEN = 9


@dataclass(frozen=True, eq=False)
class Cliff:
    """Two points of a horizon, the higher first, that no function at its step joins.

    ``rise`` in elevation and ``run`` in plan, model units; ``points`` are their indices. ``stray`` is the
    index of a point that all such pairs of the horizon share, None where there is none.
    """

    points: tuple[int, int]
    rise: float
    run: float
    stray: int | None


def cliffs(
    model: Model, horizon: Horizon, faults: Sequence[Fault], steepest: float
) -> tuple[IntArray, Cliff | None]:
    """Return the input points of a horizon that stand above or below others at almost the same place.

    Two points within a step of each other in plan must not differ in elevation by more than a slope of
    ``steepest`` degrees gives between them, and a step besides. Where both lips of a fault are in the
    data they may: a pair within gamma of a fault, in space, is excused, since nothing there is taken
    from the input. ``faults`` are those whose surfaces are sound.

    Returns
    -------
    concerned : (k,) array
        Indices of the points of all such pairs.
    worst : Cliff or None
        The pair that exceeds what is allowed by most.
    """
    none = ints([]), None
    if len(horizon.picks) < 2:
        return none
    pairs = _close_pairs(horizon.picks, horizon.step)
    difference = horizon.picks[pairs[:, 0]] - horizon.picks[pairs[:, 1]]
    rise, run = np.abs(difference[:, 2]), np.hypot(difference[:, 0], difference[:, 1])
    jump = max(JUMP * horizon.step, NOISE_JUMP * (horizon.noise or 0.0))
    excess = rise - np.tan(np.radians(steepest)) * run - jump
    pairs, rise, run, excess = (array[excess > 0] for array in (pairs, rise, run, excess))
    free = ~_excused(model, horizon, faults, pairs)
    if not free.any():
        return none
    pairs, rise, run, excess = (array[free] for array in (pairs, rise, run, excess))
    k = int(np.argmax(excess))
    low, high = sorted((int(p) for p in pairs[k]), key=lambda p: float(horizon.picks[p, 2]))
    concerned, shares = np.unique(pairs, return_counts=True)
    shared = concerned[(shares == len(pairs)) & (shares >= OTHERS)]
    stray = int(shared[0]) if len(shared) else None
    return ints(concerned), Cliff((high, low), float(rise[k]), float(run[k]), stray)


def _close_pairs(picks: FloatArray, step: float) -> IntArray:
    """Return the pairs of points within a step in plan, or within some neighbours where points are dense."""
    tree = cKDTree(picks[:, :2])
    many = min(NEIGHBOURS, len(picks) - 1)
    reach = min(step, REACH * float(np.median(tree.query(picks[:, :2], many + 1)[0][:, -1])))
    reach *= 1.0 + ROUNDING
    if tree.count_neighbors(tree, reach) <= MOST_PAIRS:
        return np.asarray(tree.query_pairs(reach, output_type="ndarray"), dtype=np.int64)
    # heaps of points at one place: the lowest and the highest of each say enough
    order = np.lexsort(picks.T[::-1])
    change = (np.diff(picks[order, :2], axis=0) != 0).any(axis=1)
    low, high = order[np.concatenate([[True], change])], order[np.concatenate([change, [True]])]
    return np.asarray(np.stack([low, high], axis=1)[low != high], dtype=np.int64)


def _excused(model: Model, horizon: Horizon, faults: Sequence[Fault], pairs: IntArray) -> BoolArray:
    """Return which pairs of points have a place between them within gamma of a fault, shape (p,)."""
    excused = np.zeros(len(pairs), dtype=bool)
    if not len(pairs):
        return excused
    high, low = horizon.picks[pairs[:, 0]], horizon.picks[pairs[:, 1]]
    for fault in faults:
        vertices, triangles = fault.surface.vertices, fault.surface.triangles
        triangles = np.ascontiguousarray(triangles[smallest_angles(vertices, triangles) > 0])
        if not len(triangles):
            continue
        gamma = model.gamma(fault, horizon)
        for share in np.linspace(0.0, 1.0, PLACES_BETWEEN):
            points = np.ascontiguousarray(low + share * (high - low))
            excused |= nearest(points, vertices, triangles).distance <= gamma
    return excused
