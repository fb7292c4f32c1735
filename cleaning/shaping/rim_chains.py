"""Chains of vertices along the rim of a fault, and the ways on which the fault would go on beyond them."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from graben.arrays import BoolArray, FloatArray, IntArray, floats, ints
from graben.errors import GrabenError
from graben.proximity import nearest
from graben.surface import Surface, boundary_edges, triangle_normals
from graben.validators.measuring.rim_lines import unit

#: A rim that turns more than this within a window has a corner there, degrees.
CORNER = 40.0
#: Most that the side of an extension leans from square to the rim, as a tangent: 50 degrees.
_LEAN = 1.2
#: A rim that comes to the end of a chain at more than this off the way on is no side that goes on, degrees.
_SIDE = 60.0
#: Least 1 + cos of the angle between the ways on at a corner: a sharper one is blunted at 120 degrees.
_BLUNT = 0.5
#: Most that a way leans along the rim towards a corner, as a tangent.
_MITER = 2.0
#: Least cosine between the normals of one sheet of a fault within a window.
SHEET = 0.3
#: An edge of which a stretch covers more than this share is part of the stretch.
_COVERED = 0.5


def rim_chain(surface: Surface, start: int, stop: int) -> IntArray:
    """Return the rim vertices from one to another, both included, as the rim's triangles turn.

    Parameters
    ----------
    surface : Surface
        The fault.
    start, stop : int
        Vertices on one rim; where they are one and the same, the chain is the closed rim.

    Returns
    -------
    (k,) array
        Vertex indices.

    Raises
    ------
    GrabenError
        If they lie on no common rim, or the rim branches between them.
    """
    onward = _onward(surface)
    chain = [int(start)]
    while len(chain) == 1 or chain[-1] != stop:
        after = onward.get(chain[-1], -1)
        if after < 0 or len(chain) > len(onward) + 1:
            raise GrabenError(f"{surface.name}: no rim leads from vertex {start} to vertex {stop}.")
        chain.append(after)
    return ints(chain)


def stretch_chain(surface: Surface, path: FloatArray, tolerance: float) -> IntArray:
    """Return the chain of rim vertices along a stretch of the rim.

    An edge that the stretch covers by half belongs to it, and a last one of less than that where it ends at a
    corner: a stretch that covers a side but for a fraction of an edge is the side.

    Parameters
    ----------
    surface : Surface
        The fault.
    path : (k, 3) array
        The stretch as points along the rim, model units.
    tolerance : float
        Within which a point of the rim lies on the stretch, model units.

    Returns
    -------
    (k,) array
        Vertex indices as the rim's triangles turn, first = last for a whole rim; empty without an edge.
    """
    edges = boundary_edges(surface.triangles)
    if not len(edges) or len(path) < 2:
        return ints([])
    parts = 8
    share = (np.arange(parts) + 0.5) / parts
    a, b = surface.vertices[edges[:, 0]], surface.vertices[edges[:, 1]]
    points = a[:, None] + share[None, :, None] * (b - a)[:, None]
    links = np.stack([np.arange(len(path) - 1), np.arange(1, len(path))], axis=1)
    near = nearest(points.reshape(-1, 3), path, ints(links)).distance.reshape(-1, parts) <= tolerance
    part = near.mean(axis=1)
    covered = part >= _COVERED
    if not covered.any():
        return ints([])
    onward, before = _onward(surface), {b: a for a, b in _onward(surface).items()}
    some = {(int(p), int(q)): float(c) for (p, q), c in zip(edges, part, strict=True)}
    chain = _longest(edges[covered], surface.vertices)
    if chain[0] == chain[-1]:
        return ints(chain)
    corner = _corner_vertices(surface, edges)
    after, back = onward.get(chain[-1], -1), before.get(chain[0], -1)
    if after >= 0 and some[chain[-1], after] > 0 and corner[after] and not corner[chain[-1]]:
        chain = [*chain, after]
    if back >= 0 and some[back, chain[0]] > 0 and corner[back] and not corner[chain[0]]:
        chain = [back, *chain]
    return ints(chain)


def _longest(edges: IntArray, vertices: FloatArray) -> list[int]:
    """Return the longest chain that directed edges form; the first of equal ones."""
    onward = dict(edges.tolist())
    starts = sorted(set(onward) - set(onward.values()))
    chains, used = [], set()
    for start in [*starts, *sorted(onward)]:
        if start in used:
            continue
        chain = [start]
        while chain[-1] in onward and chain[-1] not in used:
            used.add(chain[-1])
            chain.append(onward[chain[-1]])
        chains.append(chain)
    return max(chains, key=lambda c: float(np.linalg.norm(np.diff(vertices[c], axis=0), axis=1).sum()))


def _corner_vertices(surface: Surface, edges: IntArray) -> BoolArray:
    """Return which vertices of a surface are corners of its rim, edge by edge."""
    way = np.zeros((2, len(surface.vertices), 3))
    along = unit(surface.vertices[edges[:, 1]] - surface.vertices[edges[:, 0]])
    way[0, edges[:, 1]], way[1, edges[:, 0]] = along, along
    turn = np.einsum("ij,ij->i", way[0], way[1]) < np.cos(np.radians(CORNER))
    return np.asarray(turn & way.any(axis=2).all(axis=0), dtype=np.bool_)


def _onward(surface: Surface) -> dict[int, int]:
    """Return the next vertex along the rim from each; vertices where the rim branches have none."""
    edges = boundary_edges(surface.triangles)
    once = np.bincount(edges[:, 0], minlength=len(surface.vertices)) == 1
    return dict(edges[once[edges[:, 0]]].tolist())


@dataclass(frozen=True, eq=False)
class Ways:
    """How a fault goes on beyond a chain of its rim, one row a vertex of the chain.

    Parameters
    ----------
    way : (k, 3) array
        Along the fault's tangent plane, out of it; its part square to the rim has length 1.
    normal : (k, 3) array
        Unit normal of the fault there, smoothed; triangles turn about it.
    corner : (k,) array
        Where the chain turns a corner.
    """

    way: FloatArray
    normal: FloatArray
    corner: BoolArray


def directed_chain(surface: Surface, chain: IntArray) -> tuple[IntArray, bool]:
    """Return a chain as the triangles of the rim turn, and whether that is its reverse.

    Raises
    ------
    GrabenError
        If two consecutive vertices are no edge of the rim, or the triangles along it are not turned one way.
    """
    have = {(int(a), int(b)) for a, b in boundary_edges(surface.triangles)}
    pairs = list(itertools.pairwise(chain.tolist()))
    if pairs and have.issuperset(pairs):
        return ints(chain), False
    if pairs and have.issuperset((b, a) for a, b in pairs):
        return ints(chain[::-1]), True
    raise GrabenError(f"{surface.name}: the chain of vertices is no stretch of the rim turned one way.")


def ways_on(
    surface: Surface, chain: IntArray, length: FloatArray, window: float, straight: bool = False
) -> Ways:
    """Return the ways on beyond a chain.

    Square to the rim in the fault's tangent plane, both smoothed over the window but not around a corner. At
    a corner the way is that on which both sides go on; at an end of the chain that of the rim that comes to
    it, where it comes from behind. Between those the lean changes linearly.

    Parameters
    ----------
    surface : Surface
        The fault, its triangles turned one way.
    chain : (k,) array
        Rim vertices as its triangles turn; first = last for a closed rim.
    length : (k,) array
        How far it is to go on: an end where that is 0 has no lean.
    window : float
        Model units.
    straight : bool
        Whether all ways are square to the chord of the chain, whatever notches and corners it has.
    """
    points = surface.vertices[chain]
    closed = bool(chain[0] == chain[-1])
    s = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    normal = _normals(surface, chain, window)
    corner = np.zeros(len(chain), dtype=np.bool_) if straight else corners(points, s, window, closed)
    stops = sorted({0, len(chain) - 1, *np.flatnonzero(corner).tolist()})
    ways = np.zeros_like(points)
    spans = list(itertools.pairwise(stops))
    ring = closed and not corner.any()
    around = np.inf if straight else window
    sides = [_side(points, s, normal, a, b, around, ring) for a, b in spans]
    miters = {}
    for left, right, at in zip([sides[-1], *sides], [*sides, sides[0]], stops, strict=True):
        if corner[at]:
            a, b = left[1][-1], right[1][0]
            miters[at] = (a + b) / max(1.0 + float(a @ b), _BLUNT)
    for (along, out), span in zip(sides, spans, strict=True):
        lean = np.zeros(2)
        for k, at in enumerate(span):
            if at in miters:
                lean[k] = miters[at] @ along[-k]
            elif not closed and length[at] > 0:
                lean[k] = _lean(_adjacent(surface, chain, at, window), along[-k], out[-k])
        a, b = span
        share = (s[a : b + 1] - s[a]) / (s[b] - s[a])
        lean = np.clip(lean, -_MITER, _MITER)
        ways[a : b + 1] = out + ((1 - share) * lean[0] + share * lean[1])[:, None] * along
    for at, miter in miters.items():
        ways[at] = miter - (miter @ normal[at]) * normal[at]
    return Ways(floats(ways), floats(normal), corner)


def _side(
    points: FloatArray, s: FloatArray, normal: FloatArray, a: int, b: int, window: float, ring: bool
) -> tuple[FloatArray, FloatArray]:
    """Return the unit vectors along and out of the part [a, b] of a chain; a ring has no ends."""
    at = s[a : b + 1]
    low, high = (
        (at - window, at + window) if ring else (np.maximum(at - window, s[a]), np.minimum(at + window, s[b]))
    )
    chord = _at(points[a : b + 1], at, high, ring) - _at(points[a : b + 1], at, low, ring)
    n = normal[a : b + 1]
    along = unit(chord - np.einsum("ij,ij->i", chord, n)[:, None] * n)
    return along, unit(np.cross(along, n))


def _at(points: FloatArray, s: FloatArray, x: FloatArray, ring: bool) -> FloatArray:
    """Return the places at arc lengths x, taken around a ring."""
    inside = s[0] + np.mod(x - s[0], s[-1] - s[0]) if ring else x
    return floats(np.stack([np.interp(inside, s, points[:, c]) for c in range(3)], axis=1))


def corners(points: FloatArray, s: FloatArray, window: float, closed: bool) -> BoolArray:
    """Return where a chain (k, 3) with arc lengths s (k,) turns a corner, shape (k,).

    It turns by more than CORNER within a window there, and by most within it.
    """
    whole = float(s[-1])
    w = min(window, whole / 8) if closed else window
    low, high = (s - w, s + w) if closed else (np.maximum(s - w, 0.0), np.minimum(s + w, whole))
    behind = unit(points - _at(points, s, low, closed))
    ahead = unit(_at(points, s, high, closed) - points)
    turn = np.arccos(np.clip(np.einsum("ij,ij->i", behind, ahead), -1.0, 1.0))
    if not closed:
        turn[[0, -1]] = 0.0
    sharp = np.degrees(turn) > CORNER
    for k in np.flatnonzero(sharp):
        gap = np.abs(s - s[k])
        gap = np.minimum(gap, whole - gap) if closed else gap
        near = (gap <= w) & (gap > 0)
        sharp[k] = turn[k] > turn[near].max(initial=0.0) or (
            turn[k] == turn[near].max(initial=0.0) and not sharp[near & (np.arange(len(s)) < k)].any()
        )
    return np.asarray(sharp, dtype=np.bool_)


def _lean(side: FloatArray, along: FloatArray, out: FloatArray) -> float:
    """Return the tangent of the angle at which a side leans along the rim; 0 where it is no side ahead."""
    ahead, aside = float(side @ out), float(side @ along)
    if ahead <= 0 or abs(aside) > np.tan(np.radians(_SIDE)) * ahead:
        return 0.0
    return float(np.clip(aside / ahead, -_LEAN, _LEAN))


def _adjacent(surface: Surface, chain: IntArray, at: int, window: float) -> FloatArray:
    """Return the way on which the rim beside a chain comes to its end, (3,), taken over a window."""
    edges = boundary_edges(surface.triangles)
    first = at == 0
    if np.bincount(edges[:, 0], minlength=len(surface.vertices))[chain[at]] != 1:
        return np.zeros(3)
    step = dict((edges[:, ::-1] if first else edges).tolist())
    end = surface.vertices[chain[at]]
    node = step.get(int(chain[at]), -1)
    if node < 0:
        return np.zeros(3)
    chosen = node
    way = unit((end - surface.vertices[node])[None])[0]
    walked = 0.0
    for _ in range(len(edges)):
        last, node = node, step.get(node, -1)
        if node < 0:
            break
        edge = surface.vertices[last] - surface.vertices[node]
        walked = float(np.linalg.norm(end - surface.vertices[node]))
        straight = unit(edge[None])[0] @ way > np.cos(np.radians(CORNER))
        if not straight or walked > window:
            break
        chosen = node
    return floats(end - surface.vertices[chosen])


def _normals(surface: Surface, chain: IntArray, window: float) -> FloatArray:
    """Return unit normals of a surface at vertices of a chain: of the triangles within a window, by area."""
    normals = triangle_normals(surface.vertices, surface.triangles)
    own = np.zeros((len(surface.vertices), 3))
    np.add.at(own, surface.triangles.ravel(), np.repeat(normals, 3, axis=0))
    start = unit(own[chain])
    middles = surface.vertices[surface.triangles].mean(axis=1)
    found = cKDTree(middles).query_ball_point(surface.vertices[chain], window)
    row = np.repeat(np.arange(len(chain)), [len(f) for f in found])
    near = np.concatenate([np.asarray(sorted(f), dtype=np.int64) for f in found])
    alike = np.einsum("ij,ij->i", unit(normals[near]), start[row]) > SHEET
    total = own[chain].copy()
    np.add.at(total, row[alike], normals[near[alike]])
    return unit(floats(total))


def at_corners(surface: Surface, chain: IntArray) -> BoolArray:
    """Return whether the ends of a chain of rim vertices are corners, shape (2,); of a whole rim they are."""
    if chain[0] == chain[-1]:
        return np.ones(2, dtype=np.bool_)
    return _corner_vertices(surface, boundary_edges(surface.triangles))[chain[[0, -1]]]
