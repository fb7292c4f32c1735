"""Cubic surfaces fitted to the nodes around places, many at a time.

Around each place p_0 the surface

    z = h + s (p - p_0) + 1/2 (p - p_0)^T K (p - p_0) + cubic terms

is fitted by weighted least squares, the weights (1 - r^2)^2 of the distance r in radii.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from graben.arrays import BoolArray, FloatArray, IntArray, bools, floats, ints
from graben.modeling.side_by_side import usable_cores, worked

#: Sums by the exponents of x and y.
_Sums = dict[tuple[int, int], FloatArray]

#: The order of a cubic, and its exponents of x and y: 1, the slope, K, the rest.
_ORDER = 3
_OF_K = slice(3, 6)
_POWERS = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3))
#: Nodes that a fit needs: twice its unknowns.
_LEAST_NODES = 2 * len(_POWERS)
#: Least eigenvalue of the normal equations, their diagonal 1: below it they are not solved.
_LEAST_EIGENVALUE = 1e-6
#: Most variance of a firm K, in radii, from a unit of noise in all the weight. Half a disc gives 25,000;
#: in a narrow wedge, or further from the nodes, K is extrapolated.
_MOST_VARIANCE = 35_000.0
#: Nodes along a radius that are enough: with more they are thinned.
_ENOUGH = 16
#: Fits that are made together: each has a thousand nodes at most.
_TOGETHER = 400
#: And so many of these, each a tenth of a second, take longer than a process to start.
_WORTH_A_PROCESS = 3.0


@dataclass(frozen=True, eq=False)
class Cubics:
    """Surfaces around the nodes ``centres`` (k,).

    ``height`` (k,), model units, ``slope`` (k, 2) and ``bend`` (k, 3), K_xx, K_xy and K_yy, one over model
    units: of each there. ``firm`` (k,): whether the nodes settle K well, so that little noise is in it.
    """

    centres: IntArray
    height: FloatArray
    slope: FloatArray
    bend: FloatArray
    firm: BoolArray


@dataclass(frozen=True, eq=False)
class Nodes:
    """The nodes of a cut mesh, those that fits may use, and how far all are from the cut.

    Parameters
    ----------
    points : (n, 3) array
        Model units.
    labels : (n,) array
        Subdomain of each, -1 for none.
    away : (n,) array
        Plan distance from the cut, model units. No line between two nodes that is shorter than the sum of
        theirs meets the cut.
    used : (m,) array
        Those that fits use.
    sheet : (n, 3) array
        Their places with the subdomains one above the other, further apart than any fit reaches.
    """

    points: FloatArray
    labels: IntArray
    away: FloatArray
    used: IntArray
    sheet: FloatArray

    @staticmethod
    def of(
        points: FloatArray, labels: IntArray, away: FloatArray, reliable: BoolArray, radius: float
    ) -> Nodes:
        """Return the nodes (n, 3) of subdomains (n,), so far ``away`` (n,), of which some are reliable (n,).

        ``radius``: of the widest fit, model units.
        """
        sheet = np.column_stack([points[:, :2], 4.0 * radius * labels])
        used = np.flatnonzero(reliable & np.isfinite(away))
        used = used[_one_a_cell(sheet[used], radius / _ENOUGH)]
        return Nodes(points, labels, away, used, sheet)

    def fitted(self, centres: IntArray, radius: FloatArray, least: FloatArray) -> Cubics:
        """Return the surfaces around some nodes (k,) that the nodes around them settle.

        ``radius`` (k,), and the ``least`` distance from the cut (k,) of the nodes to use, model units.
        """
        together = [slice(k, k + _TOGETHER) for k in range(0, max(len(centres), 1), _TOGETHER)]
        parts = worked(
            lambda k: self._fitted(centres[together[k]], radius[together[k]], least[together[k]]),
            [1.0] * len(together),
            usable_cores(),
            _WORTH_A_PROCESS,
        )
        return Cubics(
            ints(np.concatenate([p.centres for p in parts])),
            floats(np.concatenate([p.height for p in parts])),
            floats(np.concatenate([p.slope for p in parts])),
            floats(np.concatenate([p.bend for p in parts])),
            bools(np.concatenate([p.firm for p in parts])),
        )

    def _fitted(self, centres: IntArray, radius: FloatArray, least: FloatArray) -> Cubics:
        owner, node, way = self.around(self.used, centres, radius)
        use = self.away[node] >= least[owner]
        owner, node, way = owner[use], node[use], way[use] / radius[owner[use], None]
        weight = (1.0 - np.minimum((way**2).sum(axis=1), 1.0)) ** 2
        rise = self.points[node, 2] - self.points[centres[owner], 2]
        moments, loads = _moments(owner, way, weight, rise, len(centres))
        rows = [np.stack([moments[a + c, b + d] for c, d in _POWERS], axis=1) for a, b in _POWERS]
        normal = np.stack(rows, axis=1)
        load = np.stack([loads[p] for p in _POWERS], axis=1)
        found, settled, firm = _solved(normal, load, np.bincount(owner, minlength=len(centres)))
        kept, radius = centres[settled], radius[settled, None]
        return Cubics(
            kept,
            floats(self.points[kept, 2] + found[:, 0]),
            floats(found[:, 1:3] / radius),
            floats(found[:, _OF_K] * [2.0, 1.0, 2.0] / radius**2),
            firm,
        )

    def around(
        self, nodes: IntArray, centres: IntArray, radius: FloatArray
    ) -> tuple[IntArray, IntArray, FloatArray]:
        """Return pairs of a centre and a node near it with no cut between them.

        ``nodes`` (m,) and ``centres`` (k,) of which ones, ``radius`` (k,) how near. Of each pair: the
        position in ``centres``, the node, and the way to it, (p, 2), model units.
        """
        if len(nodes) == 0 or len(centres) == 0:
            return ints([]), ints([]), np.zeros((0, 2))
        near = cKDTree(self.sheet[nodes]).query_ball_point(self.sheet[centres], radius)
        owner = np.repeat(np.arange(len(centres)), [len(n) for n in near])
        node = nodes[np.concatenate([np.asarray(n, dtype=np.int64) for n in near])]
        way = self.points[node, :2] - self.points[centres[owner], :2]
        seen = np.hypot(way[:, 0], way[:, 1]) < self.away[node] + self.away[centres[owner]]
        return ints(owner[seen]), ints(node[seen]), way[seen]

    def between(self, fits: Cubics, nodes: IntArray, count: int, soft: float) -> FloatArray:
        """Return K at some nodes (k,) from that many fits nearest to each, (k, 3); 0 without any."""
        away, at = cKDTree(self.sheet[fits.centres]).query(self.sheet[nodes], k=range(1, count + 1))
        there = at < len(fits.centres)
        at = np.where(there, at, 0)
        seen = there & (away < self.away[nodes, None] + self.away[fits.centres][at])
        weight = np.where(seen, 1.0 / (np.where(seen, away, 1.0) + soft) ** 2, 0.0)
        total = weight.sum(axis=1)
        weight /= np.where(total > 0, total, 1.0)[:, None]
        return np.asarray((weight[:, :, None] * fits.bend[at]).sum(axis=1))


def quadratic(bend: FloatArray, way: FloatArray) -> FloatArray:
    """Return 1/2 w^T K w, (...), for K_xx, K_xy, K_yy (..., 3) and w (..., 2)."""
    x, y = way[..., 0], way[..., 1]
    return np.asarray(0.5 * (bend[..., 0] * x * x + bend[..., 2] * y * y) + bend[..., 1] * x * y)


def thinned(places: FloatArray, gap: float) -> IntArray:
    """Return which of some places (k, 2) to keep, so that none is nearer to another than a gap."""
    order = np.lexsort(places.T)
    near = cKDTree(places).query_ball_point(places, gap) if len(places) else []
    free = np.ones(len(places), dtype=bool)
    kept = []
    for k in order:
        if free[k]:
            kept.append(k)
            free[near[k]] = False
    return ints(np.sort(kept))


def _one_a_cell(sheet: FloatArray, size: float) -> IntArray:
    """Return one of the places (k, 3) in each cell of a grid, that nearest to its middle, (c,)."""
    cell = np.floor(sheet / size)
    off = ((sheet - (cell + 0.5) * size)[:, :2] ** 2).sum(axis=1)
    order = np.lexsort((off, *cell.T))
    first = np.ones(len(order), dtype=bool)
    first[1:] = (np.diff(cell[order], axis=0) != 0).any(axis=1)
    return ints(np.sort(order[first]))


def _moments(
    owner: IntArray, way: FloatArray, weight: FloatArray, rise: FloatArray, count: int
) -> tuple[_Sums, _Sums]:
    """Return the sums of w x^a y^b up to the order of a cubic's square, and of w x^a y^b z up to its own.

    Of each owner, (count,); products of terms with the same powers are the same sum.
    """
    moments: _Sums = {}
    loads: _Sums = {}
    along = weight
    for a in range(2 * _ORDER + 1):
        term = along
        for b in range(2 * _ORDER + 1 - a):
            moments[a, b] = floats(np.bincount(owner, term, minlength=count))
            if a + b <= _ORDER:
                loads[a, b] = floats(np.bincount(owner, term * rise, minlength=count))
            term = term * way[:, 1]
        along = along * way[:, 0]
    return moments, loads


def _solved(
    normal: FloatArray, load: FloatArray, counts: IntArray
) -> tuple[FloatArray, BoolArray, BoolArray]:
    """Return solutions (s, 10) of normal equations (k, 10, 10), which have one, (k,), and firm K, (s,)."""
    total = normal[:, 0, 0]
    scale = np.sqrt(np.einsum("fii->fi", normal))
    enough = (counts >= _LEAST_NODES) & (scale > 0).all(axis=1)
    scale = np.where(scale > 0, scale, 1.0)
    normal = normal / scale[:, :, None] / scale[:, None, :]
    settled = enough & (np.linalg.eigvalsh(normal)[:, 0] > _LEAST_EIGENVALUE)
    inverse = np.linalg.inv(normal[settled]) / scale[settled][:, :, None] / scale[settled][:, None, :]
    variance = np.einsum("fii->fi", inverse)[:, _OF_K].max(axis=1, initial=0.0)
    found = (inverse @ load[settled][:, :, None])[:, :, 0]
    return floats(found), bools(settled), bools(variance * total[settled] < _MOST_VARIANCE)
