"""A plan triangulation meshed anew where its triangles have turned over (paper Sect. 5).

A region around the triangles that are turned over loses its free inner nodes and is filled by a Delaunay
triangulation of its outline, to which nodes are added until its triangles are well shaped. Edges on the
outline stay as they are, lips of the cut and the outer boundary among them, since a region ends there; held
nodes stay too. A cut mesh may lie over itself in plan, as the lips of a reverse fault do around its tip:
a region is taken only where its own outline does not meet itself, and is divided where it does.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import shapely
import triangle
from scipy.sparse import coo_array, csr_array, vstack
from scipy.sparse.csgraph import shortest_path

from graben.arrays import BoolArray, FloatArray, IntArray, ints
from graben.compiled import compiled
from graben.refinement import component_labels
from graben.surface import boundary_edges, edge_sharing, edge_table

#: Rings of triangles around those that are turned over, tried from the first on. Fewer leave little room for
#: good triangles, more take ground that was good; small regions alone may fit between lips that lie close.
_RINGS = (3, 2, 1)
#: Smallest angle asked for, degrees: below 20.7, where Delaunay refinement is known to end (J. R. Shewchuk,
#: Delaunay refinement algorithms for triangular mesh generation, Comput. Geom. 22, 2002).
_ANGLE = 20
#: Largest area of a triangle over the mean of those that it stands for: refinement ends with triangles of
#: about half of the area allowed, which gives as many as there were.
_LARGEST = 2.0
#: A region whose outline meets itself is halved at most so often, one after the other.
_HALVINGS = 8
#: Places that are looked up in a region at a time, which bounds the memory.
_PLACES = 256
#: Twice the area over the square of the longest side of the flattest triangle that is made: about its height
#: over that side. Held nodes close to a held edge leave no choice, and the energy no digits, if it is lower.
_FLATTEST = 1e-3
#: Share of the area by which sums over the old and the new triangles may differ: rounding.
_ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class Remeshed:
    """A triangulation that was meshed anew in places.

    Parameters
    ----------
    points : (n, 2) array
        Positions; the nodes that stayed come first, in their old order.
    triangles : (m, 3) array
        Those that stayed come first, in their old order.
    kept : (k,) array
        The old number of each node that stayed.
    weights : (n, o) sparse array
        What each node has of the values at the o old nodes: linear interpolation, the identity where it
        stayed.
    """

    points: FloatArray
    triangles: IntArray
    kept: IntArray
    weights: csr_array

    @staticmethod
    def none(points: FloatArray, triangles: IntArray) -> Remeshed:
        """Return a triangulation as it is."""
        count = len(points)
        same = np.arange(count)
        weights = csr_array((np.ones(count), (same, same)), shape=(count, count))
        return Remeshed(points, triangles, same, weights)

    def then(self, after: Remeshed) -> Remeshed:
        """Return both remeshings as one: this and, of its result, ``after``."""
        stayed = after.kept[after.kept < len(self.kept)]
        # Nodes that this one made and the other left are new to both.
        return Remeshed(after.points, after.triangles, self.kept[stayed], after.weights @ self.weights)

    def renumbered(self, nodes: IntArray, count: int) -> IntArray:
        """Return the new numbers of some of ``count`` old nodes, any shape; -1 for those that are gone."""
        index = np.full(count + 1, -1, dtype=np.int64)
        index[self.kept] = np.arange(len(self.kept))
        return ints(index[nodes])


def plan_areas(points: FloatArray, triangles: IntArray) -> FloatArray:
    """Return twice the plan area of triangles, (m,), negative where one is turned over."""
    return shapes(points, triangles)[0]


def shapes(points: FloatArray, triangles: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return twice the plan area of triangles, negative where turned over, and their longest side squared.

    Both (m,), square model units; their ratio is about the height of a triangle over its longest side.
    ``points``: (n, 2), model units; ``triangles``: (m, 3).
    """
    result = np.empty((2, len(triangles)))
    _shape(np.array(points, dtype=np.float64), ints(triangles), result)
    return result[0], result[1]


@compiled
def _shape(points: FloatArray, triangles: IntArray, result: FloatArray) -> None:
    """Write what :func:`shapes` returns, (2, m)."""
    for t in range(len(triangles)):
        a, b, c = triangles[t]
        b_x, b_y = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1]
        c_x, c_y = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1]
        across = (c_x - b_x) ** 2 + (c_y - b_y) ** 2
        result[0, t] = b_x * c_y - b_y * c_x
        result[1, t] = max(b_x * b_x + b_y * b_y, c_x * c_x + c_y * c_y, across)


def remeshed(
    points: FloatArray, triangles: IntArray, held: BoolArray, allowed: BoolArray, bad: BoolArray | None = None
) -> Remeshed | None:
    """Return the triangulation with its bad triangles and those around them replaced by good ones.

    Parameters
    ----------
    points : (n, 2) array
        Positions, model units.
    triangles : (m, 3) array
        Counter-clockwise, but for those that are turned over.
    held : (n,) bool array
        Nodes that stay.
    allowed : (m,) bool array
        Triangles that may be replaced.
    bad : (m,) bool array, optional
        Triangles to be replaced; by default those that are turned over or have no area.

    Returns
    -------
    Remeshed or None
        None where no region around the bad triangles has an outline that does not meet itself: then the
        held nodes themselves lie where no triangulation can follow.
    """
    found = Remeshed.none(points, triangles)
    bad = plan_areas(points, triangles) <= 0 if bad is None else bad
    while bad.any():
        patch = next(_patches(found, held, allowed, bad), None)
        if patch is None:
            return None
        region, filled = patch
        stays = np.ones(len(found.triangles), dtype=bool)
        stays[region] = False
        added = len(filled.triangles) - int(stays.sum())
        allowed = np.append(allowed[stays], np.ones(added, dtype=bool))
        bad = np.append(bad[stays], np.zeros(added, dtype=bool))
        held = np.append(held[filled.kept], np.zeros(len(filled.points) - len(filled.kept), dtype=bool))
        found = found.then(filled)
    return found


def _patches(
    mesh: Remeshed, held: BoolArray, allowed: BoolArray, bad: BoolArray
) -> Iterator[tuple[IntArray, Remeshed]]:
    """Yield regions (indices of triangles) around bad triangles with the mesh in which they are replaced."""
    triangles = mesh.triangles
    if not allowed[bad].all():
        return
    for rings in _RINGS:
        inside = bad.copy()
        for _ in range(rings):
            near = np.zeros(len(mesh.points), dtype=bool)
            near[triangles[inside]] = True
            inside |= near[triangles].any(axis=1) & allowed
        for region in _simple_parts(mesh.points, triangles, np.flatnonzero(inside), bad, _HALVINGS):
            filled = _filled(mesh.points, triangles, region, held)
            if filled is not None:
                yield region, filled


def _simple_parts(
    points: FloatArray, triangles: IntArray, region: IntArray, bad: BoolArray, halvings: int
) -> Iterator[IntArray]:
    """Yield connected parts of a region with bad triangles, whose outlines do not meet themselves."""
    pairs = _neighbours(triangles[region])
    labels = component_labels(len(region), pairs)
    for label in np.unique(labels[bad[region]]):
        mine = np.flatnonzero(labels == label)
        part = region[mine]
        rim = boundary_edges(triangles[part])
        meeting = _meeting(points, rim)
        if meeting is None:
            yield part
        elif halvings > 0:
            half = _nearer(triangles[part], rim[meeting])
            for side in (half, ~half):
                if side.any() and not side.all():
                    yield from _simple_parts(points, triangles, part[side], bad, halvings - 1)


def _neighbours(triangles: IntArray) -> IntArray:
    """Return the pairs of triangles that share an edge, shape (p, 2)."""
    edges, sides = edge_table(triangles)
    sharing = edge_sharing(sides, len(edges))
    order = np.argsort(sides.ravel(), kind="stable")
    first = np.concatenate([[0], np.cumsum(sharing)])[:-1][sharing == 2]
    return ints(np.stack([order[first], order[first + 1]], axis=1) // 3, -1, 2)


def _nearer(triangles: IntArray, edges: IntArray) -> BoolArray:
    """Return which triangles of a connected part are nearer to the first of two edges of its rim."""
    count = len(triangles)
    pairs = _neighbours(triangles)
    graph = csr_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    start = [int(np.argmax(np.isin(triangles, edge).sum(axis=1) == 2)) for edge in edges]
    first, second = shortest_path(graph, directed=False, unweighted=True, indices=start)
    return np.asarray(first < second, dtype=bool)


def _meeting(points: FloatArray, edges: IntArray) -> IntArray | None:
    """Return two edges (indices) that meet elsewhere than in a common node; None where none do.

    Of several the first; touching is meeting.
    """
    lines = points[edges]
    i, j = near_pieces(lines, lines).T
    common = (edges[i][:, :, None] == edges[j][:, None, :]).any(axis=(1, 2))
    i, j = i[(i < j) & ~common], j[(i < j) & ~common]
    first, second = straddled(lines[i], lines[j]), straddled(lines[j], lines[i])
    meet = np.flatnonzero((first <= 0) & (second <= 0))
    return ints([i[meet[0]], j[meet[0]]]) if len(meet) else None


def near_pieces(first: FloatArray, second: FloatArray) -> IntArray:
    """Return the pairs of pieces of plan lines, (k, 2, 2) and (l, 2, 2), whose boxes meet, (p, 2), sorted."""
    lines = shapely.linestrings(second)
    pairs = shapely.STRtree(lines).query(lines if first is second else shapely.linestrings(first)).T
    return ints(pairs[np.lexsort(pairs.T[::-1])], -1, 2)


def straddled(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return for pairs of pieces, (p, 2, 2) each, -1 where the line of one parts the other.

    Zero where it touches an end of it; shape (p,).
    """
    way = first[:, 1] - first[:, 0]
    left, right = (_cross(way, second[:, k] - first[:, 0]) for k in range(2))
    return np.asarray(np.sign(left) * np.sign(right), dtype=np.float64)


def _filled(points: FloatArray, triangles: IntArray, region: IntArray, held: BoolArray) -> Remeshed | None:
    """Return the mesh with a region triangulated anew; None where its outline holds no such triangulation."""
    old = triangles[region]
    rim = boundary_edges(old)
    on_rim = np.zeros(len(points), dtype=bool)
    on_rim[rim] = True
    gone = np.zeros(len(points), dtype=bool)
    gone[old] = True
    gone &= ~(on_rim | held)
    stays = np.setdiff1d(np.unique(old), np.flatnonzero(gone))
    area = float(plan_areas(points, old).sum()) / 2.0
    if area <= 0:
        return None
    made, corners = _triangulated(points, stays, rim, np.sqrt(area / len(old)))
    kept = np.flatnonzero(~gone)
    index = np.full(len(points), -1)
    index[kept] = np.arange(len(kept))
    # The triangulation numbers the nodes that stay first, then those that it added.
    names = np.concatenate([index[stays], len(kept) + np.arange(len(made))])
    place = np.concatenate([points[kept], made])
    new = names[corners]
    if not _fits(place, new, index[rim], index[stays], area):
        return None
    weights = vstack([_identity(kept, len(points)), _interpolation(points, old, made)], format="csr")
    others = np.delete(triangles, region, axis=0)
    return Remeshed(place, np.concatenate([index[others], new]), kept, csr_array(weights))


def _triangulated(
    points: FloatArray, nodes: IntArray, rim: IntArray, size: float
) -> tuple[FloatArray, IntArray]:
    """Return the nodes (a, 2) added inside a rim and the triangles (m, 3) there.

    Corners are numbered by place in ``nodes`` (k,), then by added node; ``size`` is the root of the mean area
    of a triangle, model units.
    """
    middle = points[nodes].mean(axis=0)
    index = np.full(len(points), -1)
    index[nodes] = np.arange(len(nodes))
    outline = {"vertices": (points[nodes] - middle) / size, "segments": index[rim].astype(np.int32)}
    # YY: no node is added on the rim, whose edges the mesh around it shares.
    made = triangle.triangulate(outline, f"pq{_ANGLE}a{_LARGEST}YY")
    corners = np.asarray(made["triangles"], dtype=np.int64)
    place = np.asarray(made["vertices"], dtype=np.float64)
    inside = _windings(place[corners].mean(axis=1), place, index[rim]) == 1
    used, corners = np.unique(corners[inside], return_inverse=True)
    fresh = used[used >= len(nodes)]
    names = np.concatenate([used[used < len(nodes)], len(nodes) + np.arange(len(fresh))])
    return size * place[fresh] + middle, names[corners.reshape(-1, 3)]


def _windings(places: FloatArray, points: FloatArray, rim: IntArray) -> IntArray:
    """Return how often directed closed lines go around each place, (k,)."""
    a, b = points[rim[:, 0]][None] - places[:, None], points[rim[:, 1]][None] - places[:, None]
    left = _cross(a, b) > 0
    up = (a[..., 1] <= 0) & (b[..., 1] > 0) & left
    down = (a[..., 1] > 0) & (b[..., 1] <= 0) & ~left
    return ints(up.sum(axis=1) - down.sum(axis=1))


def _fits(points: FloatArray, triangles: IntArray, rim: IntArray, nodes: IntArray, area: float) -> bool:
    """Return whether new triangles are not turned over or flat, and have this rim, these nodes, this area."""
    areas, longest = shapes(points, triangles)
    if (areas < _FLATTEST * longest).any() or abs(areas.sum() / 2.0 - area) > _ROUNDING * area:
        return False
    made = boundary_edges(triangles)
    return np.array_equal(_sorted(made), _sorted(rim)) and bool(np.isin(nodes, triangles).all())


def _sorted(edges: IntArray) -> IntArray:
    return ints(edges[np.lexsort(edges.T)], -1, 2)


def _identity(kept: IntArray, count: int) -> csr_array:
    return csr_array((np.ones(len(kept)), (np.arange(len(kept)), kept)), shape=(len(kept), count))


def _interpolation(points: FloatArray, triangles: IntArray, places: FloatArray) -> csr_array:
    """Return the weights (k, n) of nodes in the linear interpolation at places (k, 2).

    Where triangles lie over each other, because some are turned over, that one is taken which holds a place
    best; every place of the region has one that is not turned over.
    """
    good = triangles[plan_areas(points, triangles) > 0]
    # Some at a time, since each place is held against each triangle.
    parts = [_shares(points, good, part) for part in np.split(places, range(_PLACES, len(places), _PLACES))]
    best, values = (np.concatenate([part[k] for part in parts]) for k in range(2))
    rows = np.repeat(np.arange(len(places)), 3)
    return coo_array((values.ravel(), (rows, good[best].ravel())), shape=(len(places), len(points))).tocsr()


def _shares(points: FloatArray, triangles: IntArray, places: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return the triangle that holds each place best, (k,), and the shares of its corners there, (k, 3)."""
    corners = points[triangles]
    shares = np.stack(
        [
            _cross(corners[:, (k + 1) % 3] - places[:, None], corners[:, (k + 2) % 3] - places[:, None])
            for k in range(3)
        ],
        axis=2,
    )
    shares /= plan_areas(points, triangles)[None, :, None]
    best = np.argmax(shares.min(axis=2), axis=1)
    values = np.clip(shares[np.arange(len(places)), best], 0.0, 1.0)
    return ints(best), np.asarray(values / values.sum(axis=1)[:, None])


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0], dtype=np.float64)
