"""Which vertices of a fault are shared with others, equal to the bit: they lie on branch lines."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from graben.arrays import BoolArray, FloatArray
from graben.surface import Surface


def shared_vertices(surface: Surface, others: Iterable[Surface]) -> BoolArray:
    """Return which vertices of a surface are vertices of another one as well, equal to the bit, shape (n,).

    >>> line = [[0, 0, 0], [1, 0, 0]]
    >>> first = Surface("F", [*line, [0, 1, 1]], [[0, 1, 2]])
    >>> shared_vertices(first, [Surface("G", [*line, [0, -1, 1]], [[0, 1, 2]])]).tolist()
    [True, True, False]
    """
    points = [o.vertices for o in others if o is not surface]
    if not points or not len(surface.vertices):
        return np.zeros(len(surface.vertices), dtype=np.bool_)
    low, high = surface.vertices.min(axis=0), surface.vertices.max(axis=0)
    other = np.concatenate(points)
    return among(surface.vertices, other[((other >= low) & (other <= high)).all(axis=1)])


def among(points: FloatArray, others: FloatArray) -> BoolArray:
    """Return which points (n, 3) are equal to the bit to one of others (m, 3), shape (n,)."""
    both = np.concatenate([others, points]) + 0.0
    place = np.unique(both, axis=0, return_inverse=True)[1].reshape(-1)
    known = np.zeros(place.max(initial=-1) + 1, dtype=np.bool_)
    known[place[: len(others)]] = True
    return np.asarray(known[place[len(others) :]], dtype=np.bool_)
