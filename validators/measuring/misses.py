"""Where a fault that does not cut a horizon ends just above or below it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from graben.arrays import BoolArray, FloatArray, IntArray, floats
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
    samples = [_rim_places(faults[k], _PIECE * horizon.step) for k in numbers]
    if not samples:
        return {}
    owner = np.repeat(numbers, [len(places) for places, _ in samples])
    places, length = (np.concatenate(parts) for parts in zip(*samples, strict=True))
    some = _in_box(places, horizon)
    heights = np.full(len(places), np.inf)
    heights[some] = above(floats(places[some]), horizon.surface)
    some = some[np.abs(heights[some]) < horizon.step]
    some = some[_well_within(floats(places[some]), horizon)]
    found = {}
    for k in np.unique(owner[some]).tolist():
        own = some[owner[some] == k]
        own = own[~_on_others(floats(places[own]), faults, k, contact)]
        if len(own):
            found[k] = Miss(floats(places[own]), floats(heights[own]), float(length[own].sum()))
    return found


def _rim_places(surface: Surface, spacing: float) -> tuple[FloatArray, FloatArray]:
    """Return the middles of pieces of a rim up and down dip, (n, 3), and their plan lengths.

    No piece is longer than ``spacing``.
    """
    a, b = (surface.vertices[surface.rim[:, k]] for k in (0, 1))
    down = np.abs(((b - a) * dips_at(floats((a + b) / 2.0), surface)).sum(axis=1))
    ending = down < _ALONG_DIP * np.linalg.norm(b - a, axis=1)
    a, b = a[ending], b[ending]
    counts = np.maximum(np.ceil(np.linalg.norm(b - a, axis=1) / spacing), 1.0).astype(np.int64)
    edge = np.repeat(np.arange(len(counts)), counts)
    nth = np.arange(len(edge)) - np.repeat(np.cumsum(counts) - counts, counts)
    share = ((nth + 0.5) / counts[edge])[:, None]
    plan = np.linalg.norm((b - a)[:, :2], axis=1) / counts
    return floats(a[edge] + share * (b - a)[edge], -1, 3), floats(plan[edge])


def _in_box(places: FloatArray, horizon: Horizon) -> IntArray:
    """Return which places lie in the box of a horizon, or less than a step above or below it."""
    margin = np.array([0.0, 0.0, horizon.step])
    low, high = horizon.surface.vertices.min(axis=0) - margin, horizon.surface.vertices.max(axis=0) + margin
    return np.flatnonzero(((places >= low) & (places <= high)).all(axis=1))


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
