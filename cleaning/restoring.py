"""A model repaired in a local frame, brought back to the coordinates of the input without a bit lost."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from graben.arrays import FloatArray, floats
from graben.model import Fault, Model
from graben.surface import Surface


def restored(local: Model, model: Model, origin: FloatArray) -> Model:
    """Return a model repaired in its local frame in the coordinates of the input.

    To shift there and back costs the last digit of some coordinates. So a fault that did not change is the
    input's own, and a vertex that a changed one still has gets the input's coordinates: vertices shared by
    several faults stay equal to the bit.

    Parameters
    ----------
    local : Model
        As repaired, shifted by ``-origin``.
    model : Model
        The input.
    origin : (3,) array
        Model units.
    """
    given = [f.surface.vertices for f in model.faults]
    before = np.concatenate(given) if given else np.zeros((0, 3))
    kept = np.isfinite(before).all(axis=1)
    known, first = np.unique((before - origin)[kept] + 0.0, axis=0, return_index=True)
    exact = before[kept][first]
    faults = []
    for fault in local.faults:
        own = _unchanged(fault.surface, model, origin)
        surface = own or fault.surface.with_vertices(_back(fault.surface.vertices, known, exact, origin))
        faults.append(Fault(surface, fault.gamma))
    return replace(model, faults=tuple(faults))


def _unchanged(surface: Surface, model: Model, origin: FloatArray) -> Surface | None:
    """Return the input's surface of this name where it is the same but for the shift."""
    for fault in model.faults:
        own = fault.surface
        if own.name != surface.name or own.vertices.shape != surface.vertices.shape:
            continue
        same = np.array_equal(own.triangles, surface.triangles)
        if same and np.array_equal(own.vertices - origin, surface.vertices, equal_nan=True):
            return own
    return None


def _back(points: FloatArray, known: FloatArray, exact: FloatArray, origin: FloatArray) -> FloatArray:
    """Return points shifted back; those equal to a ``known`` one get the coordinates in ``exact``."""
    result = points + origin
    if len(known):
        both = np.concatenate([known, points + 0.0])
        place = np.unique(both, axis=0, return_inverse=True)[1].reshape(-1)
        row = np.full(place.max() + 1, -1)
        row[place[: len(known)]] = np.arange(len(known))
        found = row[place[len(known) :]]
        result = np.where((found >= 0)[:, None], exact[np.maximum(found, 0)], result)
    return floats(result)
