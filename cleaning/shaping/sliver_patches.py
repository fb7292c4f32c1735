"""Patches around slivers meshed anew, where no flip and no collapse of an edge takes the sliver away."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from graben.arrays import BoolArray, IntArray, ints
from graben.cleaning.shaping.fans import trouble
from graben.cleaning.shaping.remeshing import differing, followed, remeshed, rings
from graben.cleaning.shaping.sliver_edits import (
    LAST_AWAY,
    LAST_TURN,
    bad_among,
    bad_triangles,
    departure,
    without_slivers,
)
from graben.proximity import nearest
from graben.surface import Surface, triangle_normals
from graben.validators.measuring.measures import side_lengths

#: Rings of triangles around a sliver that are meshed anew with it, and the lengths of edge tried over the
#: median there: the fewest rings that help differ, and a short edge that stays wants short ones around it.
_RINGS = (1, 2, 3)
_LENGTHS = (2.0, 1.4, 1.0, 0.7, 0.5, 0.35)
#: Slivers of a patch meshed anew over those before up to which edits are asked to take them away.
_MOST_MORE = 10


def with_patches_remeshed(
    surface: Surface,
    limit: float,
    held: BoolArray,
    lines: IntArray,
    away: float,
    fits: Callable[[Surface], bool] = lambda made: True,
) -> Surface:
    """Return the surface with the patches around slivers meshed anew, where that leaves fewer of them.

    Parameters
    ----------
    surface : Surface
        A sound surface, of which flips and collapses have taken what they can.
    limit : float
        Least angle, degrees.
    held : (n,) array
        Vertices that stay.
    lines : (k, 2) array
        Edges that stay, the smaller vertex first.
    away : float
        Largest distance from the surface, model units.
    fits : callable
        Whether a surface may be taken for all that is not asked here.
    """
    vain: set[bytes] = set()
    while True:
        bad = bad_triangles(surface, limit)
        keys = [surface.vertices[surface.triangles[t]].tobytes() for t in bad]
        left = [(t, key) for t, key in zip(bad.tolist(), keys, strict=True) if key not in vain]
        if not left:
            return surface
        t, key = left[0]
        made = None
        if not _between_lines(surface, t, lines):
            made = _patched(surface, t, limit, held, lines, away, fits)
        if made is None:
            vain.add(key)
            continue
        held, lines = followed(surface, made, held, lines)
        surface = made


def _between_lines(surface: Surface, t: int, lines: IntArray) -> bool:
    """Return whether the smallest angle of a triangle lies between two lines: no new mesh changes that."""
    corners = surface.triangles[t]
    k = int(side_lengths(surface.vertices, corners[None])[0].argmin())
    sides = np.sort([[corners[k], corners[k - 1]], [corners[k], corners[k - 2]]], axis=1)
    return all((lines == side).all(axis=1).any() for side in sides)


def _patched(
    surface: Surface,
    t: int,
    limit: float,
    held: BoolArray,
    lines: IntArray,
    away: float,
    fits: Callable[[Surface], bool],
) -> Surface | None:
    """Return a surface with the smallest patch around a sliver meshed anew that leaves fewer slivers.

    Of the lengths of edge tried on it, that which makes the fewest triangles more for each sliver that goes.
    """
    sides = side_lengths(surface.vertices, surface.triangles)
    far, bad = min(away, LAST_AWAY * float(sides[t].max())), len(bad_triangles(surface, limit))
    for count in _RINGS:
        patch = rings(surface.triangles, ints([t]), count)
        found: list[tuple[float, int, Surface]] = []
        for share in _LENGTHS:
            made = remeshed(surface, patch, held, lines, share * float(np.median(sides[patch])), far)
            if made is None or len(bad_triangles(made, limit)) > _MOST_MORE * bad:
                continue
            stay, edges = followed(surface, made, held, lines)
            made = without_slivers(made, limit, stay, far, edges)
            if _as_near(surface, made, limit, far) and fits(made):
                more = len(made.triangles) - len(surface.triangles)
                found.append((more / (bad - len(bad_triangles(made, limit))), len(found), made))
        if found:
            return min(found, key=lambda one: one[:2])[-1]
    return None


def _as_near(old: Surface, new: Surface, limit: float, away: float) -> bool:
    """Return whether a surface has fewer slivers than another, is as sound, and keeps to its shape."""
    if len(bad_triangles(new, limit)) >= len(bad_triangles(old, limit)):
        return False
    if any(a > b for a, b in zip(trouble(new.triangles), trouble(old.triangles), strict=True)):
        return False
    was, now = differing(old, new)
    before, after = (s.triangles[k] for s, k in ((old, was), (new, now)))
    if departure(old.vertices[before], new.vertices[after]) > away:
        return False
    # the normal of a sliver says nothing
    before, after = (t[~bad_among(s.vertices, t, limit)] for s, t in ((old, before), (new, after)))
    if not len(before):
        return False
    place = nearest(new.vertices[after].mean(axis=1), old.vertices, before).simplex
    a, b = triangle_normals(old.vertices, before)[place], triangle_normals(new.vertices, after)
    cosine = (a * b).sum(axis=1) / (np.linalg.norm(a, axis=1) * np.linalg.norm(b, axis=1))
    return bool((cosine >= np.cos(np.radians(LAST_TURN))).all())
