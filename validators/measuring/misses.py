"""Where a fault that does not cut a horizon ends just above or below it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from graben.arrays import BoolArray, FloatArray, floats
from graben.model import Horizon
from graben.proximity import nearest
from graben.surface import Surface
from graben.validators.measuring.reach import dips_at, touching
from graben.validators.measuring.trace_measures import ON_BOUNDARY, above

#: A rim is looked at in pieces of so many steps at most: heights are then known to a part of a step.
_PIECE = 0.25
#: Nearer to the boundary of a horizon than this, in steps, a fault may end as the horizon does.
_OFF_BOUNDARY = 1.0
#: An edge of a rim ends the fault up or down dip where it runs less steeply down the fault than this cosine,
#: 45 degrees; else it ends it along strike.
_ALONG_DIP = np.sqrt(0.5)


@dataclass(frozen=True, eq=False)
class Miss:
    """Stretches of the rim of a fault, up or down dip, that lie within a step of a horizon.

    Parameters
    ----------
    places : (n, 3) array
        On the rim, model units.
    heights : (n,) array
        How far each lies above the horizon, negative below, model units.
    length : float
        Length of the stretch in plan, model units.
    """

    places: FloatArray
    heights: FloatArray
    length: float


def misses(
    horizon: Horizon, faults: Sequence[Surface], numbers: Sequence[int], contact: float
) -> dict[int, Miss]:
    """Return where faults end within a step above or below a horizon, by their numbers.

    Left out are places beside the horizon or within a step of its boundary, and rims on another fault.

    Parameters
    ----------
    horizon : Horizon
        A function of x and y.
    faults : sequence of Surface
        All faults of the model.
    numbers : sequence of int
        Those to look at, which do not cut the horizon.
    contact : float
        Distance at which two surfaces touch, model units.
    """
    box = _box(horizon)
    samples = [_rim_places(faults[k], _PIECE * horizon.step, box) for k in numbers]
    if not samples:
        return {}
    owner = np.repeat(numbers, [len(places) for places, _ in samples])
    places, length = (np.concatenate(parts) for parts in zip(*samples, strict=True))
    heights = above(floats(places), horizon.surface)
    some = np.flatnonzero(np.abs(heights) < horizon.step)
    some = some[_well_within(floats(places[some]), horizon)]
    found = {}
    for k in np.unique(owner[some]).tolist():
        own = some[owner[some] == k]
        own = own[~_on_others(floats(places[own]), faults, k, contact)]
        if len(own):
            found[k] = Miss(floats(places[own]), floats(heights[own]), float(length[own].sum()))
    return found


def _rim_places(
    surface: Surface, spacing: float, box: tuple[FloatArray, FloatArray]
) -> tuple[FloatArray, FloatArray]:
    """Return the middles of pieces of a rim up and down dip, (n, 3), and their plan lengths.

    No piece is longer than ``spacing``; what lies outside of a ``box``, its low and high corner (3,) each, is
    left out, so that a long edge makes no more pieces than the box has room for.
    """
    a, b = (surface.vertices[surface.rim[:, k]] for k in (0, 1))
    down = np.abs(((b - a) * dips_at(floats((a + b) / 2.0), surface)).sum(axis=1))
    ending = down < _ALONG_DIP * np.linalg.norm(b - a, axis=1)
    a, b = _clipped(a[ending], b[ending], *box)
    counts = np.maximum(np.ceil(np.linalg.norm(b - a, axis=1) / spacing), 1.0).astype(np.int64)
    edge = np.repeat(np.arange(len(counts)), counts)
    nth = np.arange(len(edge)) - np.repeat(np.cumsum(counts) - counts, counts)
    share = ((nth + 0.5) / counts[edge])[:, None]
    plan = np.linalg.norm((b - a)[:, :2], axis=1) / counts
    return floats(a[edge] + share * (b - a)[edge], -1, 3), floats(plan[edge])


def _box(horizon: Horizon) -> tuple[FloatArray, FloatArray]:
    """Return the low and the high corner of the box of a horizon, a step higher and lower than it."""
    margin = np.array([0.0, 0.0, horizon.step])
    vertices = horizon.surface.vertices
    return floats(vertices.min(axis=0) - margin), floats(vertices.max(axis=0) + margin)


def _clipped(
    a: FloatArray, b: FloatArray, low: FloatArray, high: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the parts of edges from ``a`` to ``b``, (n, 3) each, that lie in a box; (k, 3) each."""
    way = b - a
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = np.stack([(low - a) / way, (high - a) / way])
    inside = ((a >= low) & (a <= high))[None]
    # Along an axis on which an edge does not change it is inside all along, or nowhere.
    level = np.where(
        inside, np.array([-np.inf, np.inf])[:, None, None], np.array([np.inf, -np.inf])[:, None, None]
    )
    first, last = np.where(way == 0.0, level, np.sort(shares, axis=0))
    start, end = np.maximum(first.max(axis=1), 0.0), np.minimum(last.min(axis=1), 1.0)
    kept = start < end
    at, way = a[kept], way[kept]
    return floats(at + start[kept, None] * way), floats(at + end[kept, None] * way)


def _well_within(places: FloatArray, horizon: Horizon) -> BoolArray:
    """Return which places lie over or under a horizon and off its boundary."""
    surface, step = horizon.surface, horizon.step
    over = nearest(places[:, :2], surface.vertices, surface.triangles).distance <= ON_BOUNDARY * step
    off = nearest(places[:, :2], surface.vertices, surface.rim).distance > _OFF_BOUNDARY * step
    return np.asarray(over & off, dtype=bool)


def _on_others(places: FloatArray, faults: Sequence[Surface], number: int, contact: float) -> BoolArray:
    """Return which places on the rim of a fault lie on another fault, where it should end."""
    held = np.zeros(len(places), dtype=bool)
    for k, other in enumerate(faults):
        if k != number:
            held[touching(places, other, contact)] = True
    return held
