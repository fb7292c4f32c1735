"""The tables of a complex of several surfaces that its improvement works on, made anew for each pass."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from graben.arrays import BoolArray, FloatArray, IntArray
from graben.surface import edge_table

#: A line that turns by more than this at a vertex has a corner there, which stays: degrees.
CORNER = 35.0
#: Odd 64-bit numbers that make the number of an owner a hash (the constants of splitmix64).
_HASH = (np.uint64(0x9E3779B97F4A7C15), np.uint64(0xBF58476D1CE4E5B9))

FREE, CURVE, FIXED = 0, 1, 2


@dataclass(frozen=True, eq=False)
class Net:
    """Surfaces of one complex, while they are worked on.

    Parameters
    ----------
    vertices : (n, 3) array
        Model units.
    triangles : (m, 3) array
        Vertex indices.
    owner : (m,) array
        The surface of each triangle.
    normals : (m, 3) array
        Unit normal of the triangle of the input that each is a part of.
    fresh : (m,) array
        Which triangles are new and may be worked on.
    meeting : (surfaces, surfaces) array
        Which surfaces meet: others must not come to share a vertex.
    """

    vertices: FloatArray
    triangles: IntArray
    owner: IntArray
    normals: FloatArray
    fresh: BoolArray
    meeting: BoolArray


def taken(net: Net, rows: IntArray | BoolArray) -> Net:
    """Return some triangles of a net; the vertices are all there."""
    return replace(
        net,
        triangles=net.triangles[rows],
        owner=net.owner[rows],
        normals=net.normals[rows],
        fresh=net.fresh[rows],
    )


def put_together(rest: Net, part: Net) -> Net:
    """Return two parts of a net as one; the vertices are those of both."""
    rows = ("triangles", "owner", "normals", "fresh")
    return replace(rest, **{k: np.concatenate([getattr(rest, k), getattr(part, k)]) for k in rows})


class Tables:
    """What a pass asks of a net: its edges, the lines that must stay, the triangles around each vertex.

    Lines that must stay are rims (one triangle of an owner) and branch lines (several owners). A vertex on
    none is free; one in the course of one line is on a curve; where lines end, meet or turn it is fixed.

    Parameters
    ----------
    net : Net
        The complex.
    short : float
        Length below which an edge has no direction that counts for a corner, model units.
    """

    def __init__(self, net: Net, short: float) -> None:
        self.net = net
        self._short = short
        self.edges, self.sides = edge_table(net.triangles)
        self.count = len(net.vertices)
        self.keys = self.edges[:, 0] * self.count + self.edges[:, 1]
        self.lengths = np.linalg.norm(np.diff(net.vertices[self.edges], axis=1)[:, 0], axis=1)

    @cached_property
    def sharing(self) -> IntArray:
        """How many triangles each edge has, shape (e,)."""
        return np.bincount(self.sides.ravel(), minlength=len(self.edges))

    @cached_property
    def signature(self) -> IntArray:
        """A number for the owners of an edge's triangles, each as often as it occurs, shape (e,)."""
        number = (self.net.owner.astype(np.uint64) + np.uint64(1)) * _HASH[0]
        number = (number ^ (number >> np.uint64(29))) * _HASH[1]
        total = np.zeros(len(self.edges), dtype=np.uint64)
        with np.errstate(over="ignore"):
            np.add.at(total, self.sides.ravel(), np.repeat(number, 3))
        return total.view(np.int64)

    @cached_property
    def held(self) -> BoolArray:
        """Which edges lie on a rim or a branch line, shape (e,)."""
        sides, owner = self.sides.ravel(), np.repeat(self.net.owner, 3)
        low = np.full(len(self.edges), np.iinfo(np.int64).max)
        high = np.full(len(self.edges), -1)
        np.minimum.at(low, sides, owner)
        np.maximum.at(high, sides, owner)
        return np.asarray((self.sharing != 2) | (low != high), dtype=np.bool_)

    @cached_property
    def kind(self) -> IntArray:
        """FREE, CURVE or FIXED for each vertex, shape (n,)."""
        rows = np.flatnonzero(self.held)
        ends = self.edges[rows]
        degree = np.bincount(ends.ravel(), minlength=self.count)
        low = np.full(self.count, np.iinfo(np.int64).max)
        high = np.full(self.count, np.iinfo(np.int64).min)
        for k in (0, 1):
            np.minimum.at(low, ends[:, k], self.signature[rows])
            np.maximum.at(high, ends[:, k], self.signature[rows])
        way = np.diff(self.net.vertices[ends], axis=1)[:, 0]
        way /= np.maximum(self.lengths[rows], np.finfo(float).tiny)[:, None]
        bend = np.zeros((self.count, 3))
        np.add.at(bend, ends[:, 0], way)
        np.add.at(bend, ends[:, 1], -way)
        clear = np.ones(self.count, dtype=bool)
        clear[ends[self.lengths[rows] < self._short].ravel()] = False
        turns = clear & (np.linalg.norm(bend, axis=1) > 2.0 * np.sin(np.radians(CORNER) / 2.0))
        kind = np.where(degree == 0, FREE, FIXED)
        kind[(degree == 2) & (low == high) & ~turns] = CURVE
        return kind

    @cached_property
    def around(self) -> tuple[IntArray, IntArray]:
        """The triangles around each vertex: ``rows[starts[v]:starts[v + 1]]``."""
        flat = self.net.triangles.ravel()
        order = np.argsort(flat, kind="stable")
        return order // 3, np.searchsorted(flat[order], np.arange(self.count + 1))

    @cached_property
    def beneath(self) -> tuple[IntArray, IntArray]:
        """The triangles at each edge: ``rows[starts[e]:starts[e + 1]]``."""
        position, starts = self.corners_at
        return position // 3, starts

    @cached_property
    def corners_at(self) -> tuple[IntArray, IntArray]:
        """The corners opposite to each edge, as 3 times the triangle and the corner, as in ``beneath``."""
        flat = self.sides.ravel()
        order = np.argsort(flat, kind="stable")
        return order, np.searchsorted(flat[order], np.arange(len(self.edges) + 1))

    def star(self, vertices: IntArray) -> tuple[IntArray, IntArray]:
        """Return the triangles around some vertices: for each the position in ``vertices``, and itself."""
        rows, starts = self.around
        return expanded(rows, starts, vertices)

    @cached_property
    def beside(self) -> tuple[IntArray, IntArray]:
        """The neighbours of each vertex, ascending: ``others[starts[v]:starts[v + 1]]``."""
        both = np.concatenate([self.edges, self.edges[:, ::-1]])
        order = np.lexsort((both[:, 1], both[:, 0]))
        return both[order, 1], np.searchsorted(both[order, 0], np.arange(self.count + 1))

    @cached_property
    def owners(self) -> tuple[IntArray, IntArray]:
        """The surfaces that each vertex belongs to: ``owners[starts[v]:starts[v + 1]]``."""
        count = int(self.net.owner.max(initial=0)) + 1
        keys = np.unique(self.net.triangles * count + self.net.owner[:, None])
        return keys % count, np.searchsorted(keys // count, np.arange(self.count + 1))

    def bring_together(self, a: IntArray, b: IntArray) -> BoolArray:
        """Return which pairs of vertices, made one, would join surfaces that do not meet."""
        owners, starts = self.owners
        row, first = expanded(owners, starts, a)
        pair, second = expanded(owners, starts, b[row])
        apart = ~self.net.meeting[first[pair], second]
        return np.asarray(np.bincount(row[pair[apart]], minlength=len(a)) > 0, dtype=np.bool_)

    def edge(self, a: IntArray, b: IntArray) -> IntArray:
        """Return the edge between vertices, -1 where there is none, shape as ``a``."""
        key = np.minimum(a, b) * self.count + np.maximum(a, b)
        at = np.minimum(np.searchsorted(self.keys, key), max(len(self.keys) - 1, 0))
        return np.where(self.keys[at] == key, at, -1)

    def common(self, a: IntArray, b: IntArray) -> IntArray:
        """Return how many neighbours the vertices of each pair have in common, shape as ``a``."""
        others, starts = self.beside
        pair, other = expanded(others, starts, a)
        return np.bincount(pair[self.edge(b[pair], other) >= 0], minlength=len(a))


def expanded(values: IntArray, starts: IntArray, rows: IntArray) -> tuple[IntArray, IntArray]:
    """Return the values of some rows of a table one after another, each with the position of its row."""
    size = starts[rows + 1] - starts[rows]
    row = np.repeat(np.arange(len(rows)), size)
    step = np.arange(len(row)) - np.repeat(np.cumsum(size) - size, size)
    return row, values[np.repeat(starts[rows], size) + step]


def angles(points: FloatArray) -> FloatArray:
    """Return the angles at the corners of triangles, shape (m, 3), degrees.

    Parameters
    ----------
    points : (m, 3, 3) array
        The corners of each.
    """
    ahead, behind = np.roll(points, -1, axis=1) - points, np.roll(points, 1, axis=1) - points
    across = np.linalg.norm(np.cross(ahead, behind), axis=2)
    turned = np.arctan2(across, np.einsum("ijk,ijk->ij", ahead, behind))
    return np.asarray(np.degrees(turned), dtype=np.float64)


def independent(size: int, candidate: IntArray, claimed: IntArray, count: int) -> BoolArray:
    """Return which candidates win all that they claim, the first in order going first, shape (size,).

    Parameters
    ----------
    size : int
        Number of candidates, in the order of their priority.
    candidate, claimed : (k,) arrays
        Each claim: whose it is and what.
    count : int
        Number of things that can be claimed.
    """
    best = np.full(count, size)
    np.minimum.at(best, claimed, candidate)
    lost = np.bincount(candidate[best[claimed] != candidate], minlength=size)
    return np.asarray(lost == 0, dtype=np.bool_)
