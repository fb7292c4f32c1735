"""Guides: the lines in space along which the nodes of the cut move (paper Sect. 6, Table 1).

Whatever the type of a node, it moves along a line on its fault: the rim of the fault, its intersection
with another fault or with the outer boundary, or, inside a sub-edge, the section of the fault by the
vertical plane through the node along its direction v(t). Each is followed from the node upwards and
downwards as long as the elevation changes one way; the node's place at elevation z is then unique.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graben.arrays import BoolArray, FloatArray, IntArray, floats
from graben.compiled import compiled
from graben.proximity import nearest
from graben.surface import Surface, edge_sharing, edge_table

#: Elevation steps below this share of the size of the surface are rounding, not dip.
_FLAT = 1e-12
#: Parts of a section shorter than this share of the size of the surface lie around a vertex and are passed.
_SHORT = 1e-10
#: Distance, as a share of the size of the surface, at which the triangle of a point is looked up.
_AHEAD = 1e-7


@dataclass(frozen=True, eq=False)
class Guides:
    """Lines of growing elevation, one for each node.

    Parameters
    ----------
    lines : (n, k, 3) array
        x, y, elevation; each line is padded at its end with its last point.
    """

    lines: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "lines", floats(self.lines))

    @staticmethod
    def of(lines: list[FloatArray]) -> Guides:
        """Return guides of polylines of any number of points, shape (k_i, 3) each, elevation growing."""
        most = max((len(line) for line in lines), default=1)
        padded = [np.concatenate([line, np.repeat(line[-1:], most - len(line), axis=0)]) for line in lines]
        return Guides(np.array(padded).reshape(len(lines), most, 3))

    @property
    def low(self) -> FloatArray:
        """The lowest elevation of each guide, shape (n,)."""
        return self.lines[:, 0, 2]

    @property
    def high(self) -> FloatArray:
        """The highest elevation of each guide, shape (n,)."""
        return self.lines[:, -1, 2]

    def clipped(self, z: FloatArray) -> FloatArray:
        """Return elevations brought into the range of the guides, shape (n,)."""
        return np.clip(z, self.low, self.high)

    def excess(self, z: FloatArray) -> FloatArray:
        """Return by how much each elevation lies beyond its guide, shape (n,): positive above it."""
        return np.asarray(z - self.clipped(z), dtype=np.float64)

    def places(self, z: FloatArray) -> FloatArray:
        """Return the plan position of each node at elevation z, shape (n, 2); clipped at the ends."""
        return self._followed(z)[:, :2]

    def tangents(self, upper: bool) -> FloatArray:
        """Return the direction of each guide at its upper or lower end, per unit of elevation, shape (n, 3).

        Zero for a guide that is one point.
        """
        levels = self.lines[:, :, 2]
        end = levels[:, -1:] if upper else levels[:, :1]
        # The last point that is lower than the end, or the first that is higher.
        k = (levels < end).sum(axis=1) - 1 if upper else (levels <= end).sum(axis=1)
        rows = np.arange(len(levels))
        other = self.lines[rows, np.clip(k, 0, levels.shape[1] - 1)]
        way = self.lines[:, -1 if upper else 0] - other
        rise = np.where(way[:, 2] == 0, 1.0, way[:, 2])
        return np.where(way[:, 2:] == 0, 0.0, way / rise[:, None])

    def continued(self, by: float) -> Guides:
        """Return the guides going straight on at both ends by so much elevation, model units."""
        above = self.lines[:, -1] + by * self.tangents(upper=True)
        below = self.lines[:, 0] - by * self.tangents(upper=False)
        return Guides(np.concatenate([below[:, None], self.lines, above[:, None]], axis=1))

    def rates(self, z: FloatArray) -> FloatArray:
        """Return how far each guide goes in plan per unit of elevation around elevation z, shape (n, 2).

        Zero for a guide that is one point.
        """
        return self._followed(z)[:, 2:]

    def _followed(self, z: FloatArray) -> FloatArray:
        """Return x and y at elevation z, and how far they go per unit of elevation, shape (n, 4)."""
        result = np.empty((len(self.lines), 4))
        _follow(self.lines, np.array(z, dtype=np.float64), result)
        return result


@compiled
def _follow(lines: FloatArray, z: FloatArray, result: FloatArray) -> None:
    """Write what :meth:`Guides._followed` returns."""
    last = lines.shape[1] - 1
    for n in range(len(lines)):
        line = lines[n]
        level = min(max(z[n], line[0, 2]), line[last, 2])
        k = 0
        while k < last - 1 and line[k + 1, 2] <= level:
            k += 1
        # At the upper end the part below it: where a line is padded, the last parts have no height.
        while k > 0 and line[k + 1, 2] <= line[k, 2]:
            k -= 1
        end = min(k + 1, last)
        rise = line[end, 2] - line[k, 2]
        share = (level - line[k, 2]) / rise if rise > 0.0 else 0.0
        for c in range(2):
            way = line[end, c] - line[k, c]
            result[n, c] = line[k, c] + share * way
            result[n, 2 + c] = way / rise if rise > 0.0 else 0.0


def branch(line: FloatArray, point: FloatArray, scale: float) -> FloatArray:
    """Return the part of a polyline around a point in which the elevation grows one way, shape (k, 3).

    Parameters
    ----------
    line : (m, 3) array
        A polyline; a closed one repeats its first point.
    point : (3,) array
        A point on it; of one beside it, as where three faults nearly meet in a point, its place on the line.
    scale : float
        Size of the surface, model units, against which rounding is judged.
    """
    a, b = line[:-1], line[1:]
    way = b - a
    share = ((point - a) * way).sum(axis=1) / np.maximum((way**2).sum(axis=1), np.finfo(float).tiny)
    share = np.clip(share, 0.0, 1.0)
    near = a + share[:, None] * way
    k = int(np.argmin(((near - point) ** 2).sum(axis=1)))
    point = near[k]
    closed = bool((line[0] == line[-1]).all())
    ahead = np.concatenate([line[k + 1 :], line[1 : k + 1]]) if closed else line[k + 1 :]
    behind = np.concatenate([line[k::-1], line[-2:k:-1]]) if closed else line[k::-1]
    runs = [_monotone(np.concatenate([point[None], part]), scale) for part in (ahead, behind)]
    up = max(runs, key=lambda run: run[-1, 2])
    down = min(runs, key=lambda run: run[-1, 2])
    rising = up if up[-1, 2] > point[2] else point[None]
    falling = down if down[-1, 2] < point[2] else point[None]
    return np.concatenate([falling[:0:-1], rising])


def _monotone(run: FloatArray, scale: float) -> FloatArray:
    """Return the start of a polyline in which the elevation changes one way, points in place left out."""
    apart = np.concatenate([[True], np.linalg.norm(np.diff(run, axis=0), axis=1) > _FLAT * scale])
    run = run[apart]
    rise = np.diff(run[:, 2])
    if len(rise) == 0:
        return run
    good = rise * np.sign(rise[0]) > _FLAT * scale
    end = len(rise) if good.all() else int(np.argmin(good))
    return run[: end + 1]


def sections(
    fault: Surface, points: FloatArray, directions: FloatArray, slants: FloatArray | None = None
) -> list[FloatArray]:
    """Return for each point the section of a fault by a plane along a direction in plan.

    The section is followed from triangle to triangle from the point on, up and down, as long as the
    elevation changes one way: vertical, overturned and listric faults need nothing else.

    Parameters
    ----------
    fault : Surface
        The fault.
    points : (n, 3) array
        On the fault, to rounding.
    directions : (n, 2) array
        Unit vectors in plan.
    slants : (n,) array, optional
        How far the plane leans to the left of the direction per unit of elevation; default 0, vertical.

    Returns
    -------
    list of (k, 3) arrays
        Polylines of growing elevation that pass through the points.
    """
    vertices, triangles = fault.vertices, fault.triangles
    scale = float(np.ptp(vertices, axis=0).max())
    slants = np.zeros(len(points)) if slants is None else slants
    left = np.column_stack([-directions[:, 1], directions[:, 0]])
    planes = np.column_stack([left, -slants])
    # A little up the section, so that a point on a corner finds the triangle that the section runs through.
    ahead = np.column_stack([directions + slants[:, None] * left, np.ones(len(points))])
    start = nearest(points + _AHEAD * scale * ahead, vertices, triangles).simplex
    start = _crossed_start(vertices, triangles, start, points, planes)
    neighbours = _neighbours(triangles)
    up = _walked(vertices, triangles, neighbours, start, points, planes, 1.0, scale)
    down = _walked(vertices, triangles, neighbours, start, points, planes, -1.0, scale)
    return [
        np.concatenate([np.array(d[::-1]).reshape(-1, 3), p[None], np.array(u).reshape(-1, 3)])
        for d, p, u in zip(down, points, up, strict=True)
    ]


def _neighbours(triangles: IntArray) -> IntArray:
    """Return the triangle across each side, shape (m, 3); -1 at the rim and at non-manifold edges."""
    edges, sides = edge_table(triangles)
    flat = sides.ravel()
    order = np.argsort(flat, kind="stable")
    sharing = edge_sharing(sides, len(edges))
    first = np.concatenate([[0], np.cumsum(sharing)])[:-1]
    two = np.flatnonzero(sharing == 2)
    a, b = order[first[two]], order[first[two] + 1]
    result = np.full(3 * len(triangles), -1, dtype=np.int64)
    result[a], result[b] = b // 3, a // 3
    return result.reshape(-1, 3)


def _offsets(vertices: FloatArray, corners: IntArray, points: FloatArray, planes: FloatArray) -> FloatArray:
    """Return how far triangle corners lie from planes through points, shape (n, 3).

    ``planes`` (n, 3) are their normals, of length 1 in plan.
    """
    return np.asarray(((vertices[corners] - points[:, None]) * planes[:, None]).sum(axis=2))


def _mixed(offsets: FloatArray) -> BoolArray:
    """Return in which triangles the plane separates corners; a corner on the plane counts as left of it."""
    left = offsets >= 0
    return np.asarray(left.any(axis=1) & ~left.all(axis=1), dtype=bool)


def _crossed_start(
    vertices: FloatArray, triangles: IntArray, start: IntArray, points: FloatArray, planes: FloatArray
) -> IntArray:
    """Return start triangles that the plane really crosses: the nearest such for those it only touches."""
    start = start.copy()
    lost = np.flatnonzero(~_mixed(_offsets(vertices, triangles[start], points, planes)))
    for n in lost:
        rows = np.full(len(triangles), n)
        mixed = np.flatnonzero(_mixed(_offsets(vertices, triangles, points[rows], planes[rows])))
        if len(mixed):
            start[n] = mixed[nearest(points[n : n + 1], vertices, triangles[mixed]).simplex[0]]
    return start


def _crossings(
    vertices: FloatArray, corners: IntArray, points: FloatArray, planes: FloatArray
) -> tuple[FloatArray, IntArray]:
    """Return the two points in which each plane leaves its triangle, (n, 2, 3), and their sides, (n, 2)."""
    offsets = _offsets(vertices, corners, points, planes)
    left = offsets >= 0
    lone = np.argmax(left == (left.sum(axis=1) == 1)[:, None], axis=1)
    rows = np.arange(len(corners))
    crossed, sides = [], []
    for other in (1, 2):
        k = (lone + other) % 3
        f0, f1 = offsets[rows, lone], offsets[rows, k]
        share = f0 / np.where(f0 == f1, 1.0, f0 - f1)
        a, b = vertices[corners[rows, lone]], vertices[corners[rows, k]]
        crossed.append(a + share[:, None] * (b - a))
        sides.append((lone + 3 - other) % 3)
    return np.stack(crossed, axis=1), np.stack(sides, axis=1)


def _walked(
    vertices: FloatArray,
    triangles: IntArray,
    neighbours: IntArray,
    start: IntArray,
    points: FloatArray,
    planes: FloatArray,
    sign: float,
    scale: float,
) -> list[list[FloatArray]]:
    """Return the corners of each section above (sign 1) or below (-1) its point, walked all at once."""
    lines: list[list[FloatArray]] = [[] for _ in points]
    active = np.flatnonzero(_mixed(_offsets(vertices, triangles[start], points, planes)))
    current, entered = start[active], np.full(len(active), -1)
    level = sign * points[active, 2]
    # A section visits each triangle at most once; the bound only guards against a damaged surface.
    for _ in range(len(triangles) + 1):
        if len(active) == 0:
            break
        crossed, sides = _crossings(vertices, triangles[current], points[active], planes[active])
        height = sign * crossed[:, :, 2]
        pick = np.where(entered < 0, np.argmax(height, axis=1), np.where(sides[:, 0] == entered, 1, 0))
        rows = np.arange(len(active))
        point, side, top = crossed[rows, pick], sides[rows, pick], height[rows, pick]
        # The start triangle may lie a little beyond the point: what is passed on the way to it is left out.
        climbs = top > height[rows, 1 - pick] + _FLAT * scale
        in_place = np.linalg.norm(point - crossed[rows, 1 - pick], axis=1) <= _SHORT * scale
        beyond = climbs & (top > level + _FLAT * scale)
        for n, p in zip(active[beyond], point[beyond], strict=True):
            lines[n].append(p)
        following = neighbours[current, side]
        on = (climbs | in_place) & (following >= 0)
        here = current[on]
        active, level, current = active[on], np.maximum(level, top)[on], following[on]
        entered = np.argmax(neighbours[current] == here[:, None], axis=1)
    return lines
