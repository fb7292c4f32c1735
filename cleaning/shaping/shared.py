"""Which vertices of a fault are shared with others, equal to the bit: they lie on branch lines."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from graben.arrays import BoolArray
from graben.surface import Surface


def shared_vertices(surface: Surface, others: Iterable[Surface]) -> BoolArray:
    """Return which vertices of a surface are vertices of another one as well, equal to the bit, shape (n,).

    >>> line = [[0, 0, 0], [1, 0, 0]]
    >>> first = Surface("F", [*line, [0, 1, 1]], [[0, 1, 2]])
    >>> shared_vertices(first, [Surface("G", [*line, [0, -1, 1]], [[0, 1, 2]])]).tolist()
    [True, True, False]
    """
    points = [o.vertices for o in others if o is not surface]
    shared = np.zeros(len(surface.vertices), dtype=np.bool_)
    if not points or not len(shared):
        return shared
    own = surface.vertices + 0.0
    low, high = own.min(axis=0), own.max(axis=0)
    other = np.concatenate(points) + 0.0
    other = other[((other >= low) & (other <= high)).all(axis=1)]
    both = np.concatenate([np.unique(other, axis=0), own])
    place, counts = np.unique(both, axis=0, return_inverse=True, return_counts=True)[1:]
    of_other = np.zeros(len(counts), dtype=np.bool_)
    of_other[place.reshape(-1)[: len(both) - len(own)]] = True
    return np.asarray(of_other[place.reshape(-1)[len(both) - len(own) :]], dtype=np.bool_)
