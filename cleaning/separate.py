"""separate: faults that touch without meeting in a line are moved apart (answers `pairwise-connected`)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from graben.arrays import BoolArray, FloatArray
from graben.cleaning.parted import (
    MOST_TRIMMED,
    area_of,
    between,
    cut_away,
    facing,
    held_vertices,
    parts_of,
    pieces_of,
    triangle_corners,
    without,
)
from graben.cleaning.repairing import Change, Refusal, Repair, Step, Task, fails
from graben.cleaning.shaping.pushing import Push, clearance, drawn_back, met, pushed, side_of
from graben.cleaning.shaping.trimming import main_part, trimmed
from graben.finding import Finding, Status
from graben.model import Model
from graben.proximity import nearest
from graben.surface import Surface, boundary_edges
from graben.validators.context import Need
from graben.validators.measuring.branch_lines import BranchLines
from graben.validators.measuring.contact import Contact, ContactKind
from graben.validators.measuring.measures import amount, percent

#: Contacts in which neither fault passes through or ends at the other.
TOUCHES = (ContactKind.POINT, ContactKind.LINE, ContactKind.VERTEX, ContactKind.AREA)
#: A crossing shorter than this share of the median edge is a touch: something pokes through by a little.
_POKE = 0.1
#: Width, in median edges of the coarser fault, up to which the area in which two faults touch is a tangency:
#: they part by themselves beyond it.
_TANGENT = 1.0


def propose(task: Task) -> list[Change | Refusal]:
    """Return, for each pair of faults that touch or must not meet, one of them moved off the other."""
    names = [f.name for f in task.model.faults]
    pairs: dict[tuple[str, str], str] = {}
    for finding in task.findings:
        if len(finding.objects) == 2 and set(finding.objects) <= set(names):
            pairs.setdefault((finding.objects[0], finding.objects[1]), finding.check)
    found: list[Change | Refusal] = []
    for pair, check in pairs.items():
        made = _pair(task, pair, check)
        if made is not None:
            found.append(made)
    return found


def _pair(task: Task, pair: tuple[str, str], check: str) -> Change | Refusal | None:
    """Return what is done about two faults; nothing where another repair makes them meet properly."""
    rule = task.rule(*pair)
    if rule in ("accept", "force") or frozenset(pair) in task.vetoed:
        return None
    contacts = between(task.evidence.contacts, task.index(pair[0]), task.index(pair[1]))
    if rule == "forbid":
        return _apart(task, pair, check, contacts)
    edge = min(task.fault(name).surface.median_edge for name in pair)
    touching = _touching(contacts, _POKE * edge)
    if not touching:
        return None
    made = None if _is_wide(task, pair, touching) else _moved(task, pair, check, touching)
    return made or _trimmed(task, pair, check, touching)


def _is_wide(task: Task, pair: tuple[str, str], touching: tuple[Contact, ...]) -> bool:
    """Return whether two faults coincide over more than the strip of a tangency."""
    first, second = (task.fault(name).surface for name in pair)
    edge = max(first.median_edge, second.median_edge)
    for contact in (c for c in touching if c.kind is ContactKind.AREA):
        corners = first.vertices[first.triangles[contact.triangles[0]]].reshape(-1, 3)
        if contact.size > _TANGENT * edge * float(np.linalg.norm(np.ptp(corners, axis=0))):
            return True
    return False


def _touching(contacts: tuple[Contact, ...], poke: float) -> tuple[Contact, ...]:
    """Return the contacts in pieces that are touches and nothing else; crossings of up to ``poke`` are.

    Empty where the rim of one lies on the other elsewhere: a point then is a place where that rim comes back.
    """
    if any(c.kind is ContactKind.T for c in contacts):
        return ()
    touches = [c.kind in TOUCHES or (c.kind is ContactKind.CROSSING and c.size <= poke) for c in contacts]
    others = {c.piece for c, touch in zip(contacts, touches, strict=True) if not touch}
    return tuple(c for c in contacts if c.piece not in others)


def _moved(
    task: Task, pair: tuple[str, str], check: str, touching: tuple[Contact, ...]
) -> Change | Refusal | None:
    """Return the fault that needs the smaller move, moved off the other; nothing for a wide overlap."""
    first, second = (task.fault(name).surface for name in pair)
    clear = clearance(task.contact, first, second)
    before = pieces_of(met(first, second, task.contact))
    tried: list[tuple[float, str, Push]] = []
    short: list[tuple[float, str]] = []
    for own, other in (pair, pair[::-1]):
        if frozenset([own]) in task.vetoed:
            continue
        limit, resting = task.max_move(own), task.fault(other).surface
        for push in _pushes(task, own, other, touching, clear):
            fewer = pieces_of(met(push.surface, resting, task.contact)) < before
            if push.most <= limit and push.sound and fewer:
                tried.append((push.volume, own, push))
                break
            short.append((push.most - limit, own))
    if not tried:
        return (
            None
            if any(c.kind is ContactKind.AREA for c in touching)
            else _refused(task, pair, check, touching, short)
        )
    _, own, push = min(tried, key=lambda t: (t[0], t[1]))
    other = pair[1 - pair.index(own)]
    return Change(
        {own: (push.surface,)}, (_step(task, check, own, other, touching[0].places[0], push, clear),)
    )


def _pushes(task: Task, own: str, other: str, touching: tuple[Contact, ...], clear: float) -> Iterator[Push]:
    """Yield a fault moved off another where they touch: along the normal, and a corner of it drawn back."""
    surface, resting = task.fault(own).surface, task.fault(other).surface
    at = [c.surfaces.index(task.index(own)) for c in touching]
    core = np.zeros(len(surface.vertices), dtype=np.bool_)
    for contact, k in zip(touching, at, strict=True):
        core |= triangle_corners(surface, contact.triangles[k])
    side, held = side_of(surface, resting, np.flatnonzero(core)), held_vertices(task, own, other)
    core = _near(surface, core, touching, clear)
    yield pushed(surface, resting, core, side, clear, held)
    if all(c.kind in (ContactKind.POINT, ContactKind.VERTEX) for c in touching):
        yield drawn_back(surface, core & ~held, clear)


def _near(surface: Surface, core: BoolArray, touching: tuple[Contact, ...], clear: float) -> BoolArray:
    """Return those corners of the triangles in contact that are in contact, or else all of them."""
    places = np.concatenate([np.concatenate([c.places, *c.paths]) for c in touching])
    distance = np.full(len(core), np.inf)
    distance[core] = nearest(
        surface.vertices[core], places, np.repeat(np.arange(len(places))[:, None], 3, axis=1)
    ).distance
    on = core & (distance <= clear)
    return on if on.any() and all(c.kind is not ContactKind.AREA for c in touching) else core


def _apart(
    task: Task, pair: tuple[str, str], check: str, contacts: tuple[Contact, ...]
) -> Change | Refusal | None:
    """Return two faults that must not meet, one of them moved back or trimmed; or what that would take."""
    if not contacts:
        return None
    if all(c.kind in TOUCHES or c.kind is ContactKind.T for c in contacts):
        return _moved(task, pair, check, contacts)
    network = task.evidence.complex
    if network is None:
        return None
    surfaces = [task.fault(name).surface for name in pair]
    clear = clearance(task.contact, *surfaces)
    lines = BranchLines(network, task.contact)
    depth, reach = np.inf, np.inf
    for own, other in (pair, pair[::-1]):
        both = task.fault(own).surface, task.fault(other).surface
        parts = parts_of(network, lines, task.index(own), task.index(other), both)
        for part in parts if len(parts) > 1 else []:
            held = held_vertices(task, own, other)
            depth, reach = (
                min(depth, part.depth - task.max_move(own)),
                min(reach, part.reach - task.max_extension(own)),
            )
            if part.depth + clear > task.max_move(own) or frozenset([own]) in task.vetoed:
                continue
            push = pushed(*both, part.vertices, -part.side, clear, held)
            within = push.sound and push.most <= task.max_move(own)
            if within and not met(push.surface, both[1], task.contact):
                step = _step(task, check, own, other, contacts[0].places[0], push, clear)
                return Change({own: (push.surface,)}, (step,))
        for part in (p for p in parts[1:] if p.vertices.any() and p.reach <= task.max_extension(own)):
            made = without(both[0], part.vertices, facing(both[0], part.vertices, contacts), clear)
            if made is not None and not met(made, both[1], task.contact):
                return cut_away(task, check, own, other, contacts[0].places[0], part.area, part.reach, made)
    least = min(depth, reach)
    needed = float(least) if np.isfinite(least) and least > 0 else None
    return Refusal(
        check,
        pair,
        f"{pair[0]} and {pair[1]} must not meet, but cross further than max_move and max_extension reach.",
        "Move or cut one of the two by hand, or take the rule away.",
        contacts[0].places[0],
        needed,
        task.unit,
    )


def _trimmed(
    task: Task, pair: tuple[str, str], check: str, touching: tuple[Contact, ...]
) -> Change | Refusal:
    """Return the fault that overlaps the other with a minor part at its end without it, or a refusal."""
    wide = [c for c in touching if c.kind is ContactKind.AREA]
    size = sum(c.size for c in wide)
    gap = clearance(task.contact, *(task.fault(name).surface for name in pair))
    options: list[tuple[float, str, float, Surface]] = []
    reaches: list[tuple[float, str, float]] = []
    for own, other in (pair, pair[::-1]):
        surface, resting = task.fault(own).surface, task.fault(other).surface
        distance = nearest(surface.vertices, resting.vertices, resting.triangles).distance
        on = distance <= gap
        rim = np.zeros(len(on), dtype=np.bool_)
        rim[boundary_edges(surface.triangles)] = True
        ends = boundary_edges(surface.triangles)
        inward = nearest(surface.vertices[on], surface.vertices, ends).distance if on.any() else np.zeros(0)
        reach = float(inward.max(initial=0.0)) + surface.median_edge
        share = size / area_of(surface)
        reaches.append((reach - task.max_extension(own), own, share))
        if not (on & rim).any() or share > MOST_TRIMMED or reach > task.max_extension(own):
            continue
        if frozenset([own]) in task.vetoed:
            continue
        made = main_part(trimmed(surface, _beyond(surface, resting, distance, on) - 2.0 * gap))
        lost = area_of(surface) - area_of(made)
        minor = len(made.triangles) > 0 and lost <= 2.0 * MOST_TRIMMED * area_of(surface)
        if minor and pieces_of(met(made, resting, task.contact)) < pieces_of(touching):
            options.append((lost, own, reach, made))
    if options:
        lost, own, reach, made = min(options, key=lambda o: (o[0], o[1]))
        other = pair[1 - pair.index(own)]
        return cut_away(task, check, own, other, touching[0].places[0], lost, reach, made)
    return _wide(task, pair, check, touching, size, reaches)


def _beyond(surface: Surface, resting: Surface, distance: FloatArray, on: BoolArray) -> FloatArray:
    """Return how far vertices lie beyond the rim of the fault on which some (n,) lie, negative within it."""
    within = nearest(surface.vertices, resting.vertices, boundary_edges(resting.triangles)).distance
    return np.where(on, -within, distance)


def _wide(
    task: Task,
    pair: tuple[str, str],
    check: str,
    touching: tuple[Contact, ...],
    size: float,
    reaches: list[tuple[float, str, float]],
) -> Refusal:
    """Return why two faults that overlap are left."""
    needed, own, share = min(reaches)
    area = amount(size, f"{task.unit}²" if task.unit else "")
    return Refusal(
        check,
        pair,
        f"{pair[0]} and {pair[1]} coincide over {area}, {percent(share, 1.0)} of {own}: more than a minor "
        f"part at its end (at most {percent(MOST_TRIMMED, 1.0)} of it, within max_extension).",
        "Keep only one of the two there, or draw their common part as one fault.",
        touching[0].places[0],
        needed if needed > 0 else None,
        task.unit,
    )


def _refused(
    task: Task,
    pair: tuple[str, str],
    check: str,
    touching: tuple[Contact, ...],
    short: list[tuple[float, str]],
) -> Refusal | None:
    """Return why two faults that touch were not moved apart; nothing where both were tried before."""
    if not short:
        return None
    needed, own = min(short)
    limit = amount(task.max_move(own), task.unit)
    why = (
        f"would take {amount(needed, task.unit)} more than max_move = {limit}"
        if needed > 0
        else "makes them meet elsewhere, or what touches there belongs to a third fault as well"
    )
    return Refusal(
        check,
        pair,
        f"{pair[0]} and {pair[1]} touch, and moving {own} off the other {why}.",
        "Move one of the two by hand so that they cross in a line or stay apart.",
        touching[0].places[0],
        needed if needed > 0 else None,
        task.unit,
    )


def _step(task: Task, check: str, own: str, other: str, place: FloatArray, push: Push, clear: float) -> Step:
    reason = (
        f"{own} was moved off {other} by up to {amount(push.most, task.unit)}, to a clearance of "
        f"{amount(clear, task.unit)}, since it takes the smaller change of the two."
    )
    return Step(check, (own,), int((push.moved > 0).sum()), place, reason, push.most, task.unit)


def asks(finding: Finding, model: Model) -> bool:
    """Return whether a finding fails, or warns of two faults that must not meet."""
    forbidden = any(c.rule == "forbid" and set(c.faults) == set(finding.objects) for c in model.contacts)
    return fails(finding, model) or (forbidden and finding.status is Status.WARN)


REPAIR = Repair(
    "separate",
    ("pairwise-connected", "simplicial-complex"),
    "Moves faults that touch, or must not meet, apart.",
    propose,
    Need.COMPLEX,
    asks,
)
