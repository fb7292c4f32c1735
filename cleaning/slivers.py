"""slivers: triangles without area or with too small an angle go (answers `degenerate`).

The long edge of a flat triangle is flipped, the short one of a needle collapsed, whichever of all such edits
leaves no sliver behind and departs least from the surface. Where none does, the patch around a sliver is
meshed anew within the same limits. Rims and what other faults share stay in place.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from graben.arrays import BoolArray, FloatArray, IntArray, bools, ints
from graben.cleaning.repairing import Change, Refusal, Repair, Step, Task
from graben.cleaning.shaping.edits import Edit, Patchwork
from graben.cleaning.shaping.fans import trouble
from graben.cleaning.shaping.limits import distances
from graben.cleaning.shaping.remeshing import differing, followed, remeshed, rings, shared_edges
from graben.cleaning.shaping.shared import shared_vertices
from graben.proximity import nearest
from graben.surface import Surface, edge_table, triangle_normals
from graben.validators.degenerate import ANGLE_LIMIT
from graben.validators.measuring.measures import ANGLE_ROUNDING, amount, plural, side_lengths, smallest_angles

#: Degrees by which the normal of a triangle may turn: further, an edit folds the surface or cuts a ridge.
MOST_TURN = 25.0
#: Distance from the surface over the longest side of the sliver that an edit may make: as flat as a sliver.
_MOST_AWAY = 1e-2
#: The same two where nothing else takes a sliver away: at a line that other faults share there are few edits.
_LAST_TURN, _LAST_AWAY = 45.0, 4e-2
#: Distance over that side up to which edits count as equally near; the better angles decide among them.
_AS_NEAR = 1e-4
#: Distance of a vertex of the rim from the line between its neighbours, over the longest side of the sliver,
#: up to which it may be merged along the rim: a ninth of the height of a sliver of half a degree.
ON_RIM = 1e-3
#: Degrees from which on larger angles do not make an edit better.
_GOOD = 10.0
#: So often all slivers are looked at again: what stood in the way may be gone.
_MOST_PASSES = 6
#: Rings of triangles around a sliver that are meshed anew with it, and the lengths of edge tried over the
#: median there: the fewest rings that help differ, and a short edge that stays wants short ones around it.
_RINGS = (1, 2, 3)
_LENGTHS = (2.0, 1.4, 1.0, 0.7, 0.5, 0.35)
#: Slivers of a patch meshed anew over those before up to which edits are asked to take them away.
_MOST_MORE = 10


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
        _edited(work, todo, _Rules(limit, held, kept, away, _LAST_TURN, _LAST_AWAY, True))
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
            todo += new[_bad(work.points, corners, rules.limit)].tolist()
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


def _bad(points: FloatArray, triangles: IntArray, limit: float) -> BoolArray:
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
    away = _departure(points[old[before > 0.0]], points[new])
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


def _departure(old: FloatArray, new: FloatArray) -> float:
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


def with_patches_remeshed(
    surface: Surface,
    limit: float,
    held: BoolArray,
    lines: IntArray,
    away: float,
    fits: Callable[[Surface], bool] = lambda made: True,
) -> Surface:
    """Return the surface with the patches around slivers meshed anew, where that leaves fewer of them.

    Parameters
    ----------
    surface : Surface
        A sound surface, of which flips and collapses have taken what they can.
    limit : float
        Least angle, degrees.
    held : (n,) array
        Vertices that stay.
    lines : (k, 2) array
        Edges that stay, the smaller vertex first.
    away : float
        Largest distance from the surface, model units.
    fits : callable
        Whether a surface may be taken for all that is not asked here.
    """
    vain: set[bytes] = set()
    while True:
        bad = bad_triangles(surface, limit)
        keys = [surface.vertices[surface.triangles[t]].tobytes() for t in bad]
        left = [(t, key) for t, key in zip(bad.tolist(), keys, strict=True) if key not in vain]
        if not left:
            return surface
        t, key = left[0]
        made = None
        if not _between_lines(surface, t, lines):
            made = _patched(surface, t, limit, held, lines, away, fits)
        if made is None:
            vain.add(key)
            continue
        held, lines = followed(surface, made, held, lines)
        surface = made


def _between_lines(surface: Surface, t: int, lines: IntArray) -> bool:
    """Return whether the smallest angle of a triangle lies between two lines: no new mesh changes that."""
    corners = surface.triangles[t]
    k = int(side_lengths(surface.vertices, corners[None])[0].argmin())
    sides = np.sort([[corners[k], corners[k - 1]], [corners[k], corners[k - 2]]], axis=1)
    return all((lines == side).all(axis=1).any() for side in sides)


def _patched(
    surface: Surface,
    t: int,
    limit: float,
    held: BoolArray,
    lines: IntArray,
    away: float,
    fits: Callable[[Surface], bool],
) -> Surface | None:
    """Return a surface with the smallest patch around a sliver meshed anew that leaves fewer slivers.

    Of the lengths of edge tried on it, that which makes the fewest triangles more for each sliver that goes.
    """
    sides = side_lengths(surface.vertices, surface.triangles)
    far, bad = min(away, _LAST_AWAY * float(sides[t].max())), len(bad_triangles(surface, limit))
    for count in _RINGS:
        patch = rings(surface.triangles, ints([t]), count)
        found: list[tuple[float, int, Surface]] = []
        for share in _LENGTHS:
            made = remeshed(surface, patch, held, lines, share * float(np.median(sides[patch])), far)
            if made is None or len(bad_triangles(made, limit)) > _MOST_MORE * bad:
                continue
            stay, edges = followed(surface, made, held, lines)
            made = without_slivers(made, limit, stay, far, edges)
            if _as_near(surface, made, limit, far) and fits(made):
                more = len(made.triangles) - len(surface.triangles)
                found.append((more / (bad - len(bad_triangles(made, limit))), len(found), made))
        if found:
            return min(found, key=lambda one: one[:2])[-1]
    return None


def _as_near(old: Surface, new: Surface, limit: float, away: float) -> bool:
    """Return whether a surface has fewer slivers than another, is as sound, and keeps to its shape."""
    if len(bad_triangles(new, limit)) >= len(bad_triangles(old, limit)):
        return False
    if any(a > b for a, b in zip(trouble(new.triangles), trouble(old.triangles), strict=True)):
        return False
    was, now = differing(old, new)
    before, after = (s.triangles[k] for s, k in ((old, was), (new, now)))
    if _departure(old.vertices[before], new.vertices[after]) > away:
        return False
    # the normal of a sliver says nothing
    before, after = (t[~_bad(s.vertices, t, limit)] for s, t in ((old, before), (new, after)))
    if not len(before):
        return False
    place = nearest(new.vertices[after].mean(axis=1), old.vertices, before).simplex
    a, b = triangle_normals(old.vertices, before)[place], triangle_normals(new.vertices, after)
    cosine = (a * b).sum(axis=1) / (np.linalg.norm(a, axis=1) * np.linalg.norm(b, axis=1))
    return bool((cosine >= np.cos(np.radians(_LAST_TURN))).all())


def propose(task: Task) -> list[Change | Refusal]:
    """Return for each fault with slivers the fault without them, and which of them had to stay."""
    limit = float(task.model.checks.get("degenerate", ANGLE_LIMIT))
    faults = {f.name: f.surface for f in task.model.faults}
    made: list[Change | Refusal] = []
    for finding in task.findings:
        for name in (n for n in finding.objects if n in faults):
            surface = faults[name]
            bad = bad_triangles(surface, limit)
            if not len(bad):
                reason, advice = f"{name} has no triangles.", "Take it out of the model, or export it again."
                made.append(Refusal("degenerate", (name,), reason, advice))
                continue
            merged, new = _without(task, name, limit)
            left = bad_triangles(new, limit)
            count = len(bad) - len(left)
            if len(left):
                made.append(_left(task, name, new, left, limit))
            if count <= 0:
                continue
            reason = (
                f"{plural(count, 'triangle')} of {name} without area, or with an angle below {limit:g} "
                "degrees, merged into the triangles around by flips and collapses of edges"
                f"{'' if new is merged else ', or meshed anew together with them'}."
            )
            place = surface.vertices[surface.triangles[bad[0]]].mean(axis=0)
            made.append(Change({name: (new,)}, (Step("degenerate", (name,), count, place, reason),)))
    return made


def _without(task: Task, name: str, limit: float) -> tuple[Surface, Surface]:
    """Return a fault without slivers as far as edits go, and as far as meshing patches anew goes."""
    surface, most = task.fault(name).surface, task.max_move(name)
    others = [f.surface for f in task.model.faults if f.name != name]
    held, lines = shared_vertices(surface, others), shared_edges(surface, others)
    new = without_slivers(surface, limit, held, most, lines)

    # what lies further off already is the planner's to judge
    far = max(most, _furthest(task, name, new))

    def fits(made: Surface) -> bool:
        return _furthest(task, name, made) <= far

    return new, with_patches_remeshed(new, limit, *followed(surface, new, held, lines), most, fits)


def _furthest(task: Task, name: str, surface: Surface) -> float:
    """Return how far a surface lies from the reference of a fault at most."""
    return float(distances(surface, [task.references[name]]).max(initial=0.0))


def _left(task: Task, name: str, surface: Surface, left: IntArray, limit: float) -> Refusal:
    """Return why some slivers stay."""
    angles = smallest_angles(surface.vertices, surface.triangles[left])
    place = surface.vertices[surface.triangles[left[0]]].mean(axis=0)
    if not (smallest_angles(surface.vertices, surface.triangles) > 0.0).any():
        reason, advice = f"No triangle of {name} has an area.", "Export the surface again."
    else:
        size = side_lengths(surface.vertices, surface.triangles[left]).max()
        reason = (
            f"{plural(len(left), 'triangle')} of {name} with angles from {angles.min():.2g} degrees stay: "
            "any flip, collapse or new mesh around would move the rim or a line shared with another fault, "
            f"turn a normal by more than {_LAST_TURN:g} degrees, or leave the surface by more than "
            f"{amount(_LAST_AWAY * size, task.unit)}."
        )
        advice = "Remesh the fault there."
    return Refusal("degenerate", (name,), reason, advice, place, float(limit - angles.min()), "degrees")


REPAIR = Repair(
    "slivers",
    ("degenerate",),
    "Flips the long edge of flat triangles and collapses the short one of needles.",
    propose,
)
