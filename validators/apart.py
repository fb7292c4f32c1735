"""Horizons and settings that do not fit the faults: too far off, too coarse, too wide, or a fault itself."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from graben.arrays import FloatArray, floats
from graben.cutgraph import CutGraph
from graben.model import Horizon
from graben.surface import Surface, triangle_areas, triangle_dips
from graben.validators.context import CheckContext, Defect, Severity
from graben.validators.finite import usable
from graben.validators.measuring.measures import amount, remembered
from graben.words import listed

#: A trace is drawn well over so many steps at least.
_STEPS_ALONG = 8.0
#: gamma in steps where none is given.
_USUAL_GAMMA = 4.0
#: A triangulated surface that dips more than this on the whole, degrees, and cannot be cut, is a fault.
_FAULT_DIP = 45.0
#: Least and greatest coordinates, (3,) each.
Box = tuple[FloatArray, FloatArray]


def far_horizons(context: CheckContext) -> list[Defect]:
    """Return a warning for each horizon that lies so that no fault can cut it, likely by mistake.

    That is one further from all faults than the larger of both is wide or high, and one a step or more above
    or below all faults that it overlaps in plan, where another horizon lies among them.
    """
    boxes = {f.name: _box(f.surface) for f in context.sound_faults if len(f.surface.vertices)}
    if not boxes:
        return []
    horizons = [h for h in context.horizons if len(h.surface.vertices)]
    gaps = {h.name: _gap(h, boxes) for h in horizons}
    some_among = any(faults and gap == 0.0 for gap, faults in gaps.values())
    found = []
    for horizon in horizons:
        far = _far(horizon, boxes, context.unit)
        gap, faults = gaps[horizon.name]
        if far is not None:
            found.append(far)
        elif some_among and abs(gap) > horizon.step:
            where = f"{amount(abs(gap), context.unit)} {_side(gap)} all faults of its area"
            found.append(
                _apart(horizon, f"{where}, and none cuts it", _signs(horizon, faults), abs(gap), context.unit)
            )
    return found


def _gap(horizon: Horizon, boxes: Mapping[str, Box]) -> tuple[float, list[str]]:
    """Return by how much a horizon lies above all faults that it overlaps in plan, and these.

    Negative below them; 0 where it lies among them or overlaps none.
    """
    low, high = _box(horizon.surface)
    over = [n for n, (a, b) in boxes.items() if (a[:2] <= high[:2]).all() and (b[:2] >= low[:2]).all()]
    if not over:
        return 0.0, over
    above = low[2] - max(boxes[n][1][2] for n in over)
    below = min(boxes[n][0][2] for n in over) - high[2]
    return float(max(above, 0.0) - max(below, 0.0)), over


def _side(gap: float) -> str:
    return "above" if gap > 0 else "below"


def _far(horizon: Horizon, boxes: Mapping[str, Box], unit: str) -> Defect | None:
    """Return the warning that a horizon is further from all faults than it or they are wide or high."""
    low, high = np.min([b[0] for b in boxes.values()], axis=0), np.max([b[1] for b in boxes.values()], axis=0)
    own_low, own_high = _box(horizon.surface)
    gap = np.maximum(np.maximum(own_low - high, low - own_high), 0.0)
    size = np.maximum(own_high - own_low, high - low)
    beside, reach = float(np.hypot(gap[0], gap[1])), float(np.hypot(size[0], size[1]))
    if beside > reach:
        where = f"{amount(beside, unit)} beside all faults in plan, further than it or they are wide"
        return _apart(horizon, where, _plan(horizon, list(boxes)), beside, unit)
    if gap[2] > size[2]:
        side = _side(own_low[2] - high[2])
        where = f"{amount(float(gap[2]), unit)} {side} all faults, further than it or they are high"
        return _apart(horizon, where, _signs(horizon, list(boxes)), float(gap[2]), unit)
    return None


def _signs(horizon: Horizon, faults: Sequence[str]) -> str:
    return (
        f"Check the sign of z (the key z, or what the file states) and the unit of {horizon.name} and of "
        f"{listed(faults)}; where it is meant so, {horizon.name} stays as it is."
    )


def _plan(horizon: Horizon, faults: Sequence[str]) -> str:
    return (
        f"Check that {horizon.name} and {listed(faults)} have the same coordinate system and unit, and that "
        "x and y are not interchanged."
    )


@remembered
def _box(surface: Surface) -> Box:
    points = surface.vertices[usable(surface.vertices).all(axis=1)]
    return floats(points.min(axis=0)), floats(points.max(axis=0))


def _apart(horizon: Horizon, where: str, remedy: str, value: float, unit: str) -> Defect:
    place = horizon.surface.vertices.mean(axis=0)
    return Defect(
        (horizon.name,),
        f"{horizon.name} lies {where}.",
        remedy,
        value=value,
        unit=unit,
        place=floats(place),
        places=floats(place, 1, 3),
        severity=Severity.WARN,
    )


def too_coarse(context: CheckContext, horizon: Horizon, graph: CutGraph, number: int) -> Defect | None:
    """Return the warning that a whole fault is shorter than two steps of a horizon, and left out."""
    lost = [d for d in graph.dropped if d.fault == number]
    fault = context.model.faults[number].surface
    low, high = _box(fault)
    if not lost or (graph.faults == number).any() or np.hypot(*(high - low)[:2]) >= 2.0 * horizon.step:
        return None
    length = sum(d.length for d in lost)
    better = amount(length / _STEPS_ALONG, context.unit)
    mend = (
        f"Set step = {better} or less"
        if len(horizon.picks)
        else f"Give a grid with a step of {better} or less"
    )
    return Defect(
        (horizon.name, fault.name),
        f"The step of {horizon.name}, {amount(horizon.step, context.unit)}, is too coarse for {fault.name}, "
        f"whose trace is {amount(length, context.unit)} long: it is not cut there.",
        f"{mend}.",
        value=horizon.step,
        unit=context.unit,
        place=floats(lost[0].place),
        places=floats(lost[0].place, 1, 3),
        severity=Severity.WARN,
    )


def too_wide(context: CheckContext, horizon: Horizon, graph: CutGraph, number: int) -> Defect | None:
    """Return the warning that gamma is more than a horizon is wide: nothing far from the fault holds it."""
    trace = graph.edges[graph.faults == number]
    fault = context.model.faults[number]
    gamma = context.model.gamma(fault, horizon)
    low, high = _box(horizon.surface)
    width = float((high - low)[:2].min())
    if not len(trace) or gamma < width:
        return None
    place = graph.nodes[trace].mean(axis=(0, 1))
    return Defect(
        (horizon.name, fault.name),
        f"gamma of {fault.name}, {amount(gamma, context.unit)}, is more than {horizon.name} is wide, "
        f"{amount(width, context.unit)}: the whole horizon would be made anew from hardly anything.",
        f"Set gamma to about 4 steps of the horizon, {amount(_USUAL_GAMMA * horizon.step, context.unit)}.",
        value=gamma,
        unit=context.unit,
        place=floats(place),
        places=floats(place, 1, 3),
        severity=Severity.WARN,
    )


def fault_like(horizon: Horizon) -> str:
    """Return that a horizon dips as faults do, as a sentence; empty where it does not."""
    surface = horizon.surface
    areas = triangle_areas(surface.vertices, surface.triangles)
    if len(horizon.picks) or not areas.sum() > 0:
        return ""
    dip = float(np.average(triangle_dips(surface.vertices, surface.triangles), weights=areas))
    if dip < _FAULT_DIP:
        return ""
    return f"{horizon.name} dips {dip:.0f} degrees on the whole, as a fault does."
