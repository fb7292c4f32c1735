"""An independent count of triangles that cross, by exact orientation predicates and nothing else."""

from __future__ import annotations

import numpy as np
from igl import predicates

from graben.surface import Surface


def touching_pairs(surfaces) -> tuple[np.ndarray, np.ndarray]:
    """The pairs of triangles of different surfaces that have a point in common.

    Returns the pairs (p, 2), counted through all surfaces, and whether the two have a vertex in common.
    """
    vertices, triangles, owner = stacked(surfaces)
    _, pairs, _ = predicates.find_self_intersections(vertices, triangles)
    pairs = pairs[owner[pairs[:, 0]] != owner[pairs[:, 1]]]
    _, place = np.unique(vertices + 0.0, axis=0, return_inverse=True)
    corners = place.reshape(-1)[triangles]
    shared = corners[pairs[:, 0]][:, :, None] == corners[pairs[:, 1]][:, None, :]
    return pairs, shared.any(axis=(1, 2))


def crosses_properly(surfaces, pairs: np.ndarray) -> np.ndarray:
    """Which pairs of triangles cross: a side of one passes through the inside of the other."""
    vertices, triangles, _ = stacked(surfaces)
    found = np.zeros(len(pairs), dtype=bool)
    for first, second in ((0, 1), (1, 0)):
        side = vertices[triangles[pairs[:, first]]]
        a, b, c = (np.ascontiguousarray(x) for x in np.moveaxis(vertices[triangles[pairs[:, second]]], 1, 0))
        for k in range(3):
            p, q = (np.ascontiguousarray(side[:, (k + n) % 3]) for n in (0, 1))
            apart = predicates.orient3d(a, b, c, p) * predicates.orient3d(a, b, c, q) < 0
            turns = np.array([predicates.orient3d(p, q, *ends) for ends in ((a, b), (b, c), (c, a))])
            found |= apart & ((turns > 0).all(axis=0) | (turns < 0).all(axis=0))
    return found


def by_fault(surfaces, pairs: np.ndarray) -> set[tuple[int, int]]:
    """The pairs of surfaces of pairs of triangles, the smaller first."""
    owner = stacked(surfaces)[2]
    return {(int(a), int(b)) for a, b in np.unique(np.sort(owner[pairs], axis=1), axis=0)}


def stacked(surfaces: list[Surface]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vertices and triangles of all surfaces, and the surface of each triangle."""
    starts = np.cumsum([0] + [len(s.vertices) for s in surfaces])
    return (
        np.ascontiguousarray(np.concatenate([s.vertices for s in surfaces])),
        np.ascontiguousarray(
            np.concatenate([s.triangles + k for s, k in zip(surfaces, starts, strict=False)])
        ),
        np.repeat(np.arange(len(surfaces)), [len(s.triangles) for s in surfaces]),
    )
