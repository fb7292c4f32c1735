"""Faults with cracks: rims that face each other across nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from graben.arrays import ints
from graben.cleaning.weld import welded
from graben.surface import Surface, boundary_edges, triangle_areas
from tests.zoo.shapes import STEP, joined, sheet


def area(surface: Surface) -> float:
    return float(triangle_areas(surface.vertices, surface.triangles).sum())


def rim_length(surface: Surface) -> float:
    ends = surface.vertices[boundary_edges(surface.triangles)]
    return float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum())


def outline(surface: Surface) -> np.ndarray:
    """The vertices of the rim, sorted."""
    return np.unique(surface.vertices[np.unique(boundary_edges(surface.triangles))], axis=0)


def strips(ratio: int = 2, columns: int = 4, off: float = 0.0) -> Surface:
    """A coarse strip beside one of ``ratio`` times as many columns; its vertices are off the edges."""
    coarse = sheet(columns, 2, lambda i, j: (STEP * i, 30 * (j - 2), 40 * (2 - j)))
    fine = sheet(
        ratio * columns,
        2,
        lambda i, j: (STEP * i / ratio, 30 * j, -40 * j + off * (j == 0) * (i % ratio > 0)),
    )
    return welded(joined(coarse, fine))


def hanging(off: float = 0.0) -> Surface:
    """A fault with one vertex in the middle of an edge inside, on one side of the edge only."""
    whole = sheet(6, 4, lambda i, j: (STEP * i, 30 * j, -40 * j))
    edge = whole.triangles[13][[0, 1]]
    t = np.flatnonzero(np.isin(whole.triangles, edge).sum(axis=1) == 2)[0]
    (tip,) = np.setdiff1d(whole.triangles[t], edge)
    k = int(np.flatnonzero(whole.triangles[t] == tip)[0])
    a, b = whole.triangles[t][(k + 1) % 3], whole.triangles[t][(k + 2) % 3]
    new = len(whole.vertices)
    place = whole.vertices[[a, b]].mean(axis=0) + np.array([0, 0.8 * off, 0.6 * off])
    triangles = np.delete(whole.triangles, t, axis=0)
    return replace(
        whole,
        vertices=np.vstack([whole.vertices, place]),
        triangles=ints(np.concatenate([triangles, [[tip, a, new], [tip, new, b]]])),
    )


def halves(gap: float) -> Surface:
    """A fault in two halves with as many vertices along the line between them, a gap apart."""
    return joined(
        sheet(3, 4, lambda i, j: (STEP * i, 30 * j, -40 * j)),
        sheet(3, 4, lambda i, j: (STEP * (3 + i) + gap * (i == 0), 30 * j + 0.3 * gap, -40 * j)),
    )
