"""self-intersection: a surface does not cross itself."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from graben.arrays import FloatArray, floats, ints
from graben.finding import Element, Part
from graben.surface import Surface, chained
from graben.validators.context import Check, CheckContext, Defect, Tolerance
from graben.validators.measuring.crossings import Crossings, crossings, overlap_parts
from graben.validators.measuring.measures import amount, components, inner_points, largest_parts
from graben.words import plural

#: Depth over the model's size up to which one sheet touches another: above the rounding of coordinates of
#: 5000 km, far below what a file's digits resolve.
TOUCH = 1e-8
#: Ends of lines nearer than this many times that depth are one point of the line of crossing.
JOINED = 10.0


def _run(context: CheckContext) -> list[Defect]:
    touch = context.tolerance("self-intersection", TOUCH * context.model.size)
    found = []
    for surface in context.surfaces:
        crossing = crossings(surface, touch)
        if len(crossing.pairs):
            found.append(_defect(surface, crossing, JOINED * touch, context.unit))
    return found


def _defect(surface: Surface, crossing: Crossings, near: float, unit: str) -> Defect:
    """Return what to say of a surface that crosses or overlaps itself."""
    through = crossing.areas == 0
    lines, paths = _lines(crossing.lines[through], near, unit)
    areas = overlap_parts("overlap", surface, crossing, unit)
    worst = max(lines or areas, key=lambda part: part.value or 0.0)
    said = []
    if lines:
        depth = amount(float(crossing.depths.max()), unit)
        said.append(f"crosses itself: {_crosses(lines, crossing.complete, unit)}, to a depth of {depth}")
    if areas:
        said.append(f"lies upon itself: {_lies(areas, crossing.complete)}")
    return Defect(
        (surface.name,),
        f"{surface.name} {'; it also '.join(said)}.",
        "Take away the sheet that does not belong to it, or give each of the two as a surface of its own.",
        count=len(crossing.pairs),
        value=worst.value,
        unit=worst.unit,
        place=floats(worst.place),
        elements=ints(np.unique(crossing.pairs)),
        element=Element.TRIANGLE,
        places=floats(crossing.lines.mean(axis=1), -1, 3),
        paths=paths,
        parts=lines + areas,
    )


def _crosses(lines: tuple[Part, ...], complete: bool, unit: str) -> str:
    """Return how many triangles pass through each other, and how far, in words."""
    pairs = sum(part.count for part in lines)
    verb = "passes" if pairs == 1 else "pass"
    where = "a line" if len(lines) == 1 else f"{len(lines)} lines, the longest"
    longest = amount(lines[0].value or 0.0, unit)
    least = _least(complete)
    return f"{least}{plural(pairs, 'pair')} of triangles {verb} through each other along {where} of {longest}"


def _lies(areas: tuple[Part, ...], complete: bool) -> str:
    """Return how many triangles lie upon each other, and how much, in words."""
    pairs = sum(part.count for part in areas)
    verb = "lies" if pairs == 1 else "lie"
    total = amount(sum(part.value or 0.0 for part in areas), areas[0].unit)
    return f"{_least(complete)}{plural(pairs, 'pair')} of triangles {verb} upon each other, in {total}"


def _least(complete: bool) -> str:
    return "" if complete else "at least "


def _lines(ends: FloatArray, near: float, unit: str) -> tuple[tuple[Part, ...], tuple[FloatArray, ...]]:
    """Return the connected lines of crossing, the longest first, and their paths.

    Parameters
    ----------
    ends : (p, 2, 3) array
        Ends of the line of each crossing pair.
    near : float
        Ends within this distance are one point.
    """
    if not len(ends):
        return (), ()
    points = ends.reshape(-1, 3)
    node = components(len(points), cKDTree(points).query_pairs(near, output_type="ndarray"))
    steps = node.reshape(-1, 2)
    # two pairs that meet along a side have one line
    once, which = np.unique(np.sort(steps, axis=1), axis=0, return_index=True)
    lengths = np.linalg.norm(ends[which, 1] - ends[which, 0], axis=1)
    group = components(int(node.max()) + 1, steps)
    size = floats(np.bincount(group[once[:, 0]], lengths))
    of_pair = group[steps[:, 0]]
    parts = largest_parts(
        "line of crossing", size, np.bincount(of_pair), inner_points(ends.mean(axis=1), of_pair), unit
    )
    first = np.zeros(int(node.max()) + 1, dtype=np.int64)
    first[node[::-1]] = np.arange(len(points))[::-1]
    chains = chained(ints(once[once[:, 0] != once[:, 1]], -1, 2))
    return parts, tuple(floats(points[first[chain]]) for chain in chains)


CHECK = Check(
    "self-intersection",
    "3",
    "A surface does not cross itself.",
    "Where a fault crosses itself its trace forks, and a point of the horizon lies on both of its sides.",
    _run,
    tolerance=Tolerance(
        "depth up to which one sheet touches the other",
        "model units",
        f"{TOUCH:g} of the model's size",
        lambda model: [TOUCH * model.size],
    ),
    repairable=True,
)
