"""components: pieces of a fault joined, left out or made faults (answers `strongly-connected`)."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from types import MappingProxyType

import numpy as np

from graben.arrays import bools
from graben.cleaning.repairing import Change, Refusal, Repair, Step, Task
from graben.cleaning.seams import CHECK, Pieces, pieces_by_size, sewn_together
from graben.cleaning.shaping.bridging import Bridge, beyond, boxes_near, bridged
from graben.cleaning.shaping.limits import joined
from graben.cleaning.shaping.trimming import part_of
from graben.proximity import nearest
from graben.surface import Surface
from graben.validators.measuring.measures import amount, areas_of, centroids, percent
from graben.validators.self_intersection import TOUCH
from graben.words import plural

#: A piece smaller than this share of the fault's area is a speck.
SPECK = 0.01
#: So many pieces, the largest, are joined to each other; no fault is made of more than a few.
_MOST_JOINED = 24


def _propose(task: Task) -> Sequence[Change | Refusal]:
    """Return each fault in one piece, what does not belong to it left out or as faults of their own."""
    taken = {s.name for s in task.model.surfaces}
    named = {name for finding in task.findings for name in finding.objects}
    made: list[Change | Refusal] = []
    for fault in task.model.faults:
        if fault.name not in named or frozenset([fault.name]) in task.vetoed:
            continue
        change = _of_fault(task, fault.surface, taken)
        if change is not None:
            taken |= {s.name for s in change.surfaces[fault.name]}
            made.append(change)
    return made


def _of_fault(task: Task, surface: Surface, taken: set[str]) -> Change | None:
    """Return a fault in one piece; None where it is."""
    name = surface.name
    surface, steps = _without_specks(task, surface)
    surface, seams = sewn_together(task, surface)
    surface, strips, joins, why = _joined(task, surface)
    parts, splits = _split(task, surface, taken, why)
    steps = [*steps, *seams, *joins, *splits]
    if not steps:
        return None
    declared = {name: strips} if strips is not None else {}
    return Change({name: parts}, tuple(steps), MappingProxyType(declared))


def _without_specks(task: Task, surface: Surface) -> tuple[Surface, list[Step]]:
    """Return a surface without its pieces of no size."""
    pieces = pieces_by_size(surface)
    total = float(pieces.areas.sum())
    specks = np.flatnonzero(pieces.areas < SPECK * total)
    specks = specks[specks > 0]
    if not len(specks):
        return surface, []
    away = bools(np.isin(pieces.label, specks))
    area = float(pieces.areas[specks].sum())
    place = centroids(surface.vertices, surface.triangles[away])[0]
    each = " each" if len(specks) > 1 else ""
    reason = (
        f"{plural(len(specks), 'piece')} of {surface.name} of less than {SPECK:.0%} of its area{each} "
        f"{'was' if len(specks) == 1 else 'were'} left out: {_area(area, task)}, "
        f"{percent(area, total)} of it."
    )
    step = Step(CHECK, (surface.name,), int(away.sum()), place, reason, area, _square(task))
    return part_of(surface, bools(~away)), [step]


def _joined(task: Task, surface: Surface) -> tuple[Surface, Surface | None, list[Step], dict[int, str]]:
    """Return a surface with pieces joined by strips, all strips, and why other pieces were not joined.

    The last by the piece of the result, in words.
    """
    limit = task.max_extension(surface.name)
    touch = task.model.checks.get("self-intersection", TOUCH * task.model.size)
    strips: Surface | None = None
    steps: list[Step] = []
    while True:
        pieces = pieces_by_size(surface)
        tried = _tried(surface, pieces, limit, touch, task.unit)
        good = {pair: bridge for pair, bridge in tried.items() if not bridge.problem}
        if not good:
            break
        # the narrowest gap first: what is joined then faces more
        pair = min(good, key=lambda p: (good[p].gap, p))
        bridge = good[pair]
        assert bridge.strip is not None
        steps.append(_join_step(task, surface.name, pieces, pair, bridge))
        surface = bridge.surface
        strips = bridge.strip if strips is None else joined(strips, bridge.strip)
    why = {k: _reason(surface, pieces, k, tried, task) for k in range(1, len(pieces.areas))}
    return surface, strips, steps, why


def _reason(
    surface: Surface, pieces: Pieces, piece: int, tried: dict[tuple[int, int], Bridge], task: Task
) -> str:
    """Return why a piece of a surface was not joined to another, in words."""
    own = surface.triangles[pieces.label == piece]
    others = surface.triangles[pieces.label != piece]
    apart = float(nearest(surface.vertices[np.unique(own)], surface.vertices, others).distance.min())
    limit = task.max_extension(surface.name)
    if apart > limit:
        return f"it lies {amount(apart, task.unit)} from the rest, {beyond(limit, task.unit)}"
    known = [bridge for pair, bridge in tried.items() if piece in pair]
    if not known:
        return f"it is one of more than {_MOST_JOINED}"
    bridge = min(known, key=lambda b: b.gap)
    return f"of it and the piece nearest to it, {bridge.problem}"


def _tried(
    surface: Surface, pieces: Pieces, limit: float, touch: float, unit: str
) -> dict[tuple[int, int], Bridge]:
    """Return what joining comes to for each two pieces that are near each other, the larger first."""
    masks = [bools(pieces.label == k) for k in range(min(len(pieces.areas), _MOST_JOINED))]
    return {
        (i, j): bridged(surface, masks[i], masks[j], limit, touch, unit)
        for i, j in combinations(range(len(masks)), 2)
        if boxes_near(surface, masks[i], masks[j], limit)
    }


def _join_step(task: Task, name: str, pieces: Pieces, pair: tuple[int, int], bridge: Bridge) -> Step:
    """Return what is said of a strip."""
    assert bridge.strip is not None
    strip, (first, second) = bridge.strip, pieces.areas[list(pair)]
    turned = " The smaller one was turned to agree with the other." if bridge.flipped else ""
    area = float(areas_of(strip).sum())
    reason = (
        f"Two pieces of {name}, of {_area(first, task)} and {_area(second, task)}, were joined by a strip of "
        f"{plural(len(strip.triangles), 'triangle')} and {_area(area, task)} along "
        f"{amount(bridge.length, task.unit)}, since their rims face each other no more than "
        f"{amount(bridge.gap, task.unit)} apart.{turned}"
    )
    place = strip.vertices[len(strip.vertices) // 2]
    return Step(CHECK, (name,), len(strip.triangles), place, reason, bridge.gap, task.unit)


def _split(
    task: Task, surface: Surface, taken: set[str], why: dict[int, str]
) -> tuple[tuple[Surface, ...], list[Step]]:
    """Return each piece of a surface as a surface, the largest under its name, the others under free ones."""
    pieces = pieces_by_size(surface)
    if len(pieces.areas) == 1:
        return (surface,), []
    names, total = set(taken), float(pieces.areas.sum())
    parts, steps = [part_of(surface, bools(pieces.label == 0))], []
    for piece in range(1, len(pieces.areas)):
        name = _free_name(surface.name, names)
        names.add(name)
        part = part_of(surface, bools(pieces.label == piece))
        parts.append(Surface(name, part.vertices, part.triangles, part.lines, part.file))
        area = float(pieces.areas[piece])
        reason = (
            f"A piece of {surface.name}, {_area(area, task)} and {percent(area, total)} of it, was made a "
            f"fault of its own, {name}: {why[piece]}."
        )
        place = centroids(part.vertices, part.triangles)[0]
        steps.append(Step(CHECK, (surface.name,), len(part.triangles), place, reason, area, _square(task)))
    return tuple(parts), steps


def _free_name(name: str, taken: set[str]) -> str:
    """Return the name of a further part of a fault that no surface has."""
    return next(f"{name} ({k})" for k in range(2, len(taken) + 3) if f"{name} ({k})" not in taken)


def _square(task: Task) -> str:
    return f"{task.unit}²" if task.unit else ""


def _area(area: float, task: Task) -> str:
    return amount(area, _square(task))


REPAIR = Repair(
    "components",
    (CHECK,),
    "Joins the pieces of a fault across narrow gaps, leaves specks out, and makes other pieces faults.",
    _propose,
)
