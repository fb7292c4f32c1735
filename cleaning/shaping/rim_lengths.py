"""How far to extend a fault from each vertex of its rim, from what is missing at places of the rim."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from graben.arrays import BoolArray, FloatArray, IntArray, floats, ints
from graben.cleaning.shaping.rim_chains import corners
from graben.proximity import nearest
from graben.surface import Surface, boundary_edges, boundary_loops

#: Beyond the places where something is missing an extension ends over this many times its length: a steeper
#: end would be a step in the rim.
_TAPER = 2.0
#: Corners of the rim are looked for within so many of its shorter edges: this percentile of them.
_EDGES, _SHORTER = 1.0, 25.0
#: An end shorter than this share of the median edge, or of the greatest need, is left out: it would be thin.
_LEAST = 0.2


def rim_needs(
    surface: Surface, places: FloatArray, needs: FloatArray, held: BoolArray, reach: float = 0.0
) -> list[tuple[IntArray, FloatArray]]:
    """Return the chains of rim vertices to extend a fault from, and how far from each.

    Parameters
    ----------
    surface : Surface
        The fault.
    places : (n, 3) array
        On its rim, model units.
    needs : (n,) array
        How far it should go on from each, model units.
    held : (v,) array
        Vertices at which it must not go on.
    reach : float
        Along the rim, within which of a place its whole need counts, model units; at least its edge.

    Returns
    -------
    list of ((k,) array, (k,) array)
        The greatest need within reach of each vertex, falling to 0 beyond the places; chains end at vertices
        of length 0 or at corners.
    """
    loops = boundary_loops(surface.triangles)
    which = np.repeat(np.arange(len(loops)), [len(loop) - 1 for loop in loops])
    edges = np.concatenate([np.stack([loop[:-1], loop[1:]], axis=1) for loop in loops])
    near = nearest(places, surface.vertices, ints(edges))
    found: list[tuple[IntArray, FloatArray]] = []
    for k, loop in enumerate(loops):
        mine = which[near.simplex] == k
        if not mine.any():
            continue
        edge = near.simplex[mine] - int(np.flatnonzero(which == k)[0])
        far, active = _lengths(surface, loop, edge, near.place[mine], needs[mine], reach)
        least = _LEAST * min(surface.median_edge, float(needs[mine].max()))
        far = np.where(held[loop] | (far < least), 0.0, far)
        active &= (far[:-1] > 0) | (far[1:] > 0)
        found += list(_chains(loop, floats(far), active))
    return found


def _lengths(
    surface: Surface, loop: IntArray, edge: IntArray, places: FloatArray, needs: FloatArray, reach: float
) -> tuple[FloatArray, BoolArray]:
    """Return the length at each vertex of a loop, (k,), and which edges are of sides with needs, (k - 1,).

    The upper hull of tapers over the places' needs. At both ends of an edge that holds a place its whole need
    counts. A need does not go around a corner.
    """
    at = surface.vertices[loop]
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(at, axis=0), axis=1))])
    on = way[edge] + np.linalg.norm(places - at[edge], axis=1)
    window = _EDGES * float(np.percentile(np.diff(way), _SHORTER))
    corner = np.flatnonzero(corners(at, way, window, True)[:-1])
    side = np.searchsorted(corner, np.arange(len(loop) - 1), side="right")
    side = np.where(side == len(corner), 0, side)
    far, active = np.zeros(len(loop)), np.zeros(len(loop) - 1, dtype=np.bool_)
    for s in np.unique(side[edge]):
        own = side == s
        some = side[edge] == s
        vertex = np.zeros(len(loop), dtype=bool)
        vertex[:-1] |= own
        vertex[1:] |= own
        gap = np.abs(way[:, None] - on[some])
        gap = np.maximum(np.minimum(gap, way[-1] - gap) - reach, 0.0)
        number = np.arange(len(loop))[:, None]
        gap[(number == edge[some]) | (number == edge[some] + 1)] = 0.0
        hull = (np.maximum(1.0 - gap / (_TAPER * needs[some]), 0.0) * needs[some]).max(axis=1)
        far = np.maximum(far, np.where(vertex, hull, 0.0))
        active |= own
    far[[0, -1]] = far[[0, -1]].max()
    return floats(far), active


def _chains(loop: IntArray, far: FloatArray, active: BoolArray) -> Iterable[tuple[IntArray, FloatArray]]:
    """Return the parts of a closed loop along active edges, with their lengths."""
    if active.all():
        return [(loop, far)]
    start = int(np.flatnonzero(~active)[0])
    loop, far = (np.append(np.roll(x[:-1], -start), x[start]) for x in (loop, far))
    on = np.roll(active, -start)
    runs = np.split(np.arange(len(on)), np.flatnonzero(on[1:] != on[:-1]) + 1)
    return [(ints(loop[r[0] : r[-1] + 2]), floats(far[r[0] : r[-1] + 2])) for r in runs if on[r[0]]]


def resting(surface: Surface, others: Iterable[Surface], contact: float) -> BoolArray:
    """Return at which vertices the rim of a fault rests on others, shape (v,): it has to end there.

    Where a rim only passes another fault, at a point, it need not end.
    """
    edges = boundary_edges(surface.triangles)
    middles = surface.vertices[edges].mean(axis=1)
    on = np.zeros(len(edges), dtype=bool)
    for other in others:
        on |= nearest(middles, other.vertices, other.triangles).distance <= contact
    held = np.zeros(len(surface.vertices), dtype=np.bool_)
    held[edges[on]] = True
    return held
