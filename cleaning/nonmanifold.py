"""nonmanifold: edges with more than two triangles, fans that touch in a point (answers `manifold`).

PyMeshLab's filters were measured on the zoo: splitting at non-manifold edges gives 71 vertices for 36 and
orders them anew, for one fin; removing faces takes the smallest triangle at an edge, not the sheet that it
belongs to; splitting vertices leaves the copy in the same place, which is a double vertex. Hence sheets here.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from graben.arrays import BoolArray, FloatArray, IntArray, bools, floats, ints
from graben.cleaning.repairing import Change, Refusal, Repair, Step, Task
from graben.cleaning.shaping.fans import crowded_edges, fans_of, joints_of, trouble
from graben.cleaning.shaping.trimming import part_of
from graben.proximity import nearest
from graben.surface import Surface, edge_sharing, edge_table, triangle_areas
from graben.validators.measuring.measures import amount, components, percent, side_lengths
from graben.words import plural

#: Share of the area below which a sheet that hangs on a crowded edge is a fin and goes; larger ones become
#: components of their own.
FIN = 0.05
#: Share of the area below which a part that touches in a point is a speck and goes.
SPECK = 0.025
#: Distance over the size of a sheet, the root of its area, beyond which it doubles nothing: it stands out.
_FLAT = 0.05
#: Share of the way to its neighbours by which a vertex is moved where two fans are taken apart: the gap is
#: narrow, but its two sides are no double vertices, and triangles in it no slivers.
_APART = 0.02
#: Share of the least height of a fan's triangles beyond which its vertex is not moved: needles stay needles.
_OF_HEIGHT = 0.1
#: So often what is still crowded loses its extra triangles.
_MOST_ROUNDS = 8


@dataclass(frozen=True, eq=False)
class Parted:
    """A surface without crowded edges and touching fans, and what that took.

    Parameters
    ----------
    surface : Surface
        The result.
    dropped : int
        How many triangles are gone.
    area : float
        Their area, square model units.
    copies : int
        How many vertices were added where fans were taken apart.
    """

    surface: Surface
    dropped: int
    area: float
    copies: int


def made_manifold(surface: Surface, near: float) -> Parted:
    """Return the surface as a manifold; one that is a manifold comes back as it is.

    At an edge with more than two triangles the two sheets that go on most smoothly stay joined. Others go
    where they are small, or lie within ``near`` of what stays; else they get vertices of their own, a little
    apart. So do fans that touch in a point.

    Parameters
    ----------
    surface : Surface
        A sound surface.
    near : float
        Distance up to which a second sheet doubles the first, model units.
    """
    if trouble(surface.triangles) == (0, 0):
        return Parted(surface, 0, 0.0, 0)
    t = surface.triangles
    kept = bools((t[:, 0] != t[:, 1]) & (t[:, 1] != t[:, 2]) & (t[:, 2] != t[:, 0]))
    work = part_of(surface, kept)
    made = work
    for _ in range(_MOST_ROUNDS):
        joints, extra = _joined(work)
        sheet = components(len(work.triangles), joints // 3)
        gone = _fins(work, sheet, extra, near)
        if not gone.any():
            gone = _specks(work, sheet, joints)
        if not gone.any():
            made = _taken_apart(work, joints)
            if not len(crowded_edges(made.triangles)):
                break
            # both ends of such an edge are joined around to what stays: only the triangle itself can go
            gone = bools(np.isin(np.arange(len(work.triangles)), _at_crowded(made, extra)))
        if not gone.any() or gone.all():
            break
        work = made = part_of(work, bools(~gone))
    old, new = (triangle_areas(s.vertices, s.triangles).sum() for s in (surface, work))
    return Parted(
        made, len(t) - len(work.triangles), float(old - new), len(made.vertices) - len(work.vertices)
    )


def _joined(surface: Surface) -> tuple[IntArray, IntArray]:
    """Return the joints of a surface, at crowded edges one each, and the triangles left over at these.

    At a line of edges where the same patches meet the same two are joined all along: those that go on most
    smoothly in the mean, specks aside.
    """
    plain = joints_of(surface.triangles)
    slots = _slots(surface)
    if not len(slots):
        return plain, ints([])
    patch = components(len(surface.triangles), plain // 3)
    small = _small(surface, patch)
    into, length = _directions(surface, np.concatenate(slots))
    groups: dict[tuple[int, ...], list[tuple[IntArray, FloatArray, float]]] = {}
    at = 0
    for sides in slots:
        labels = patch[sides // 3]
        order = np.argsort(labels, kind="stable")
        here = (sides[order], into[at : at + len(sides)][order], float(length[at]))
        groups.setdefault(tuple(labels[order].tolist()), []).append(here)
        at += len(sides)
    chosen: list[tuple[int, int]] = []
    left: list[int] = []
    for key, edges in groups.items():
        for sides, pair in _pairs(ints(key), small, edges):
            chosen.append((int(sides[pair[0]]), int(sides[pair[1]])))
            left += np.delete(sides, list(pair)).tolist()
    return np.concatenate([plain, ints(chosen, -1, 2)]), ints(left) // 3


def _slots(surface: Surface) -> list[IntArray]:
    """Return for each crowded edge its sides, as 3 times the triangle and the corner."""
    edges, sides = edge_table(surface.triangles)
    sharing = edge_sharing(sides, len(edges))
    flat = sides.ravel()
    crowded = np.flatnonzero(sharing[flat] > 2)
    crowded = crowded[np.argsort(flat[crowded], kind="stable")]
    return np.split(crowded, np.flatnonzero(np.diff(flat[crowded])) + 1) if len(crowded) else []


def _small(surface: Surface, patch: IntArray) -> BoolArray:
    """Return which patches are smaller than a fin may be."""
    size = np.bincount(patch, triangle_areas(surface.vertices, surface.triangles))
    return np.asarray(size < FIN * size.sum(), dtype=np.bool_)


def _directions(surface: Surface, sides: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return for sides the unit vector into their triangle, across the side, (s, 3), and their lengths."""
    flat = surface.triangles.ravel()
    tip, a, b = (surface.vertices[flat[sides // 3 * 3 + (sides % 3 + k) % 3]] for k in range(3))
    length = np.linalg.norm(b - a, axis=1)
    way = (b - a) / np.where(length > 0, length, 1.0)[:, None]
    into = (tip - a) - ((tip - a) * way).sum(axis=1)[:, None] * way
    size = np.linalg.norm(into, axis=1)
    return into / np.where(size > 0, size, 1.0)[:, None], length


def _pairs(
    labels: IntArray, small: BoolArray, edges: list[tuple[IntArray, FloatArray, float]]
) -> list[tuple[IntArray, tuple[int, int]]]:
    """Return for each edge of a line its sides and which two of them stay joined."""
    able = np.flatnonzero(~small[labels])
    able = able if len(able) > 1 else np.arange(len(labels))
    i, j = (able[k] for k in np.triu_indices(len(able), 1))
    kinds, kind = np.unique(np.stack([labels[i], labels[j]], axis=1), axis=0, return_inverse=True)
    kind = kind.reshape(-1)
    # of the pairs of sides of the same two patches each edge takes its smoothest
    smooth = np.array([-(d[i] * d[j]).sum(axis=1) for _, d, _ in edges])
    best = np.stack([smooth[:, kind == k].max(axis=1) for k in range(len(kinds))], axis=1)
    total = (best * np.array([length for *_, length in edges])[:, None]).sum(axis=0)
    winner = int(np.argmax(np.round(total, 9)))
    of = np.flatnonzero(kind == winner)
    take = of[smooth[:, of].argmax(axis=1)]
    return [(sides, (int(i[k]), int(j[k]))) for (sides, _, _), k in zip(edges, take, strict=True)]


def _fins(surface: Surface, sheet: IntArray, extra: IntArray, near: float) -> BoolArray:
    """Return the triangles of sheets that are left over at crowded edges and small, or double another."""
    gone = np.zeros(len(sheet), dtype=np.bool_)
    if not len(extra):
        return gone
    areas = triangle_areas(surface.vertices, surface.triangles)
    size = np.bincount(sheet, areas)
    loose = np.unique(sheet[extra])
    loose = loose[(loose != np.argmax(size)) & (size[loose] <= 0.5 * size.sum())]
    for one in loose[np.argsort(size[loose], kind="stable")]:
        mine = sheet == one
        if size[one] < FIN * size.sum() or _doubles(
            surface, mine, ~mine & ~gone, min(near, _FLAT * float(np.sqrt(size[one])))
        ):
            gone |= mine
    return gone


def _doubles(surface: Surface, mine: BoolArray, others: BoolArray, near: float) -> bool:
    """Return whether all of some triangles lies within a distance of others."""
    points, t = surface.vertices, surface.triangles
    asked = np.concatenate([points[np.unique(t[mine])], points[t[mine]].mean(axis=1)])
    return bool(nearest(asked, points, t[others]).distance.max(initial=0.0) <= near)


def _specks(surface: Surface, sheet: IntArray, joints: IntArray) -> BoolArray:
    """Return the triangles of sheets that touch others in points only and are specks."""
    fan = fans_of(surface.triangles, joints)
    at = np.unique(fan, return_index=True)[1]
    several = np.bincount(surface.triangles.ravel()[at], minlength=len(surface.vertices)) > 1
    touching = np.unique(sheet[several[surface.triangles].any(axis=1)])
    size = np.bincount(sheet, triangle_areas(surface.vertices, surface.triangles))
    small = touching[(size[touching] < SPECK * size.sum()) & (touching != np.argmax(size))]
    return np.asarray(np.isin(sheet, small), dtype=np.bool_)


def _taken_apart(surface: Surface, joints: IntArray) -> Surface:
    """Return the surface with a vertex for each fan: the widest keeps its own, others are moved inwards."""
    t, points = surface.triangles, surface.vertices
    fan = fans_of(t, joints).ravel()
    number, at = np.unique(fan, return_index=True)
    vertex = t.ravel()[at]
    width = np.round(np.bincount(fan, _angles(surface).ravel()), 6)
    order = np.lexsort((at, -width, vertex))
    first = np.ones(len(order), dtype=np.bool_)
    first[1:] = vertex[order][1:] != vertex[order][:-1]
    own = np.empty(len(number), dtype=np.int64)
    own[order] = np.where(first, vertex[order], len(points) + np.cumsum(~first) - 1)
    copied = order[~first]
    if not len(copied):
        return surface
    middles = np.repeat(points[t].mean(axis=1), 3, axis=0)
    count = np.bincount(fan)
    toward = np.stack([np.bincount(fan, middles[:, k]) / count for k in range(3)], axis=1)[copied]
    # the middle of a triangle is two thirds of the way to the other corners
    move = 1.5 * _APART * (toward - points[vertex[copied]])
    height = np.full(len(number), np.inf)
    np.minimum.at(
        height, fan, np.repeat(2.0 * triangle_areas(points, t) / side_lengths(points, t).max(axis=1), 3)
    )
    size = np.linalg.norm(move, axis=1)
    most = np.where(height[copied] > 0, _OF_HEIGHT * height[copied], np.inf)
    move *= np.minimum(1.0, most / np.where(size > 0, size, 1.0))[:, None]
    return replace(
        surface,
        vertices=floats(np.concatenate([points, points[vertex[copied]] + move])),
        triangles=ints(own[fan].reshape(-1, 3)),
    )


def _angles(surface: Surface) -> FloatArray:
    """Return the angle at each corner of the triangles, shape (m, 3), degrees."""
    at = surface.vertices[surface.triangles]
    first, second = np.roll(at, -1, axis=1) - at, np.roll(at, 1, axis=1) - at
    across = np.linalg.norm(np.cross(first, second), axis=2)
    return np.asarray(np.degrees(np.arctan2(across, (first * second).sum(axis=2))), dtype=np.float64)


def _at_crowded(made: Surface, extra: IntArray) -> IntArray:
    """Return those of some triangles that have an edge that is still crowded."""
    edges, sides = edge_table(made.triangles)
    crowded = np.flatnonzero((edge_sharing(sides, len(edges)) > 2)[sides].any(axis=1))
    return np.intersect1d(extra, crowded)


def propose(task: Task) -> list[Change | Refusal]:
    """Return for each fault that is no manifold the fault as one, and what could not be made one."""
    faults = {f.name: f.surface for f in task.model.faults}
    changes: list[Change | Refusal] = []
    for finding in task.findings:
        for name in (n for n in finding.objects if n in faults):
            made = made_manifold(faults[name], task.max_move(name))
            place = finding.places[0] if len(finding.places) else None
            crowded, pinched = trouble(made.surface.triangles)
            if crowded + pinched:
                reason = (
                    f"{plural(crowded, 'edge')} with more than two triangles and "
                    f"{plural(pinched, 'vertex', 'vertices')} where parts touch would stay in {name}, "
                    "whichever sheet is taken away."
                )
                advice = "Split the fault into its sheets by hand."
                changes.append(Refusal("manifold", (name,), reason, advice, place))
            if made.surface is not faults[name] and len(made.surface.triangles):
                size = triangle_areas(faults[name].vertices, faults[name].triangles).sum()
                unit = f"{task.unit}²" if task.unit else ""
                step = Step(
                    "manifold",
                    (name,),
                    finding.count,
                    place,
                    _reason(name, made, size, unit),
                    made.area,
                    unit,
                )
                changes.append(Change({name: (made.surface,)}, (step,)))
    return changes


def _reason(name: str, made: Parted, size: float, unit: str) -> str:
    said = []
    if made.dropped:
        said.append(
            f"{plural(made.dropped, 'triangle')} of fins, specks or a second sheet taken away, "
            f"{amount(made.area, unit)} ({percent(made.area, size)})"
        )
    if made.copies:
        said.append(f"parts that touched in {plural(made.copies, 'vertex', 'vertices')} taken apart")
    return f"In {name}: {'; '.join(said)}."


REPAIR = Repair(
    "manifold",
    ("manifold",),
    "Takes fins away and parts sheets that touch.",
    propose,
)
