"""pieces: faults that meet in several pieces made to meet in one (answers `pairwise-connected`)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from graben.arrays import FloatArray, IntArray, floats
from graben.cleaning.parted import (
    MOST_TRIMMED,
    PartOf,
    area_of,
    between,
    cut_away,
    facing,
    held_vertices,
    parts_of,
    pieces_of,
    without,
)
from graben.cleaning.repairing import Change, Refusal, Repair, Step, Task
from graben.cleaning.shaping.pushing import clearance, met, pushed
from graben.cleaning.shaping.trimming import divided
from graben.finding import Finding
from graben.proximity import nearest
from graben.surface import Surface, strong_components, triangle_normals
from graben.validators.context import Need
from graben.validators.measuring.branch_lines import BranchLines
from graben.validators.measuring.contact import Contact, ContactKind
from graben.validators.measuring.measures import amount, percent
from graben.words import plural

#: Gap left where a fault is cut back before another, over its median edge: triangles along the cut then stay
#: clear of the other fault through later repairs.
_GAP = 0.2
#: Kinds of contacts that are lines in which a fault can be parted.
_LINES = (ContactKind.CROSSING, ContactKind.EDGE)


@dataclass(frozen=True, eq=False)
class _Pair:
    """Two faults that meet wrongly: names, the check's id, where they meet, and the lines of all faults."""

    names: tuple[str, str]
    check: str
    contacts: tuple[Contact, ...]
    lines: BranchLines

    @property
    def place(self) -> FloatArray:
        """Where the second piece is, or the only one, shape (3,)."""
        return floats(next((c for c in self.contacts if c.piece == 1), self.contacts[0]).places[0])

    def ways(self) -> Iterator[tuple[str, str]]:
        """Yield the pair as the fault that changes and the one that stays, both ways."""
        yield self.names
        yield self.names[::-1]


def propose(task: Task) -> list[Change | Refusal]:
    """Return, for each pair that meets in several pieces, a fork or a ring, what makes it one line."""
    network = task.evidence.complex
    if network is None:
        return []
    lines = BranchLines(network, task.contact)
    found = [_pair(task, finding, lines) for finding in task.findings]
    return [made for made in found if made is not None]


def _pair(task: Task, finding: Finding, lines: BranchLines) -> Change | Refusal | None:
    """Return what is done about a pair: a move, else a trim, else a split, else what that would take."""
    first, second = finding.objects
    if task.rule(first, second) in ("accept", "forbid") or frozenset((first, second)) in task.vetoed:
        return None
    contacts = between(task.evidence.contacts, task.index(first), task.index(second))
    on_rim = len({c.piece for c in contacts if c.kind is ContactKind.T})
    if on_rim > 1 or not any(c.kind in _LINES for c in contacts):
        return _on_rims(task, finding, contacts)
    pair = _Pair((first, second), finding.check, contacts, lines)
    parts = {
        own: parts_of(
            task.evidence.complex,
            lines,
            task.index(own),
            task.index(other),
            (task.fault(own).surface, task.fault(other).surface),
        )
        for own, other in pair.ways()
        if task.evidence.complex is not None
    }
    return (
        _moved(task, pair, parts)
        or _trimmed(task, pair, parts)
        or _split(task, pair)
        or _left(task, pair, parts)
    )


def _on_rims(task: Task, finding: Finding, contacts: tuple[Contact, ...]) -> Refusal | None:
    """Return that a rim which lies on another fault in several pieces is no matter of this repair."""
    rims = [c for c in contacts if c.kind is ContactKind.T]
    if not rims:
        return None
    size = amount(sum(c.size for c in rims), task.unit)
    first, second = finding.objects
    return Refusal(
        finding.check,
        (first, second),
        f"A rim lies on the other fault on and off, in {plural(len({c.piece for c in rims}), 'piece')} of "
        f"{size} in all and {plural(len({c.piece for c in contacts}), 'contact')}: none of them is a second "
        "line to take away.",
        "Put the whole rim on the other fault, or move it clearly off it.",
        contacts[0].places[0],
    )


def _candidates(
    task: Task, pair: _Pair, parts: dict[str, list[PartOf]], largest: bool = False
) -> Iterator[tuple[str, str, PartOf]]:
    """Yield the parts that may change, with their fault and the other; the largest of each if asked for."""
    for own, other in pair.ways():
        cut = parts[own] if len(parts[own]) > 1 and frozenset([own]) not in task.vetoed else []
        for part in cut[0 if largest else 1 :]:
            if part.vertices.any():
                yield own, other, part


def _moved(task: Task, pair: _Pair, parts: dict[str, list[PartOf]]) -> Change | None:
    """Return the pair with a shallow part pushed back through the other fault, the cheapest that helps."""
    before = _pieces(task, pair)
    clear = clearance(task.contact, *(task.fault(name).surface for name in pair.names))
    options = sorted(
        (
            (part.depth * part.area, own, other, part)
            for own, other, part in _candidates(task, pair, parts, largest=True)
            if part.depth + clear <= task.max_move(own)
        ),
        key=lambda option: option[:3],
    )
    for _, own, other, part in options:
        surface, resting = task.fault(own).surface, task.fault(other).surface
        push = pushed(surface, resting, part.vertices, -part.side, clear, held_vertices(task, own, other))
        if (
            push.most > task.max_move(own)
            or not push.sound
            or pieces_of(met(push.surface, resting, task.contact)) >= before
        ):
            continue
        reason = (
            f"A part of {own} of {_squared(part.area, task)} that passed through {other} to a depth of "
            f"{amount(part.depth, task.unit)} was moved back by up to {amount(push.most, task.unit)}, to a "
            f"clearance of {amount(clear, task.unit)}."
        )
        count = int((push.moved > 0).sum())
        step = Step(pair.check, (own,), count, pair.place, reason, push.most, task.unit)
        return Change({own: (push.surface,)}, (step,))
    return None


def _trimmed(task: Task, pair: _Pair, parts: dict[str, list[PartOf]]) -> Change | None:
    """Return the pair with the smallest part cut away that is small enough, and whose loss helps."""
    before = _pieces(task, pair)
    options = sorted(
        (
            (part.area, own, other, part)
            for own, other, part in _candidates(task, pair, parts)
            if part.reach <= task.max_extension(own)
            and part.area <= MOST_TRIMMED * area_of(task.fault(own).surface)
        ),
        key=lambda option: option[:3],
    )
    for _, own, other, part in options:
        surface, resting = task.fault(own).surface, task.fault(other).surface
        clear = max(clearance(task.contact, surface, resting), _GAP * surface.median_edge)
        made = without(surface, part.vertices, facing(surface, part.vertices, pair.contacts), clear)
        if made is not None and 0 < pieces_of(met(made, resting, task.contact)) < before:
            lost = area_of(surface) - area_of(made)
            return cut_away(task, pair.check, own, other, pair.place, lost, part.reach, made)
    return None


def _split(task: Task, pair: _Pair) -> Change | None:
    """Return the pair with the fault that bends more divided halfway between its two longest pieces."""
    paths = [_longest(pair.contacts, piece) for piece in (0, 1)]
    if any(path is None for path in paths):
        return None
    near = [path for path in paths if path is not None]
    ways = sorted(pair.ways(), key=lambda way: _bend(task.fault(way[0]).surface, near))
    for own, other in ways:
        made = None if frozenset([own]) in task.vetoed else _halves(task, pair, own, other, near)
        if made is not None:
            return made
    return None


def _halves(task: Task, pair: _Pair, own: str, other: str, near: list[FloatArray]) -> Change | None:
    """Return a fault divided between two pieces, if each half is in one part and meets the other less."""
    surface, resting = task.fault(own).surface, task.fault(other).surface
    away = [nearest(surface.vertices, p, _steps(p)).distance for p in near]
    held = held_vertices(task, own, "")
    first, second = divided(surface, away[1] - away[0], held)
    if any(not len(s.triangles) or strong_components(s.triangles).max() > 0 for s in (first, second)):
        return None
    counts = [pieces_of(met(s, resting, task.contact)) for s in (first, second)]
    if max(counts) >= _pieces(task, pair):
        return None
    if area_of(second) > area_of(first):
        first, second = second, first
    name = _free_name(own, [f.name for f in task.model.faults])
    share = percent(area_of(second), area_of(surface))
    reason = (
        f"{own} bends through {other} twice, {amount(_apart(near), task.unit)} apart: it was split halfway "
        f"into {own} and {name}, the latter of {_squared(area_of(second), task)}, {share} of it, with common "
        "edges."
    )
    step = Step(pair.check, (own,), 2, pair.place, reason, area_of(second), _unit(task))
    return Change({own: (first, replace(second, name=name))}, (step,))


def _left(task: Task, pair: _Pair, parts: dict[str, list[PartOf]]) -> Refusal:
    """Return what the cheapest repair of a pair would take beyond its limits."""
    first, second = pair.names
    options = list(_candidates(task, pair, parts))
    if not options:
        return Refusal(
            pair.check,
            pair.names,
            f"Neither {first} nor {second} is cut through by the lines in which they meet, and splitting one "
            "of them between the lines leaves as many.",
            "Cut one of the two by hand so that they meet in one line.",
            pair.place,
        )
    own, _, part = min(options, key=lambda o: o[2].depth - task.max_move(o[0]))
    return Refusal(
        pair.check,
        pair.names,
        f"The smallest part of {own} beyond such a line is {_squared(part.area, task)} and "
        f"{amount(part.depth, task.unit)} deep (max_move = {amount(task.max_move(own), task.unit)}) and "
        f"reaches {amount(part.reach, task.unit)} from it (max_extension = "
        f"{amount(task.max_extension(own), task.unit)}); moving, cutting or splitting it within these did "
        "not leave one line.",
        f"Cut that part of {own} away or split it by hand, or raise max_move or max_extension in [repair].",
        pair.place,
        max(0.0, part.depth - task.max_move(own)),
        task.unit,
    )


def _pieces(task: Task, pair: _Pair) -> int:
    """Return in how many pieces a pair meets; one more where one piece forks or is closed."""
    return max(pieces_of(pair.contacts), 2)


def _longest(contacts: tuple[Contact, ...], piece: int) -> FloatArray | None:
    paths = [p for c in contacts if c.piece == piece for p in c.paths]
    return max(paths, key=lambda p: float(np.linalg.norm(np.diff(p, axis=0), axis=1).sum()), default=None)


def _bend(surface: Surface, near: list[FloatArray]) -> float:
    """Return the cosine between the mean normals of a surface along two lines."""
    normals = triangle_normals(surface.vertices, surface.triangles)
    means = [normals[nearest(p, surface.vertices, surface.triangles).simplex].sum(axis=0) for p in near]
    sizes = [float(np.linalg.norm(m)) for m in means]
    return float(means[0] @ means[1]) / max(sizes[0] * sizes[1], np.finfo(float).tiny)


def _apart(near: list[FloatArray]) -> float:
    """Return how far two lines are apart, at least, model units."""
    return float(nearest(near[1], near[0], _steps(near[0])).distance.min())


def _steps(path: FloatArray) -> IntArray:
    return np.stack([np.arange(len(path) - 1), np.arange(1, len(path))], axis=1)


def _free_name(name: str, taken: list[str]) -> str:
    """Return the name of a second part of a fault that no fault has."""
    return next(f"{name} ({k})" for k in range(2, len(taken) + 3) if f"{name} ({k})" not in taken)


def _unit(task: Task) -> str:
    return f"{task.unit}²" if task.unit else ""


def _squared(area: float, task: Task) -> str:
    return amount(area, _unit(task))


REPAIR = Repair(
    "pieces",
    ("pairwise-connected",),
    "Makes two faults that meet in several pieces meet in one.",
    propose,
    Need.COMPLEX,
)
