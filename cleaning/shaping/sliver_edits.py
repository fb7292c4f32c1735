"""Triangles without area or with too small an angle taken away by flips and collapses of edges.

The long edge of a flat triangle is flipped, the short one of a needle collapsed, whichever of all such edits
leaves no sliver behind and departs least from the surface.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graben.arrays import BoolArray, FloatArray, IntArray, bools, ints
from graben.cleaning.shaping.edits import Edit, Patchwork
from graben.proximity import nearest
from graben.surface import Surface, edge_table, triangle_normals
from graben.validators.degenerate import ANGLE_LIMIT
from graben.validators.measuring.measures import ANGLE_ROUNDING, side_lengths, smallest_angles

#: Degrees by which the normal of a triangle may turn: further, an edit folds the surface or cuts a ridge.
MOST_TURN = 25.0
#: Distance from the surface over the longest side of the sliver that an edit may make: as flat as a sliver.
_MOST_AWAY = 1e-2
#: The same two where nothing else takes a sliver away: at a line that other faults share there are few edits.
LAST_TURN, LAST_AWAY = 45.0, 4e-2
#: Distance over that side up to which edits count as equally near; the better angles decide among them.
_AS_NEAR = 1e-4
#: Distance of a vertex of the rim from the line between its neighbours, over the longest side of the sliver,
#: up to which it may be merged along the rim: a ninth of the height of a sliver of half a degree.
ON_RIM = 1e-3
#: Degrees from which on larger angles do not make an edit better.
_GOOD = 10.0
#: So often all slivers are looked at again: what stood in the way may be gone.
_MOST_PASSES = 6


@dataclass(frozen=True, eq=False)
class _Rules:
    """What edits must keep: the least angle, degrees, the vertices held, and the largest distance.

    ``turn``: of a normal, degrees. ``share``: of the distance over the longest side. ``last``: whether these
    are the last that are tried, so that the rim may give way by the height of a sliver. ``lines``: the edges
    held, the smaller vertex first.
    """

    limit: float
    held: BoolArray
    lines: frozenset[tuple[int, int]]
    away: float
    turn: float = MOST_TURN
    share: float = _MOST_AWAY
    last: bool = False


def without_slivers(
    surface: Surface,
    limit: float = ANGLE_LIMIT,
    held: BoolArray | None = None,
    away: float = np.inf,
    lines: IntArray | None = None,
) -> Surface:
    """Return the surface with triangles below an angle merged into others, as far as that goes.

    A surface without any comes back as it is, and vertices of the result are vertices of the surface.

    Parameters
    ----------
    surface : Surface
        A sound surface.
    limit : float
        Least angle, degrees; triangles without area go in any case.
    held : (n,) array, optional
        Vertices that stay.
    away : float
        Largest distance of an edit from the surface, model units.
    lines : (k, 2) array, optional
        Edges that stay, the smaller vertex first; by default those between vertices that stay.

    >>> split = Surface("F", [[0, 0, 0], [9, 0, 0], [0, 9, 0], [4, 0.01, 0]],
    ...                 [[0, 1, 3], [1, 2, 3], [2, 0, 3]])
    >>> without_slivers(split).triangles.tolist()
    [[1, 2, 0]]
    """
    held = bools(np.zeros(len(surface.vertices))) if held is None else held
    work = Patchwork(surface)
    if not smallest_angles(surface.vertices, surface.triangles).any():
        return surface
    if lines is None:
        edges = edge_table(surface.triangles)[0]
        lines = edges[held[edges].all(axis=1)]
    kept = frozenset((a, b) for a, b in lines.tolist())
    todo = _edited(work, bad_triangles(surface, limit).tolist(), _Rules(limit, held, kept, away))
    if todo:
        _edited(work, todo, _Rules(limit, held, kept, away, LAST_TURN, LAST_AWAY, True))
    return work.result()


def _edited(work: Patchwork, todo: list[int], rules: _Rules) -> list[int]:
    """Take slivers away as far as the rules allow; return those that stay."""
    for _ in range(_MOST_PASSES):
        left: list[int] = []
        changed = False
        while todo:
            t = todo.pop(0)
            if not work.alive(t):
                continue
            edit = _best(work, t, rules)
            if edit is None:
                left.append(t)
                continue
            new = ints(work.apply(edit))
            corners = ints([work.corners(k) for k in new.tolist()], -1, 3)
            todo += new[bad_among(work.points, corners, rules.limit)].tolist()
            changed = True
        todo = [t for t in left if work.alive(t)]
        if not (changed and todo):
            break
    return todo


def bad_triangles(surface: Surface, limit: float) -> IntArray:
    """Return the triangles without area or below an angle in degrees, the worst first, shape (k,)."""
    angles = smallest_angles(surface.vertices, surface.triangles)
    bad = np.flatnonzero((angles == 0.0) | (angles < limit - ANGLE_ROUNDING))
    return bad[np.argsort(angles[bad], kind="stable")]


def bad_among(points: FloatArray, triangles: IntArray, limit: float) -> BoolArray:
    """Return which triangles (m, 3) have no area or an angle below ``limit``, degrees, shape (m,)."""
    angles = smallest_angles(points, triangles)
    return np.asarray((angles == 0.0) | (angles < limit - ANGLE_ROUNDING), dtype=np.bool_)


def _best(work: Patchwork, t: int, rules: _Rules) -> Edit | None:
    """Return the edit that takes a sliver away best, or None where no edit keeps the rules."""
    if (edit := work.without_repeated(t)) is not None:
        return edit
    ranked = []
    for number, edit in enumerate(_allowed(work, t, rules)):
        rank = _rank(work, edit, t, rules)
        if rank is not None:
            ranked.append((*rank, number, edit))
    if ranked:
        return min(ranked, key=lambda r: r[:4])[-1]
    flat = smallest_angles(work.points, ints(work.corners(t), 1, 3))[0] == 0.0
    if flat and (edit := work.without_spike(t)) is not None:
        return edit
    return _off_rim(work, t, rules) if rules.last else None


def _off_rim(work: Patchwork, t: int, rules: _Rules) -> Edit | None:
    """Return the edit that leaves out a sliver along the rim: that then goes along its other sides.

    So where a line that other faults share ends a hair below the rim, or one vertex of it is a hair off it.
    """
    far = min(rules.away, _MOST_AWAY * _longest(work, t))
    if (found := work.without_rim(t)) is not None:
        (a, b, c), edit = found
        return edit if _height(work, c, a, b) <= far and not rules.held[[a, b]].all() else None
    ears = [v for v in work.corners(t) if len(work.around(v)) == 1]
    if len(ears) != 1 or rules.held[ears].any():
        return None
    a, b = (v for v in work.corners(t) if v not in ears)
    return work.without_spike(t) if _height(work, ears[0], a, b) <= far else None


def _height(work: Patchwork, v: int, a: int, b: int) -> float:
    """Return the distance of a vertex from the edge between two others."""
    return float(nearest(work.points[[v]], work.points, ints([[a, b]])).distance[0])


def _allowed(work: Patchwork, t: int, rules: _Rules) -> list[Edit]:
    """Return the edits of a triangle that leave rims and held vertices in place."""
    flips = [e for e in work.flips(t) if _side(e) not in rules.lines]
    near = ON_RIM * _longest(work, t)
    return flips + [e for u, v, e in work.collapses(t) if not rules.held[u] and _along_rim(work, u, v, near)]


def _side(flip: Edit) -> tuple[int, int]:
    """Return the ends of the edge that a flip takes away, the smaller first."""
    ends = flip.added[0][1], flip.added[1][2]
    return min(ends), max(ends)


def _longest(work: Patchwork, t: int) -> float:
    return float(side_lengths(work.points, ints(work.corners(t), 1, 3)).max())


def _along_rim(work: Patchwork, u: int, v: int, near: float) -> bool:
    """Return whether a vertex may be merged into a neighbour, where that moves the rim by no more."""
    rim = work.rim_neighbours(u)
    if not rim:
        return True
    if len(rim) != 2 or v not in rim:
        return False
    line = nearest(work.points[[u]], work.points, ints(rim, 1, 2))
    return float(line.distance[0]) <= near


def _rank(work: Patchwork, edit: Edit, t: int, rules: _Rules) -> tuple[int, float, float] | None:
    """Return how good an edit is, the least is best: slivers left, distance, angles; None if forbidden."""
    points = work.points
    old = ints([work.corners(k) for k in edit.removed], -1, 3)
    new = ints(edit.added, -1, 3)
    angles, before = smallest_angles(points, new), smallest_angles(points, old)
    bad = int((angles < rules.limit - ANGLE_ROUNDING).sum() + (angles == 0.0).sum())
    was = int((before < rules.limit - ANGLE_ROUNDING).sum() + (before == 0.0).sum())
    if bad >= was:
        return None
    if _turn(work, edit, old, new, before > rules.limit, angles > rules.limit) > rules.turn:
        return None
    size = _longest(work, t)
    away = departure(points[old[before > 0.0]], points[new])
    if away > min(rules.away, rules.share * size):
        return None
    worst = min(float(angles.min()), _GOOD)
    return bad, round(max(away / size - _AS_NEAR, 0.0), 6), -round(worst, 4)


def _turn(
    work: Patchwork, edit: Edit, old: IntArray, new: IntArray, sound: BoolArray, told: BoolArray
) -> float:
    """Return the largest angle, degrees, between a new triangle's normal and what it takes the place of.

    ``sound`` and ``told`` say which triangles, old and new, are no slivers.
    """
    was, now = triangle_normals(work.points, old), triangle_normals(work.points, new)
    mean = was.sum(axis=0)
    place = [edit.removed.index(source) for source in edit.sources]
    # the normal of a sliver says nothing, and a flip takes the place of both its triangles
    own = sound[place][:, None] & np.bool_(edit.gone >= 0)
    meant = np.where(own, was[place], mean)
    size = np.linalg.norm(meant, axis=1) * np.linalg.norm(now, axis=1)
    if (size[told] == 0.0).any():
        return 180.0
    cosine = (meant * now).sum(axis=1)[told] / size[told]
    return float(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)).max(initial=0.0)))


def departure(old: FloatArray, new: FloatArray) -> float:
    """Return how far apart two triangulations of one patch are, at their corners and edges' middles.

    Each is given by the corners of its triangles, shape (m, 3, 3).
    """
    if not len(old) or not len(new):
        return 0.0
    away = 0.0
    for here, there in ((old, new), (new, old)):
        asked = np.concatenate([here, 0.5 * (here + np.roll(here, 1, axis=1))]).reshape(-1, 3)
        away = max(away, float(nearest(asked, there.reshape(-1, 3), _each(len(there))).distance.max()))
    return away


def _each(count: int) -> IntArray:
    return np.arange(3 * count).reshape(-1, 3)
