"""slivers: triangles without area or with too small an angle go (answers `degenerate`).

The long edge of a flat triangle is flipped, the short one of a needle collapsed, whichever of all such edits
leaves no sliver behind and departs least from the surface. Rims and what other faults share stay in place.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graben.arrays import BoolArray, FloatArray, IntArray, bools, ints
from graben.cleaning.repairing import Change, Refusal, Repair, Step, Task
from graben.cleaning.shaping.edits import Edit, Patchwork
from graben.cleaning.shaping.limits import distances
from graben.cleaning.shaping.shared import shared_vertices
from graben.proximity import nearest
from graben.surface import Surface, triangle_normals
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


@dataclass(frozen=True, eq=False)
class _Rules:
    """What edits must keep: the least angle, degrees, the vertices held, and the largest distance.

    ``turn``: of a normal, degrees. ``share``: of the distance over the longest side. ``last``: whether these
    are the last that are tried, so that the rim may give way by the height of a sliver.
    """

    limit: float
    held: BoolArray
    away: float
    turn: float = MOST_TURN
    share: float = _MOST_AWAY
    last: bool = False


def without_slivers(
    surface: Surface, limit: float = ANGLE_LIMIT, held: BoolArray | None = None, away: float = np.inf
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
        Vertices that stay, and edges between them.
    away : float
        Largest distance of an edit from the surface, model units.

    >>> split = Surface("F", [[0, 0, 0], [9, 0, 0], [0, 9, 0], [4, 0.01, 0]],
    ...                 [[0, 1, 3], [1, 2, 3], [2, 0, 3]])
    >>> without_slivers(split).triangles.tolist()
    [[1, 2, 0]]
    """
    held = bools(np.zeros(len(surface.vertices))) if held is None else held
    work = Patchwork(surface)
    if not smallest_angles(surface.vertices, surface.triangles).any():
        return surface
    todo = _edited(work, bad_triangles(surface, limit).tolist(), _Rules(limit, held, away))
    if todo:
        _edited(work, todo, _Rules(limit, held, away, _LAST_TURN, _LAST_AWAY, True))
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
    """Return the edit that leaves out a sliver along the rim: that then goes through its third corner.

    So where a line that other faults share ends a hair below the rim.
    """
    found = work.without_rim(t)
    if found is None:
        return None
    (a, b, c), edit = found
    far = float(nearest(work.points[[c]], work.points, ints([[a, b]])).distance[0])
    return (
        edit
        if far <= min(rules.away, _MOST_AWAY * _longest(work, t)) and not rules.held[[a, b]].all()
        else None
    )


def _allowed(work: Patchwork, t: int, rules: _Rules) -> list[Edit]:
    """Return the edits of a triangle that leave rims and held vertices in place."""
    flips = [e for e in work.flips(t) if not rules.held[list(_side(e))].all()]
    near = ON_RIM * _longest(work, t)
    return flips + [e for u, v, e in work.collapses(t) if not rules.held[u] and _along_rim(work, u, v, near)]


def _side(flip: Edit) -> tuple[int, int]:
    """Return the ends of the edge that a flip takes away."""
    return flip.added[0][1], flip.added[1][2]


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
    away = _departure(points, old[before > 0.0], new)
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


def _departure(points: FloatArray, old: IntArray, new: IntArray) -> float:
    """Return how far apart two triangulations of one patch are, at their corners and edges' middles."""
    if not len(old):
        return 0.0
    away = 0.0
    for here, there in ((old, new), (new, old)):
        corners = points[here]
        asked = np.concatenate([corners, 0.5 * (corners + np.roll(corners, 1, axis=1))]).reshape(-1, 3)
        away = max(
            away, float(nearest(asked, points[there].reshape(-1, 3), _each(len(there))).distance.max())
        )
    return away


def _each(count: int) -> IntArray:
    return np.arange(3 * count).reshape(-1, 3)


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
            held = shared_vertices(surface, faults.values())
            new = without_slivers(surface, limit, held, task.max_move(name))
            left = bad_triangles(new, limit)
            count = len(bad) - len(left)
            if len(left):
                made.append(_left(task, name, new, left, limit))
            if count <= 0 or distances(new, [task.references[name]]).max(initial=0.0) > task.max_move(name):
                continue
            reason = (
                f"{plural(count, 'triangle')} of {name} without area, or with an angle below {limit:g} "
                "degrees, merged into the triangles around by flips and collapses of edges."
            )
            place = surface.vertices[surface.triangles[bad[0]]].mean(axis=0)
            made.append(Change({name: (new,)}, (Step("degenerate", (name,), count, place, reason),)))
    return made


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
            "any flip or collapse would move the rim or a line shared with another fault, turn a normal by "
            f"more than {_LAST_TURN:g} degrees, or leave the surface by more than "
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
