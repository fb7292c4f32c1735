"""The parts into which one fault is cut by another, with what each would take to be moved or removed."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from graben.arrays import BoolArray, FloatArray, IntArray, floats
from graben.cleaning.repairing import Change, Step, Task
from graben.cleaning.shaping.pushing import heights
from graben.cleaning.shaping.shared import among, shared_vertices
from graben.cleaning.shaping.trimming import main_part, trimmed
from graben.complexes import Complex
from graben.proximity import nearest
from graben.surface import Surface, triangle_areas
from graben.validators.measuring.branch_lines import BranchLines
from graben.validators.measuring.contact import Contact
from graben.validators.measuring.measures import amount, percent

#: Share of a fault's area up to which the part that meets another fault wrongly is cut away.
MOST_TRIMMED = 0.1


@dataclass(frozen=True, eq=False)
class PartOf:
    """A part of a fault on one side of the lines in which it meets another.

    Parameters
    ----------
    vertices : (n,) array
        Which vertices of the fault lie in it, off the lines.
    area : float
        Square model units.
    depth : float
        How far its vertices lie off the other fault, at most, model units.
    reach : float
        How far they lie from the lines, at most, model units.
    side : float
        On which side of the other fault it lies on the whole, see ``pushing.side_of``.
    """

    vertices: BoolArray
    area: float
    depth: float
    reach: float
    side: float


def parts_of(
    network: Complex, lines: BranchLines, own: int, other: int, surfaces: tuple[Surface, Surface]
) -> list[PartOf]:
    """Return the parts of a fault cut along another, the largest first; one where it is not cut through.

    Parameters
    ----------
    network : Complex
        Of all faults.
    lines : BranchLines
        Of the same.
    own, other : int
        Owner numbers in it.
    surfaces : tuple of two Surface
        The fault and the other one.
    """
    label = lines.parts(own, other)
    mine = np.flatnonzero(label >= 0)
    areas = np.bincount(
        label[mine], triangle_areas(network.vertices, network.triangles[mine]), minlength=label.max() + 1
    )
    on_line = line_points(network, own, other)
    found = []
    for part in np.argsort(-areas, kind="stable"):
        corners = np.unique(network.triangles[mine[label[mine] == part]])
        points = network.vertices[corners]
        away = heights(points, surfaces[1])
        reach = np.zeros(1)
        if len(on_line):
            reach = nearest(
                points, on_line.reshape(-1, 3), np.arange(2 * len(on_line)).reshape(-1, 2)
            ).distance
        inside = among(surfaces[0].vertices, points[~among(points, on_line.reshape(-1, 3))])
        found.append(
            PartOf(
                inside,
                float(areas[part]),
                float(np.abs(away).max()),
                float(reach.max()),
                1.0 if away.sum() >= 0 else -1.0,
            )
        )
    return found


def line_points(network: Complex, own: int, other: int) -> FloatArray:
    """Return the ends of the edges that two surfaces of a complex share, shape (e, 2, 3), model units."""
    edges, sides = network.edges()
    mine, theirs = (np.unique(sides[network.owner == k]) for k in (own, other))
    return floats(network.vertices[edges[np.intersect1d(mine, theirs)]], -1, 2, 3)


def pieces_of(found: tuple[Contact, ...]) -> int:
    """Return in how many pieces two faults meet."""
    return len({c.piece for c in found})


def between(found: tuple[Contact, ...], first: int, second: int) -> tuple[Contact, ...]:
    """Return the contacts of two faults of a model, in the order of their pieces."""
    pair = (min(first, second), max(first, second))
    return tuple(c for c in found if c.surfaces == pair)


def triangle_corners(surface: Surface, triangles: IntArray) -> BoolArray:
    """Return which vertices of a surface are corners of some of its triangles, shape (n,)."""
    chosen = np.zeros(len(surface.vertices), dtype=np.bool_)
    chosen[surface.triangles[triangles]] = True
    return chosen


def area_of(surface: Surface) -> float:
    """Return the area of a surface, square model units."""
    return float(triangle_areas(surface.vertices, surface.triangles).sum())


def held_vertices(task: Task, own: str, other: str) -> BoolArray:
    """Return the vertices of a fault that it shares with faults other than a certain one, shape (n,)."""
    others = [f.surface for f in task.model.faults if f.name not in (own, other)]
    return shared_vertices(task.fault(own).surface, others)


def without(surface: Surface, away: BoolArray, line: FloatArray, gap: float) -> Surface | None:
    """Return a surface without a part of it, cut a gap before the line at which that begins.

    Parameters
    ----------
    surface : Surface
        The fault.
    away : (n,) array
        The vertices of the part.
    line : (s, 2, 3) array
        The ends of the segments of that line, in any order.
    gap : float
        How far before the line it is to end, model units.

    Returns
    -------
    Surface or None
        None where nothing or no single part would be left.
    """
    steps = np.arange(2 * len(line)).reshape(-1, 2)
    far = nearest(surface.vertices, line.reshape(-1, 3), steps).distance
    kept = trimmed(surface, np.where(away, -far - gap, far - gap))
    main = main_part(kept)
    lost = area_of(kept) - area_of(main)
    return main if len(main.triangles) and lost <= MOST_TRIMMED * area_of(surface) else None


def facing(surface: Surface, away: BoolArray, contacts: Iterable[Contact]) -> FloatArray:
    """Return the segments (s, 2, 3) of the line at which a part of a surface begins: that nearest to it.

    ``away`` (n,) are the vertices of the part; the contacts have a line at least.
    """
    paths = [path for c in contacts for path in c.paths]
    triangles = surface.triangles[away[surface.triangles].any(axis=1)]
    means = [nearest(p, surface.vertices, triangles).distance.mean() for p in paths]
    path = paths[int(np.argmin(means))]
    return np.stack([path[:-1], path[1:]], axis=1)


def cut_away(
    task: Task, check: str, own: str, other: str, place: FloatArray, area: float, reach: float, made: Surface
) -> Change:
    """Return a fault without the part that meets another, as a change with its sizes."""
    unit = f"{task.unit}²" if task.unit else ""
    reason = (
        f"The part of {own} that meets {other} was cut away: {amount(area, unit)}, "
        f"{percent(area, area_of(task.fault(own).surface))} of it, up to {amount(reach, task.unit)} beyond."
    )
    count = int((~among(task.fault(own).surface.vertices, made.vertices)).sum())
    return Change({own: (made,)}, (Step(check, (own,), count, place, reason, area, unit),))
