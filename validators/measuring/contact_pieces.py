"""The connected pieces in which two surfaces meet, each told apart by kind."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from graben.arrays import BoolArray, FloatArray, IntArray, floats, ints
from graben.proximity import nearest
from graben.surface import chained, triangle_areas
from graben.validators.measuring.contact import Contact, ContactKind
from graben.validators.measuring.measures import components
from graben.validators.measuring.surroundings import WIDEST, Facets, Meeting, meetings
from graben.validators.measuring.touching import EXACT, ONE, Lines, Mesh, Source, Touch, pieces

# In contact distances.
#: A stretch of an edge that is longer lies on the other surface; a shorter one may pass through it.
_LYING = 20.0
#: Extent of a point.
_POINT = 20.0
#: Least length of a line beside others of its piece, and least mean width of an area.
_MINOR = 100.0
#: Least length of a line beside others of its piece, as a share of the longest.
_SHARE = 0.01
#: Least mean width of an area, as a share of the size of its triangles: two surfaces that cross at a small
#: angle are within the contact distance of each other in a strip, and that is no overlap.
_STRIP = 0.1


def told_apart(
    surfaces: tuple[int, int], both: tuple[Mesh, Mesh], touch: Touch, tolerance: float
) -> list[Contact]:
    """Return the contacts of two surfaces, piece by piece: areas first, then the longest.

    Parameters
    ----------
    surfaces : tuple of two int
        Their numbers.
    both : tuple of two Mesh
        The surfaces.
    touch : Touch
        What they have in common.
    tolerance : float
        Distance at which two surfaces touch, model units.
    """
    pair = _pair(surfaces, both, touch, tolerance)
    chosen = _chosen(pair)
    made = [_of_piece(pair, k, chosen) for k in np.unique(pair.piece)]
    made.sort(key=lambda m: (m[0].kind is not ContactKind.AREA, -sum(c.size for c in m)))
    return [replace(c, piece=k) for k, m in enumerate(made) for c in m]


@dataclass(frozen=True, eq=False)
class _Pair:
    """Two surfaces and the segments on which they meet.

    Parameters
    ----------
    surfaces : tuple of two int
        Their numbers.
    meshes, near : tuples of two
        The surfaces, and those of their triangles that come near the other.
    lines : Lines
        The segments.
    piece : (n,) array
        Connected piece of each segment.
    common, triangles, areas : (t, 3, 3), (t, 2) and (t,) arrays
        The triangles in which they lie on each other, those of the surfaces that they are parts of, and the
        connected piece of each.
    meeting : (n,) array
        How they meet there, -1 where that is not asked: in an area, by a common edge, where it is too short.
    radius : (n,) array
        How far around each segment that was looked at, model units.
    held : tuple of two pairs of (k,) arrays
        Segments and the triangles of ``near`` that hold their middles.
    tolerance : float
        Distance at which two surfaces touch, model units.
    """

    surfaces: tuple[int, int]
    meshes: tuple[Mesh, Mesh]
    near: tuple[Facets, Facets]
    lines: Lines
    piece: IntArray
    common: FloatArray
    triangles: IntArray
    areas: IntArray
    meeting: IntArray
    radius: FloatArray
    held: tuple[tuple[IntArray, IntArray], tuple[IntArray, IntArray]]
    tolerance: float


def _pair(surfaces: tuple[int, int], both: tuple[Mesh, Mesh], touch: Touch, tolerance: float) -> _Pair:
    """Return the pair with its segments joined to pieces and asked how the surfaces meet there."""
    lines = touch.lines
    piece, areas = pieces(touch, tolerance)
    wide = _wide(touch.common, areas, max(_MINOR * tolerance, _STRIP * _fineness(both, touch.triangles)))
    common, triangles, areas = touch.common[wide], touch.triangles[wide], areas[wide]
    settled = lines.source == Source.COMMON
    settled |= _beside(lines, lines.ends[settled], tolerance) | _beside(lines, common, tolerance)
    length = lines.lengths
    asked = ~settled & (length > tolerance)
    asked &= (lines.source == Source.SHARED) | lines.whole | (length > _LYING * tolerance)
    meeting, radius = np.full(len(piece), -1), np.zeros(len(piece))
    if asked.any():
        ends = lines.ends[asked]
        reach = WIDEST * tolerance
        box = ends.min(axis=(0, 1)) - reach, ends.max(axis=(0, 1)) + reach
        facets = both[0].facets.within(*box), both[1].facets.within(*box)
        meeting[asked], radius[asked] = meetings(ends, *facets, tolerance)
    first, second = (f.near(lines.middles, ONE * tolerance) for f in touch.near)
    return _Pair(
        surfaces,
        both,
        touch.near,
        lines,
        piece,
        common,
        triangles,
        areas,
        meeting,
        radius,
        (first, second),
        tolerance,
    )


def _wide(common: FloatArray, piece: IntArray, least: float) -> BoolArray:
    """Return which common triangles are part of an area whose mean width exceeds ``least``."""
    wide = np.zeros(len(common), dtype=bool)
    for k in np.unique(piece):
        mine = piece == k
        wide[mine] = _areas(common[mine]).sum() > least * _extent(common[mine].reshape(-1, 3))
    return wide


def _fineness(both: tuple[Mesh, Mesh], triangles: IntArray) -> float:
    """Return the median size of the smaller of two triangles that lie on each other, root of its area."""
    if not len(triangles):
        return 0.0
    sizes = []
    for mesh, index in zip(both, triangles.T, strict=True):
        at = np.searchsorted(mesh.facets.index, index)
        sizes.append(np.sqrt(_areas(mesh.facets.corners[at])))
    return float(np.median(np.minimum(*sizes)))


def _beside(lines: Lines, simplices: FloatArray, tolerance: float) -> BoolArray:
    """Return which segments lie on edges (s, 2, 3) or triangles (s, 3, 3), to the contact distance."""
    points = np.concatenate([lines.ends[:, 0], lines.middles, lines.ends[:, 1]])
    return np.asarray((_distance(points, simplices).reshape(3, -1) <= ONE * tolerance).all(axis=0))


def _distance(points: FloatArray, simplices: FloatArray) -> FloatArray:
    """Return how far points are from the nearest of some edges (s, 2, 3) or triangles (s, 3, 3)."""
    if not len(simplices):
        return np.full(len(points), np.inf)
    corners = simplices.reshape(-1, 3)
    return nearest(points, corners, np.arange(len(corners)).reshape(-1, simplices.shape[1])).distance


def _areas(corners: FloatArray) -> FloatArray:
    flat = corners.reshape(-1, 3)
    return triangle_areas(flat, ints(np.arange(len(flat)), -1, 3))


def _extent(points: FloatArray) -> float:
    """Return about the largest distance between two of some points."""
    far = points[np.argmax(np.linalg.norm(points - points.mean(axis=0), axis=1))]
    return float(np.linalg.norm(points - far, axis=1).max())


def _chosen(pair: _Pair) -> dict[ContactKind, BoolArray]:
    """Return which segments stand for each kind of line, so that none is counted twice."""
    lines, meeting, length = pair.lines, pair.meeting, pair.lines.lengths
    first, second, shared = (lines.source == s for s in (Source.FIRST, Source.SECOND, Source.SHARED))
    rim = np.zeros(len(first), dtype=bool)
    for own, mesh in zip((first, second), pair.meshes, strict=True):
        rim[own] = mesh.rim[lines.edge[own]]
    ends = np.isin(meeting, (Meeting.FIRST_ENDS, Meeting.SECOND_ENDS, Meeting.BOTH_END))
    only_second = meeting == Meeting.SECOND_ENDS
    # where both end, the rim of the first stands for both
    cut = rim & ends & np.where(only_second, second, first)
    # a stub wider than the contact distance, but not by much: there the rim itself does not lie on the other
    cut |= shared & ends & (_distance(lines.middles, lines.ends[cut]) > pair.radius)
    back = meeting == Meeting.BACK
    fold = np.zeros(len(first), dtype=bool)
    for k in np.unique(pair.piece):
        mine = back & (pair.piece == k)
        fold |= max((mine & first, mine & second), key=lambda m: length[m].sum())
    fold |= shared & back & (_distance(lines.middles, lines.ends[fold]) > pair.radius)
    return {
        ContactKind.CROSSING: shared & (meeting == Meeting.THROUGH),
        ContactKind.T: cut,
        ContactKind.LINE: fold,
        ContactKind.EDGE: lines.source == Source.COMMON,
    }


def _of_piece(pair: _Pair, number: int, chosen: dict[ContactKind, BoolArray]) -> list[Contact]:
    """Return the kinds of contact on one piece: an area first, then the longest."""
    mine, area = pair.piece == number, pair.areas == number
    length = pair.lines.lengths
    minor = _MINOR * pair.tolerance
    size = {kind: float(length[mine & which].sum()) for kind, which in chosen.items()}
    if area.any():
        size[ContactKind.EDGE] = 0.0
    elif (
        not size[ContactKind.EDGE]
        and _extent(pair.lines.ends[mine].reshape(-1, 3)) <= _POINT * pair.tolerance
    ):
        return [_point(pair, mine)]
    # the short ends of another kind, where the line begins or ends, do not count beside it
    most = max(size.values())
    least = max(minor, _SHARE * most) if area.any() or most > minor else 0.0
    lines = {kind: _long(pair, mine & chosen[kind], least) for kind in size if size[kind] > least}
    kinds = sorted((kind for kind in lines if lines[kind].any()), key=lambda kind: -size[kind])
    found = [_area(pair, area)] if area.any() else []
    found += [_line(pair, mine, lines[kind], kind) for kind in kinds]
    return found or [_point(pair, mine)]


def _long(pair: _Pair, mine: BoolArray, least: float) -> BoolArray:
    """Return some segments without those whose connected line is no longer than ``least``."""
    index = np.flatnonzero(mine)
    group = _joined(
        pair.lines.ends[index].reshape(-1, 3), pair.tolerance, np.arange(2 * len(index)).reshape(-1, 2)
    )
    group = group[::2]
    kept = mine.copy()
    kept[index] = (np.bincount(group, pair.lines.lengths[index]) > least)[group]
    return kept


def _joined(nodes: FloatArray, tolerance: float, links: IntArray) -> IntArray:
    """Return the number of each place, places joined that are one and those linked, (p, 2)."""
    near = cKDTree(nodes).query_pairs(ONE * tolerance, output_type="ndarray")
    return components(len(nodes), np.concatenate([near, links]))


def _point(pair: _Pair, mine: BoolArray) -> Contact:
    """Return a contact in a point, or in a vertex that both surfaces have."""
    points = pair.lines.ends[mine].reshape(-1, 3)
    middle = points.mean(axis=0)
    place = points[np.argmin(np.linalg.norm(points - middle, axis=1))]
    kind = ContactKind.POINT
    corners = [f.corners.reshape(-1, 3) + 0.0 for f in pair.near]
    first, second = (c[np.linalg.norm(c - middle, axis=1) <= _POINT * pair.tolerance] for c in corners)
    both = (first[:, None] == second).all(axis=2).any(axis=1)
    if both.any():
        kind, place = ContactKind.VERTEX, first[np.argmax(both)]
    passing = pair.lines.lengths[mine & (pair.lines.source == Source.SHARED)].sum()
    return Contact(
        pair.surfaces,
        0,
        kind,
        1,
        0.0,
        _around(pair, place),
        floats(place, 1, 3),
        passing=float(passing) if passing > EXACT * pair.tolerance else 0.0,
    )


def _area(pair: _Pair, mine: BoolArray) -> Contact:
    """Return an overlap in an area, some of the common triangles."""
    common, areas = pair.common[mine], _areas(pair.common[mine])
    first, second = (ints(np.unique(pair.triangles[mine, k])) for k in (0, 1))
    size = float(areas.sum())
    middle = (common.mean(axis=1) * areas[:, None]).sum(axis=0) / size
    corners = common.reshape(-1, 3)
    place = nearest(middle[None], corners, np.arange(len(corners)).reshape(-1, 3)).place
    return Contact(pair.surfaces, 0, ContactKind.AREA, len(first), size, (first, second), floats(place))


def _line(pair: _Pair, piece: BoolArray, mine: BoolArray, kind: ContactKind) -> Contact:
    """Return a contact in a line, some of the segments of a piece."""
    lines, length = pair.lines, pair.lines.lengths
    paths = _paths(lines.ends[mine], pair.tolerance)
    passing = 0.0
    if kind is ContactKind.CROSSING:
        count = _crossing_triangles(pair, mine & (length > pair.tolerance))
    else:
        keys = np.stack([lines.source, np.where(lines.edge >= 0, lines.edge, -np.arange(len(mine)) - 1)])
        count = np.unique(keys[:, mine], axis=1).shape[1]
    if kind in (ContactKind.T, ContactKind.LINE):
        beside = piece & (lines.source == Source.SHARED) & (pair.meeting != Meeting.THROUGH)
        off = _distance(lines.middles[beside], lines.ends[mine]) > EXACT * pair.tolerance
        passing = float(length[beside][off].sum())
    return Contact(
        pair.surfaces,
        0,
        kind,
        int(count),
        float(length[mine].sum()),
        _triangles(pair, mine & (length > pair.tolerance)),
        floats([_half_way(path) for path in paths], -1, 3),
        tuple(floats(path) for path in paths),
        passing,
        _rims(pair, mine) if kind is ContactKind.T else (),
    )


def _rims(pair: _Pair, mine: BoolArray) -> tuple[int, ...]:
    """Return which surfaces end along some segments, but for a small share of them."""
    both = mine & (pair.meeting == Meeting.BOTH_END)
    length = pair.lines.lengths
    sizes = [
        length[both | (mine & (pair.meeting == m))].sum() for m in (Meeting.FIRST_ENDS, Meeting.SECOND_ENDS)
    ]
    return tuple(
        k for k, size in zip(pair.surfaces, sizes, strict=True) if size > _SHARE * length[mine].sum()
    )


def _crossing_triangles(pair: _Pair, mine: BoolArray) -> int:
    """Return how many pairs of triangles hold the middle of one of some segments."""
    (seg_a, a), (seg_b, b) = ((seg[mine[seg]], tri[mine[seg]]) for seg, tri in pair.held)
    order = np.argsort(seg_b, kind="stable")
    first, last = (np.searchsorted(seg_b[order], seg_a, side=side) for side in ("left", "right"))
    counts = last - first
    step = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    partner = b[order][np.repeat(first, counts) + step]
    return len(np.unique(np.repeat(a, counts) * len(pair.near[1].index) + partner))


def _triangles(pair: _Pair, mine: BoolArray) -> tuple[IntArray, IntArray]:
    """Return the triangles of either surface that hold the middles of some segments."""
    first, second = (
        ints(np.unique(f.index[tri[mine[seg]]])) for f, (seg, tri) in zip(pair.near, pair.held, strict=True)
    )
    return first, second


def _around(pair: _Pair, place: FloatArray) -> tuple[IntArray, IntArray]:
    """Return the triangles of either surface that hold a point."""
    near = (f.index[f.near(place[None], ONE * pair.tolerance)[1]] for f in pair.near)
    first, second = (ints(np.unique(index)) for index in near)
    return first, second


def _paths(ends: FloatArray, tolerance: float) -> list[FloatArray]:
    """Return segments joined to polylines where their ends are one, the longest first."""
    nodes = ends.reshape(-1, 3)
    label = _joined(nodes, tolerance, np.zeros((0, 2), dtype=np.int64))
    count = np.bincount(label)
    places = np.stack([np.bincount(label, nodes[:, k]) / count for k in range(3)], axis=1)
    edges = np.unique(np.sort(label.reshape(-1, 2), axis=1), axis=0)
    chains = chained(ints(edges[edges[:, 0] != edges[:, 1]]))
    return sorted([places[chain] for chain in chains] or [nodes[:2]], key=lambda path: -_length(path))


def _length(path: FloatArray) -> float:
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


def _half_way(path: FloatArray) -> FloatArray:
    """Return the point half the way along a polyline, of a closed one its highest."""
    if np.array_equal(path[0], path[-1]):
        return np.asarray(path[np.argmax(path[:, 2])])
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    return np.array([np.interp(way[-1] / 2, way, path[:, k]) for k in range(3)])
