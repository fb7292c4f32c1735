"""The rims of faults in small pieces, each with the way on which its fault would go on beyond it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graben.arrays import BoolArray, FloatArray, IntArray, floats, ints
from graben.complexes import Complex
from graben.surface import Surface, boundary_edges, chained, triangle_normals

#: A rim turns a corner where the chord behind or ahead of a place is this much longer than that around it.
_CORNER = 1.05
#: Most pieces that one edge of a rim is divided into.
_MOST_PIECES = 100


@dataclass(frozen=True, eq=False)
class RimLine:
    """The rim of one fault as refined where others cross it, one row for each edge.

    Parameters
    ----------
    ends : (e, 2, 3) array
        Ends of each edge, in the order of the way along the rim.
    outward : (e, 3) array
        Unit vector in the fault's own triangle, away from it; 0 where that triangle has no area.
    triangle, parent : (e,) arrays
        Its triangle in the complex and in the fault.
    chain : (e,) array
        Number of the connected piece of the rim.
    closed : (c,) array
        Which of those pieces are closed.
    """

    ends: FloatArray
    outward: FloatArray
    triangle: IntArray
    parent: IntArray
    chain: IntArray
    closed: BoolArray

    @property
    def lengths(self) -> FloatArray:
        """Length of each edge, model units."""
        return np.asarray(np.linalg.norm(self.ends[:, 1] - self.ends[:, 0], axis=1), dtype=np.float64)


@dataclass(frozen=True, eq=False)
class RimPieces:
    """The rim of one fault in pieces of about one length.

    Parameters
    ----------
    ends : (n, 2, 3) array
        Ends of each piece, in the order of the way along the rim.
    along, outward : (n, 3) arrays
        Unit vectors along the rim and, square to it, on the way the fault would go on; both smoothed over
        the window, but not around a corner. 0 where there is no such way.
    triangle, parent, chain : (n,) arrays
        As in :class:`RimLine`.
    closed : (c,) array
        As in :class:`RimLine`.
    """

    ends: FloatArray
    along: FloatArray
    outward: FloatArray
    triangle: IntArray
    parent: IntArray
    chain: IntArray
    closed: BoolArray

    @property
    def middles(self) -> FloatArray:
        """Middle of each piece, shape (n, 3), model units."""
        return np.asarray(self.ends.mean(axis=1), dtype=np.float64).reshape(-1, 3)

    @property
    def lengths(self) -> FloatArray:
        """Length of each piece, model units."""
        return np.asarray(np.linalg.norm(self.ends[:, 1] - self.ends[:, 0], axis=1), dtype=np.float64)


def rim_line(surface: Surface, network: Complex, owner: int) -> RimLine:
    """Return the rim of a surface, refined as in the complex that it is the ``owner``-th surface of."""
    mine = np.flatnonzero(network.owner == owner)
    triangles = network.triangles[mine]
    edges = boundary_edges(ints(triangles, -1, 3))
    chains = chained(edges)
    if not chains:
        nothing = ints([])
        return RimLine(floats([], 0, 2, 3), floats([], 0, 3), nothing, nothing, nothing, np.zeros(0, bool))
    pairs = np.concatenate([np.stack([c[:-1], c[1:]], axis=1) for c in chains])
    base = len(network.vertices)
    sides = np.sort(
        np.stack([np.roll(triangles, -1, axis=1), np.roll(triangles, -2, axis=1)], axis=2), axis=2
    )
    keys = (sides[:, :, 0] * base + sides[:, :, 1]).ravel()
    order = np.argsort(keys, kind="stable")
    wanted = np.sort(pairs, axis=1) @ np.array([base, 1])
    triangle = mine[order[np.searchsorted(keys[order], wanted)] // 3]
    parent = network.parent[triangle]
    ends = network.vertices[pairs]
    return RimLine(
        floats(ends),
        _outward(surface, parent, ends),
        ints(triangle),
        ints(parent),
        ints(np.repeat(np.arange(len(chains)), [len(c) - 1 for c in chains])),
        np.array([c[0] == c[-1] for c in chains]),
    )


def _outward(surface: Surface, parent: IntArray, ends: FloatArray) -> FloatArray:
    """Return the unit vectors out of the parents' planes' sides, square to edges given by their ends."""
    corners = surface.triangles[parent]
    normals = triangle_normals(surface.vertices, ints(corners, -1, 3))
    out = np.cross(ends[:, 1] - ends[:, 0], normals)
    away = ends.mean(axis=1) - surface.vertices[corners].mean(axis=1)
    out *= np.where(np.einsum("ij,ij->i", out, away) < 0, -1.0, 1.0)[:, None]
    return unit(out)


def unit(vectors: FloatArray) -> FloatArray:
    """Return vectors (n, 3) at length 1; 0 stays 0."""
    size = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(vectors / np.where(size > 0, size, 1.0), dtype=np.float64)


def rim_pieces(line: RimLine, spacing: float, window: float, fine: BoolArray) -> RimPieces:
    """Return a rim in pieces of about ``spacing``, with its directions smoothed over ``window``.

    Parameters
    ----------
    line : RimLine
        The rim.
    spacing, window : float
        Model units; without a spacing every edge is one piece.
    fine : (e,) array
        Which edges are divided; the others are one piece each.
    """
    lengths = line.lengths
    count = np.ones(len(lengths), dtype=int)
    if spacing > 0:
        count[fine] = np.clip(np.ceil(lengths[fine] / spacing), 1, _MOST_PIECES)
    edge = np.repeat(np.arange(len(count)), count)
    k = np.arange(len(edge)) - np.repeat(np.cumsum(count) - count, count)
    share = np.stack([k, k + 1], axis=1) / count[edge][:, None]
    ends = line.ends[edge][:, [0]] * (1 - share[..., None]) + line.ends[edge][:, [1]] * share[..., None]
    along, outward = np.zeros((len(edge), 3)), np.zeros((len(edge), 3))
    for chain, closed in enumerate(line.closed):
        rows = np.flatnonzero(line.chain == chain)
        mine = np.flatnonzero(line.chain[edge] == chain)
        begin = np.cumsum(lengths[rows]) - lengths[rows]
        at = begin[edge[mine] - rows[0]] + lengths[edge[mine]] * share[mine].mean(axis=1)
        along[mine], outward[mine] = _directions(line, rows, at, window, bool(closed))
    return RimPieces(
        floats(ends, -1, 2, 3),
        floats(along),
        floats(outward),
        ints(line.triangle[edge]),
        ints(line.parent[edge]),
        ints(line.chain[edge]),
        line.closed,
    )


def _directions(
    line: RimLine, rows: IntArray, at: FloatArray, window: float, closed: bool
) -> tuple[FloatArray, FloatArray]:
    """Return the directions along and out of one chain at arc lengths ``at``.

    Each is taken over twice the window: around the place, or behind or ahead of it where that way is
    straighter, so that a corner is not rounded off.
    """
    lengths = line.lengths[rows]
    s = np.concatenate([[0.0], np.cumsum(lengths)])
    nodes = np.concatenate([line.ends[rows, 0], line.ends[rows[-1:], 1]])
    summed = np.concatenate([np.zeros((1, 3)), np.cumsum(line.outward[rows] * lengths[:, None], axis=0)])
    w = min(window, s[-1] / 8)

    def value(table: FloatArray, x: FloatArray) -> FloatArray:
        turns = np.floor(x / s[-1]) if closed and s[-1] > 0 else np.zeros(len(x))
        inside = np.clip(x - turns * s[-1], 0.0, s[-1])
        columns = [np.interp(inside, s, table[:, c]) for c in range(3)]
        return floats(np.stack(columns, axis=1) + turns[:, None] * (table[-1] - table[0]))

    spans = np.array([[-w, w], [-2 * w, 0.0], [0.0, 2 * w]])
    chords = np.stack([value(nodes, at + b) - value(nodes, at + a) for a, b in spans])
    sizes = np.linalg.norm(chords, axis=2)
    sizes[0] *= _CORNER
    best = spans[np.argmax(sizes, axis=0)]
    start, stop = at + best[:, 0], at + best[:, 1]
    along = unit(value(nodes, stop) - value(nodes, start))
    out = value(summed, stop) - value(summed, start)
    return along, unit(out - np.einsum("ij,ij->i", out, along)[:, None] * along)
