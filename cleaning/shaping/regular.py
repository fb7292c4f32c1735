"""Vertices without a place, from the rule that two triangles at an edge form a parallelogram."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graben.arrays import BoolArray, FloatArray, IntArray, bools, floats, ints
from graben.surface import Surface
from graben.validators.measuring.measures import components, lengths, smallest_angles

#: Most vertices next to each other that are restored by the rule: beyond, what is around says too little.
MOST_REGULAR = 24
#: Longest edge of a restored triangle, in median edges of the triangles around.
_LONGEST = 3.0
#: Least cosine between two triangles at an edge of a restored patch: 73 degrees, none is turned over.
_UNFOLDED = 0.3
#: Smallest angle of a restored triangle, degrees: where the rule does not hold the shapes get odd.
_LEAST_ANGLE = 5.0


@dataclass(frozen=True, eq=False)
class _Hinges:
    """Pairs of triangles at an edge: its ends and the two other corners, shape (h, 4)."""

    corners: IntArray

    def at(self, some: BoolArray) -> IntArray:
        """Return those with a vertex among some (n,) of them."""
        return ints(self.corners[some[self.corners].any(axis=1)], -1, 4)


def regular_places(surface: Surface, lost: BoolArray) -> FloatArray:
    """Return the vertices of a surface, those lost put where a regular mesh would have them.

    Of two triangles (i, j, k) and (j, i, l) of a regular mesh x_k + x_l = x_i + x_j. The lost vertices that
    are neighbours get the places that meet this best in the sense of least squares, at all edges that concern
    them. That is exact for a regular mesh, its rim and corners included. Where they are too many, not
    determined, or the triangles would be turned over, long or thin, they stay without a place.

    Parameters
    ----------
    surface : Surface
        All its indices in range.
    lost : (n,) array
        Vertices without a place, whatever they hold.

    Returns
    -------
    (n, 3) array
        Model units; not a number where a lost vertex got no place.

    >>> x = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [float("nan")] * 3]
    >>> places = regular_places(Surface("F", x, [[0, 1, 2], [2, 1, 3]]), np.isnan(x).any(axis=1))
    >>> places[3].round(12).tolist()
    [1.0, 1.0, 0.0]
    """
    places = np.where(lost[:, None], np.nan, surface.vertices)
    t = surface.triangles
    edges = np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]])
    cluster = components(len(places), ints(edges[lost[edges].all(axis=1)], -1, 2))
    hinges = _hinges(t)
    groups, counts = np.unique(cluster[lost], return_counts=True)
    for group in groups[counts <= MOST_REGULAR].tolist():
        own = np.asarray(lost & (cluster == group), dtype=np.bool_)
        found = _solved(places, own, hinges.at(own))
        if found is not None and _sound(found, t, own, lost, hinges):
            places[own] = found[own]
    return floats(places)


def _hinges(triangles: IntArray) -> _Hinges:
    """Return the pairs of triangles at edges that belong to two."""
    edges = np.sort(
        np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1
    )
    opposite = np.concatenate([triangles[:, 2], triangles[:, 0], triangles[:, 1]])
    order = np.lexsort((opposite, edges[:, 1], edges[:, 0]))
    edges, opposite = edges[order], opposite[order]
    new = np.ones(len(edges), dtype=np.bool_)
    new[1:] = (edges[1:] != edges[:-1]).any(axis=1)
    first = np.flatnonzero(new)
    two = first[np.diff(np.append(first, len(edges))) == 2]
    return _Hinges(ints(np.column_stack([edges[two], opposite[two], opposite[two + 1]]), -1, 4))


def _solved(places: FloatArray, own: BoolArray, hinges: IntArray) -> FloatArray | None:
    """Return the places with those of a cluster filled in; None where the rule does not determine them."""
    own_rows = np.flatnonzero(own)
    # a corner that is itself lost, and not of this cluster, says nothing
    usable = (own[hinges] | np.isfinite(places[hinges]).all(axis=2)).all(axis=1)
    hinges = hinges[usable]
    if len(hinges) < len(own_rows):
        return None
    sign = np.array([-1.0, -1.0, 1.0, 1.0])
    row, k = np.nonzero(own[hinges])
    matrix = np.zeros((len(hinges), len(own_rows)))
    np.add.at(matrix, (row, np.searchsorted(own_rows, hinges[row, k])), sign[k])
    known = np.where(own[hinges][..., None], 0.0, places[hinges])
    # from a near origin, so that the solution keeps the digits of far coordinates
    origin = known[~own[hinges]].mean(axis=0) if (~own[hinges]).any() else np.zeros(3)
    shifted = np.where(own[hinges][..., None], 0.0, places[hinges] - origin)
    answer, _, rank, _ = np.linalg.lstsq(matrix, -(sign[:, None] * shifted).sum(axis=1), rcond=None)
    if rank < len(own_rows):
        return None
    found = np.array(places)
    found[own_rows] = answer + origin
    return floats(found)


def _sound(places: FloatArray, triangles: IntArray, own: BoolArray, lost: BoolArray, hinges: _Hinges) -> bool:
    """Return whether the triangles at the vertices of a cluster are like those around them."""
    there = bools(np.isfinite(places).all(axis=1))[triangles].all(axis=1)
    made = triangles[there & own[triangles].any(axis=1)]
    near = np.zeros(len(places), dtype=np.bool_)
    near[made] = True
    around = triangles[near[triangles].any(axis=1) & ~lost[triangles].any(axis=1)]
    if not len(made) or not len(around):
        return False
    typical = float(np.median(_sides(places, ints(around))))
    if _sides(places, ints(made)).max() > _LONGEST * typical:
        return False
    if smallest_angles(places, ints(made)).min() < _LEAST_ANGLE:
        return False
    some = hinges.at(own)
    i, j, k, m = (places[some[np.isfinite(places[some]).all(axis=(1, 2))][:, c]] for c in range(4))
    one, two = np.cross(j - i, k - i), np.cross(m - i, j - i)
    return bool((np.einsum("ij,ij->i", one, two) >= _UNFOLDED * lengths(one) * lengths(two)).all())


def _sides(places: FloatArray, triangles: IntArray) -> FloatArray:
    """Return the lengths of the sides of triangles, shape (m, 3)."""
    corners = places[triangles]
    return floats(lengths(corners - np.roll(corners, 1, axis=1)))
