"""How far the vertices of a repaired fault lie from the surface it came from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from graben.arrays import BoolArray, FloatArray, bools, floats, ints
from graben.cleaning.shaping.shared import among
from graben.proximity import nearest
from graben.surface import Surface, edge_table
from graben.validators.finite import usable

#: Share of a limit by which it may be passed: rounding of distances computed from coordinates far from 0.
ROUNDING = 1e-6


def distances(surface: Surface, references: Sequence[Surface]) -> FloatArray:
    """Return the distance of each vertex from the nearest triangle of any reference, shape (n,), model units.

    Vertices that no triangle uses count as unmoved, and so do all where no reference has a sound triangle.
    """
    away = np.zeros(len(surface.vertices))
    used = np.unique(surface.triangles[_sound(surface)])
    corners = [s.vertices[s.triangles[_sound(s)]] for s in references]
    points = np.concatenate([c.reshape(-1, 3) for c in corners] or [np.zeros((0, 3))])
    if not len(points) or not len(used):
        return floats(away)
    # vertices equal to the bit need no search, and none of its rounding
    kept = among(surface.vertices[used], points)
    asked = used[~kept]
    away[asked] = nearest(surface.vertices[asked], points, np.arange(len(points)).reshape(-1, 3)).distance
    return floats(away)


def reaches(surface: Surface, references: Sequence[Surface]) -> FloatArray:
    """Return how far a surface lies off at and beside each vertex, shape (n,), model units.

    That is the distance of the vertex, or of the middle of a side of a triangle there where that lies further
    off: other repairs put new vertices on the sides.
    """
    away = np.array(distances(surface, references))
    edges = edge_table(surface.triangles[_sound(surface)])[0]
    edges = edges[(away[edges] > 0).any(axis=1)]
    middles = len(away) + np.arange(len(edges))
    points = np.concatenate([surface.vertices, surface.vertices[edges].mean(axis=1)])
    halves = replace(
        surface, vertices=floats(points), triangles=ints(np.column_stack([edges, middles])), lines=ints([])
    )
    between = distances(halves, references)[middles]
    for end in (0, 1):
        np.maximum.at(away, edges[:, end], between)
    return floats(away)


def joined(first: Surface, second: Surface) -> Surface:
    """Return two surfaces as one under the name of the first; no vertices are merged."""
    return replace(
        first,
        vertices=floats(np.concatenate([first.vertices, second.vertices])),
        triangles=ints(np.concatenate([first.triangles, second.triangles + len(first.vertices)])),
        lines=ints([]),
    )


def _sound(surface: Surface) -> BoolArray:
    """Return which triangles have three vertices with usable coordinates, shape (m,)."""
    t = surface.triangles
    there = (t >= 0) & (t < len(surface.vertices))
    place = bools(usable(surface.vertices).all(axis=1))
    fit = there & (place[np.where(there, t, 0)] if len(place) else False)
    return np.asarray(fit.all(axis=1), dtype=np.bool_)
