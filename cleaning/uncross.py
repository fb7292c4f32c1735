"""uncross: a fault that crosses or lies upon itself made one sheet (answers `self-intersection`).

The cheapest repair that works is taken: vertices that have passed their neighbours are put back among them;
a sheet that passes through another by little is moved back; a layer that lies upon another, or a flap beyond
the line of crossing, is taken away.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from graben.arrays import BoolArray, FloatArray
from graben.cleaning.parted import area_of, without
from graben.cleaning.repairing import Change, Refusal, Repair, Step, Task
from graben.cleaning.shaping.limits import distances
from graben.cleaning.shaping.pushing import CLEAR, harmonic, heights, pushed, rings
from graben.cleaning.shaping.selfcut import (
    SLIVER,
    around,
    crossing_edges,
    patches,
    self_refined,
    sheets,
    without_patch,
)
from graben.cleaning.shaping.shared import among, shared_vertices
from graben.cleaning.shaping.trimming import main_part, part_of
from graben.surface import Surface, boundary_edges, strong_components, triangle_areas, triangle_normals
from graben.validators.measuring.crossings import Crossings, crossings
from graben.validators.measuring.measures import amount, percent, smallest_angles
from graben.validators.self_intersection import TOUCH

#: Share of a fault's area up to which a flap or a layer is taken away.
MOST_DROPPED = 0.2
#: Rings of triangles around those that cross whose vertices are put back among their neighbours, in turn.
_RINGS = (0, 1, 2)
#: Rings around what crosses a sheet that stand for the other sheet.
_OTHER_RINGS = 3
#: Patches that are looked at one by one, the smallest first.
_MOST_PATCHES = 60
#: Share of the least angle of a fault with slivers that they must keep: they are no matter of this repair.
_KEPT_ANGLE = 0.5
#: Gap left before the line at which a flap was cut away, over the median edge.
_GAP = 0.1


@dataclass(frozen=True, eq=False)
class _Place:
    """A fault that crosses itself: its surface, where it does, and which vertices must stay."""

    task: Task
    name: str
    surface: Surface
    touch: float
    found: Crossings
    held: BoolArray

    def trouble(self, surface: Surface) -> int:
        """Return how many pairs of triangles of a surface cross or overlap."""
        return len(crossings(surface, self.touch).pairs)

    def within(self, surface: Surface) -> bool:
        """Return whether a surface lies within max_move of the reference and has no slivers."""
        reference = self.task.references[self.name]
        before = float(smallest_angles(self.surface.vertices, self.surface.triangles).min())
        least = min(SLIVER, _KEPT_ANGLE * before)
        sound = smallest_angles(surface.vertices, surface.triangles).min(initial=90.0) >= least
        return bool(
            sound and distances(surface, [reference]).max(initial=0.0) <= self.task.max_move(self.name)
        )

    def change(self, surface: Surface, count: int, reason: str, size: float | None, unit: str) -> Change:
        """Return a change of this fault with its one step."""
        place = self.found.lines.mean(axis=1)[int(np.argmax(self.found.depths))]
        step = Step("self-intersection", (self.name,), count, place, reason, size, unit)
        return Change({self.name: (surface,)}, (step,))


def propose(task: Task) -> list[Change | Refusal]:
    """Return each fault that crosses itself as one sheet, or why it is left."""
    faults = {f.name for f in task.model.faults}
    touch = float(task.model.checks.get("self-intersection", TOUCH * task.model.size))
    proposals: list[Change | Refusal] = []
    for name in dict.fromkeys(f.objects[0] for f in task.findings):
        if name not in faults or frozenset([name]) in task.vetoed:
            continue
        surface = task.fault(name).surface
        found = crossings(surface, touch)
        if len(found.pairs):
            held = shared_vertices(surface, [f.surface for f in task.model.faults])
            proposals.append(_answer(_Place(task, name, surface, touch, found, held)))
    return proposals


def _answer(place: _Place) -> Change | Refusal:
    return (
        _put_back(place)
        or _sheets_apart(place)
        or _flap_pushed(place)
        or _layer_dropped(place)
        or _flap_dropped(place)
        or _left(place)
    )


def _put_back(place: _Place) -> Change | None:
    """Return the fault with the vertices of what crosses amid their neighbours, if that is enough."""
    surface = place.surface
    core = np.zeros(len(surface.vertices), dtype=np.bool_)
    core[surface.triangles[np.unique(place.found.pairs)]] = True
    rim = np.zeros(len(core), dtype=np.bool_)
    rim[boundary_edges(surface.triangles)] = True
    for count in _RINGS:
        free = rings(surface.triangles, core, count) & ~rim & ~place.held
        if not free.any():
            continue
        given = ~free
        made = surface.with_vertices(harmonic(surface.triangles, surface.vertices, given, free))
        if place.within(made) and place.trouble(made) == 0:
            moved = np.linalg.norm(made.vertices - surface.vertices, axis=1)
            reason = (
                f"Vertices of {place.name} that had passed their neighbours were put back among them, by up "
                f"to {amount(float(moved.max()), place.task.unit)}: no area is lost, and the rim stays."
            )
            return place.change(made, int((moved > 0).sum()), reason, None, "")
    return None


def _sheets_apart(place: _Place) -> Change | None:
    """Return the fault with sheets that are not joined, and hardly cross each other, moved apart."""
    surface = place.surface
    label = strong_components(surface.triangles)
    if label.max() == 0:
        return None
    size = np.bincount(label, triangle_areas(surface.vertices, surface.triangles))
    crossed = np.unique(label[place.found.pairs])
    made = []
    for sheet in sorted((int(k) for k in crossed), key=lambda k: float(size[k])):
        own = np.asarray(label == sheet, dtype=np.bool_)
        partners = np.zeros(len(own), dtype=np.bool_)
        partners[np.unique(place.found.pairs)] = True
        made.append(_pushed(place, own, around(surface, partners & ~own, _OTHER_RINGS) & ~own))
    return _least(made)


def _least(made: list[Change | None]) -> Change | None:
    """Return the change with the smallest move, the first of equal ones."""
    return min((c for c in made if c is not None), key=lambda c: c.steps[0].size or 0.0, default=None)


def _pushed(place: _Place, own: BoolArray, other: BoolArray) -> Change | None:
    """Return the fault with some triangles moved to the side of others on which they mostly lie."""
    surface = place.surface
    if not own.any() or not other.any():
        return None
    clear = CLEAR * place.touch
    part, rest = part_of(surface, own), part_of(surface, other)
    corners = np.unique(surface.triangles[own])
    above = heights(part.vertices, rest)
    side = 1.0 if above.sum() >= 0 else -1.0
    crossing = np.isin(np.flatnonzero(own), place.found.pairs)
    concerned = np.zeros(len(part.vertices), dtype=np.bool_)
    concerned[part.triangles[crossing]] = True
    core = concerned & (side * above < clear)
    core = core if core.any() else concerned
    push = pushed(part, rest, core, side, clear, place.held[corners] | _joined(surface, own)[corners])
    vertices = surface.vertices.copy()
    vertices[corners] = push.surface.vertices
    made = surface.with_vertices(vertices)
    if not 0.0 < push.most <= place.task.max_move(place.name) or not place.within(made):
        return None
    if place.trouble(made) >= len(place.found.pairs):
        return None
    unit = place.task.unit
    depth = amount(float(place.found.depths.max()), unit)
    reason = (
        f"A sheet of {place.name} that passed through another by {depth} "
        f"was moved back to its side by up to {amount(push.most, unit)}: nothing is cut away for so little."
    )
    return place.change(made, int((push.moved > 0).sum()), reason, push.most, unit)


def _joined(surface: Surface, own: BoolArray) -> BoolArray:
    """Return the vertices at which some triangles of a surface are joined to the others, shape (n,)."""
    both = np.zeros((2, len(surface.vertices)), dtype=np.bool_)
    both[0, surface.triangles[own]] = True
    both[1, surface.triangles[~own]] = True
    return np.asarray(both.all(axis=0), dtype=np.bool_)


def _flap_pushed(place: _Place) -> Change | None:
    """Return the fault with a shallow flap beyond a line of crossing moved back through it."""
    if place.found.areas.any():
        return None
    pushes = []
    for flap, _ in _flaps(place):
        own = np.asarray(flap[place.surface.triangles].any(axis=1), dtype=np.bool_)
        own = around(place.surface, own, 1)
        partners = np.zeros(len(own), dtype=np.bool_)
        partners[np.unique(place.found.pairs)] = True
        other = around(place.surface, partners & ~own, _OTHER_RINGS) & ~around(place.surface, own, 0)
        pushes.append(_pushed(place, own, other))
    return _least(pushes)


def _layer_dropped(place: _Place) -> Change | None:
    """Return the fault without the smaller of two layers that lie upon each other."""
    surface, flat = place.surface, place.found.areas > 0
    if not flat.any():
        return None
    upon = np.zeros(len(surface.triangles), dtype=np.bool_)
    upon[place.found.pairs[flat]] = True
    layer = sheets(surface, upon)
    left = [
        main_part(part_of(surface, np.asarray(layer != k, dtype=np.bool_))) for k in range(layer.max() + 1)
    ]
    for made in sorted(left, key=area_of, reverse=True):
        change = _dropped(place, made, "layer that lay upon it")
        if change is not None:
            return change
    return None


def _flap_dropped(place: _Place) -> Change | None:
    """Return the fault without a flap beyond the line in which it crosses itself, the least that helps."""
    surface = place.surface
    edge = surface.median_edge
    options: list[tuple[float, int, Surface]] = []
    rim = _rim_length(surface)
    for number, (flap, sheet) in enumerate(_flaps(place)):
        for made in (sheet, _cut_back(place, flap, edge)):
            if made is None or not len(made.triangles) or not place.within(made):
                continue
            lost = area_of(surface) - area_of(made)
            if lost > MOST_DROPPED * area_of(surface) or strong_components(made.triangles).max() > 0:
                continue
            if place.trouble(made) < len(place.found.pairs):
                options.append((lost + edge * abs(_rim_length(made) - rim), number, made))
    if not options:
        return None
    return _dropped(place, min(options, key=lambda o: o[:2])[2], "flap beyond the line of crossing")


def _flaps(place: _Place) -> Iterator[tuple[BoolArray, Surface | None]]:
    """Yield the small patches between lines of crossing: their vertices, and the fault without them."""
    surface = place.surface
    concerned = np.zeros(len(surface.triangles), dtype=np.bool_)
    concerned[np.unique(place.found.pairs)] = True
    network = self_refined(surface, concerned, place.touch)
    label = patches(network)
    size = np.bincount(label, triangle_areas(network.vertices, network.triangles))
    lines = crossing_edges(network).reshape(-1, 3)
    for number in np.argsort(size, kind="stable")[: min(_MOST_PATCHES, len(size) - 1)]:
        if size[number] > MOST_DROPPED * size.sum():
            return
        points = network.vertices[np.unique(network.triangles[label == number])]
        flap = among(surface.vertices, points[~among(points, lines)])
        welded = without_patch(surface, network, np.asarray(label == number, dtype=np.bool_))
        yield flap, None if welded is None or _kinked(welded, lines) else welded


def _kinked(surface: Surface, lines: FloatArray) -> bool:
    """Return whether a welded surface turns back on itself, by more than 90 degrees, along the lines."""
    on = among(surface.vertices, lines)[surface.triangles]
    normals = triangle_normals(surface.vertices, surface.triangles)[on.any(axis=1)]
    return bool(len(normals)) and bool(((normals @ normals.sum(axis=0)) < 0).any())


def _cut_back(place: _Place, flap: BoolArray, edge: float) -> Surface | None:
    """Return the fault cut a gap before the line beyond which a flap begins."""
    if not flap.any() or flap.all():
        return None
    ends = place.found.lines[place.found.areas == 0]
    mine = np.asarray(flap[place.surface.triangles].any(axis=1), dtype=np.bool_)
    near = np.isin(place.found.pairs[place.found.areas == 0], np.flatnonzero(around(place.surface, mine, 1)))
    ends = ends[near.any(axis=1)]
    if not len(ends):
        return None
    return without(place.surface, flap, ends, max(_GAP * edge, CLEAR * place.touch))


def _dropped(place: _Place, made: Surface, what: str) -> Change | None:
    """Return the fault without a part of it, where that part is small and fewer triangles cross then."""
    surface, task = place.surface, place.task
    lost = area_of(surface) - area_of(made)
    if not len(made.triangles) or lost > MOST_DROPPED * area_of(surface):
        return None
    if place.trouble(made) >= len(place.found.pairs):
        return None
    unit = f"{task.unit}²" if task.unit else ""
    reason = (
        f"The {what} was taken away from {place.name}: {amount(lost, unit)}, "
        f"{percent(lost, area_of(surface))} of its area; it does not continue the largest sheet."
    )
    count = len(surface.triangles) - len(made.triangles)
    return place.change(made, abs(count), reason, lost, unit)


def _left(place: _Place) -> Refusal:
    """Return why a fault is left as it crosses itself."""
    task, surface = place.task, place.surface
    limit = amount(task.max_move(place.name), task.unit)
    joined = strong_components(surface.triangles).max() == 0
    sheet = "one sheet" if joined else "sheets that are not joined"
    share = _smallest_share(place)
    part = "layer" if place.found.areas.any() else "flap beyond a line of crossing"
    return Refusal(
        "self-intersection",
        (place.name,),
        f"{place.name} crosses or lies upon itself in {sheet}; no move within max_move = {limit} ends that, "
        f"and its smallest {part} is {percent(share, 1.0)} of its area (at most "
        f"{percent(MOST_DROPPED, 1.0)} is taken away, where one sheet is left).",
        "Split it by hand into two faults, or take away the sheet that does not belong to it.",
        place.found.lines.mean(axis=1)[int(np.argmax(place.found.depths))],
        max(0.0, 100.0 * (share - MOST_DROPPED)),
        "percent of the area",
    )


def _smallest_share(place: _Place) -> float:
    """Return the share of the area that the smallest layer, or patch between lines of crossing, has."""
    surface = place.surface
    concerned = np.zeros(len(surface.triangles), dtype=np.bool_)
    if place.found.areas.any():
        concerned[place.found.pairs[place.found.areas > 0]] = True
        label = sheets(surface, concerned)
        areas = triangle_areas(surface.vertices, surface.triangles)
    else:
        concerned[place.found.pairs] = True
        network = self_refined(surface, concerned, place.touch)
        label, areas = patches(network), triangle_areas(network.vertices, network.triangles)
    return float(np.bincount(label[label >= 0], areas[label >= 0]).min() / areas.sum())


def _rim_length(surface: Surface) -> float:
    edges = boundary_edges(surface.triangles)
    return float(np.linalg.norm(surface.vertices[edges[:, 0]] - surface.vertices[edges[:, 1]], axis=1).sum())


REPAIR = Repair(
    "uncross",
    ("self-intersection",),
    "Moves, or takes away, the smaller sheet where a fault passes through or lies upon itself.",
    propose,
)
