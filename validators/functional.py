"""functional: the plan projection is injective (paper Sect. 3.1, requirement 1)."""

from __future__ import annotations

import numpy as np

from graben.arrays import FloatArray, floats, ints
from graben.model import Horizon
from graben.surface import Surface
from graben.validators.context import Check, CheckContext, Defect, Severity
from graben.validators.measures import centroids, plural
from graben.validators.picks import STEEPEST, cliffs
from graben.validators.plan import overlaps, projected

#: What a tolerance in [checks] is cut at: the slope of 90 degrees is no function's.
_ALMOST_VERTICAL = 89.99


def _run(context: CheckContext) -> list[Defect]:
    steepest = min(context.tolerance("functional", STEEPEST), _ALMOST_VERTICAL)
    found = []
    for horizon in context.horizons:
        found.append(_points(context, horizon, steepest) or _surface(context, horizon.surface))
    found += [_surface(context, fault.surface) for fault in context.faults]
    return [d for d in found if d is not None]


def _points(context: CheckContext, horizon: Horizon, steepest: float) -> Defect | None:
    """Return the input points of a horizon that cannot be one function of x and y."""
    concerned, worst = cliffs(context.model, horizon, context.faults, steepest)
    if worst is None:
        return None
    length = f" {context.unit}" if context.unit else ""
    return Defect(
        (horizon.name,),
        f"{horizon.name} is not a function of x and y: {len(concerned)} of its points stand above or below "
        f"others, by {worst.rise:.4g}{length} within {worst.run:.2g}{length} in plan, where its step is "
        f"{horizon.step:.4g}{length}.",
        "Keep one limb of the fold at each place, or take the horizon out of the model.",
        count=len(concerned),
        value=worst.rise,
        unit=context.unit,
        place=horizon.picks[worst.points[0]],
        elements=concerned,
        places=floats(horizon.picks[concerned], -1, 3),
        blocks=True,
    )


def _surface(context: CheckContext, surface: Surface) -> Defect | None:
    """Return the vertical and overturned triangles of a surface; where there are none, its overlaps."""
    is_fault = context.is_fault(surface.name)
    plan = projected(surface)
    bad = np.union1d(plan.vertical, plan.overturned)
    if not len(bad):
        return _overlap(surface, is_fault, context.unit)
    parts = []
    if len(plan.vertical):
        parts.append(f"{plural(len(plan.vertical), 'vertical triangle')}")
    if len(plan.overturned):
        parts.append(f"{plural(len(plan.overturned), 'overturned triangle')}")
    places = centroids(surface.vertices, surface.triangles[bad])
    worst = int(np.argmax(plan.dips[bad]))
    return Defect(
        (surface.name,),
        f"{surface.name} has {' and '.join(parts)}.",
        "Nothing, if it is so in nature: its triangles are used as they are."
        if is_fault
        else "Keep one limb of the fold at each place, or take the horizon out of the model.",
        count=len(bad),
        value=float(plan.dips[bad[worst]]),
        unit="degrees",
        place=places[worst],
        elements=ints(bad),
        places=floats(places, -1, 3),
        severity=Severity.RELAXED if is_fault else Severity.FAIL,
        blocks=not is_fault,
    )


def _overlap(surface: Surface, is_fault: bool, unit: str) -> Defect | None:
    """Return the places of the plan that a surface covers twice without being overturned."""
    areas, points = overlaps(surface)
    if not len(areas):
        return None
    places = np.stack([_above(surface, p) for p in points])
    return Defect(
        (surface.name,),
        f"{surface.name} covers {plural(len(areas), 'place')} of the plan more than once.",
        "Take one of the two sheets away there, or give it as a surface of its own.",
        count=len(areas),
        value=float(areas.sum()),
        unit=f"{unit}²" if unit else "",
        place=places[np.argmax(areas)],
        places=floats(places, -1, 3),
        blocks=not is_fault,
    )


def _above(surface: Surface, point: FloatArray) -> FloatArray:
    """Return the highest place of a surface over a point in plan that it covers."""
    a, b, c = (surface.vertices[surface.triangles[:, k]] for k in range(3))
    p = np.concatenate([point, [0.0]])
    weights = np.stack(
        [np.cross(c - b, p - b)[:, 2], np.cross(a - c, p - c)[:, 2], np.cross(b - a, p - a)[:, 2]]
    )
    total = weights.sum(axis=0)
    inside = (total != 0) & ((weights * np.sign(total)).min(axis=0) >= 0)
    heights = (weights * np.stack([a[:, 2], b[:, 2], c[:, 2]]))[:, inside].sum(axis=0) / total[inside]
    return np.array([point[0], point[1], heights.max()])


CHECK = Check(
    "functional",
    "3.1, requirement 1",
    "The plan projection of every surface is injective.",
    repairable=True,
    tolerance="steepest slope between two points of a horizon, degrees",
    run=_run,
)
