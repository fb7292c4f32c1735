"""weld: vertices at one place become one, repeated and collapsed triangles go (answers `duplicate`)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from graben.arrays import ints
from graben.cleaning.repairing import Repair, of_one_fault
from graben.surface import Surface


def welded(surface: Surface) -> Surface:
    """Return the surface with vertices equal to the bit merged and each triangle once.

    The first of equal vertices and of equal triangles stays, in place and order; a triangle two corners of
    which coincide has no area and goes. A surface without duplicates comes back as it is.

    >>> doubled = Surface("F", [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 0, 0], [0, 1, 0], [1, 1, 1]],
    ...                   [[0, 1, 2], [3, 5, 4]])
    >>> welded(doubled).triangles.tolist()
    [[0, 1, 2], [1, 3, 2]]
    """
    _, first, inverse = np.unique(surface.vertices + 0.0, axis=0, return_index=True, return_inverse=True)
    corners = np.sort(inverse.reshape(-1)[surface.triangles], axis=1)
    whole = (corners[:, 0] != corners[:, 1]) & (corners[:, 1] != corners[:, 2])
    once = np.zeros(len(corners), dtype=bool)
    once[np.unique(corners, axis=0, return_index=True)[1]] = True
    if len(first) == len(surface.vertices) and once.all():
        return surface
    kept = np.sort(first)
    index = np.searchsorted(kept, first[inverse.reshape(-1)])
    chosen = np.flatnonzero(whole & once)
    lines = surface.lines[chosen] if len(surface.lines) else surface.lines
    return replace(
        surface,
        vertices=surface.vertices[kept],
        triangles=ints(index[surface.triangles[chosen]]),
        lines=lines,
    )


REPAIR = Repair(
    "weld",
    ("duplicate",),
    "Merges vertices equal to the bit and leaves out repeated triangles.",
    of_one_fault("duplicate", welded, "Vertices at one place were merged, repeated triangles left out."),
)
