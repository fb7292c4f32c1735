"""functional: the plan projection is injective (paper Sect. 3.1, requirement 1)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from graben.arrays import FloatArray, floats, ints
from graben.finding import Element
from graben.model import Horizon
from graben.surface import Surface
from graben.validators.context import Check, CheckContext, Defect, Scope, Severity, Tolerance
from graben.validators.measuring.crossings import Crossings, crossings, overlap_parts
from graben.validators.measuring.measures import amount, areas_of, centroids, part_at, percent
from graben.validators.measuring.picks import STEEPEST, Cliff, cliffs
from graben.validators.measuring.plan import Projection, covers_once, narrowest_overlap, projected
from graben.words import plural

#: Relief of a flattened surface, in widths below which an overlap is none.
FLAT = 0.1
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
    concerned, worst = cliffs(context.model, horizon, context.sound_faults, steepest)
    if worst is None:
        return None
    run, unit = amount(worst.run, context.unit), context.unit
    if worst.stray is not None:
        return _stray(horizon, worst, worst.stray, unit)
    return Defect(
        (horizon.name,),
        f"{horizon.name} is not a function of x and y: {len(concerned)} of its points stand above or below "
        f"others, by {amount(worst.rise, unit)} within {run} in plan, where its step is "
        f"{amount(horizon.step, unit)}.",
        "Keep one limb of the fold at each place, or take the horizon out of the model.",
        count=len(concerned),
        value=worst.rise,
        unit=unit,
        place=horizon.picks[worst.points[0]],
        elements=concerned,
        element=Element.PICK,
        places=floats(horizon.picks[concerned], -1, 3),
        severity=Severity.FAIL,
        blocks=True,
    )


def _stray(horizon: Horizon, worst: Cliff, stray: int, unit: str) -> Defect:
    """Return that one input point alone keeps a horizon from being a function of x and y."""
    place = horizon.picks[stray]
    side = "above" if stray == worst.points[0] else "below"
    return Defect(
        (horizon.name,),
        f"{horizon.name} is not a function of x and y at one stray pick: it lies {amount(worst.rise, unit)} "
        f"{side} another that is {amount(worst.run, unit)} away in plan, and all others agree.",
        "Correct that pick, or delete it from the file.",
        count=1,
        value=worst.rise,
        unit=unit,
        place=place,
        elements=ints([stray]),
        element=Element.PICK,
        places=floats(place, 1, 3),
        severity=Severity.FAIL,
        blocks=True,
    )


def _surface(context: CheckContext, surface: Surface) -> Defect | None:
    """Return the overturned and vertical triangles of a surface, and its overlaps where none is overturned.

    An overturned part lies over another by itself.
    """
    plan = projected(surface)
    is_fault = context.is_fault(surface.name)
    twice = None if len(plan.overturned) else _overlap(surface, plan, is_fault, context.unit)
    bad = np.union1d(plan.vertical, plan.overturned)
    if not len(bad) or twice is not None:
        return twice
    areas = areas_of(surface)
    places = centroids(surface.vertices, surface.triangles[bad])
    worst = int(np.argmax(plan.dips[bad]))
    kinds, parts = [], []
    for kind, of in (("vertical", plan.vertical), ("overturned", plan.overturned)):
        if len(of):
            share = percent(areas[of].sum(), areas.sum())
            kinds.append(f"{plural(len(of), f'{kind} triangle')} ({share} of its area)")
            steepest = of[np.argmax(plan.dips[of])]
            place = centroids(surface.vertices, surface.triangles[[steepest]])[0]
            parts.append(part_at(f"{kind} triangle", len(of), place, float(plan.dips[steepest]), "degrees"))
    return Defect(
        (surface.name,),
        f"{surface.name} has {' and '.join(kinds)}.",
        "Nothing, if it is so in nature: its triangles are used as they are."
        if is_fault
        else "Keep one limb of the fold at each place, or take the horizon out of the model.",
        count=len(bad),
        value=float(plan.dips[bad[worst]]),
        unit="degrees",
        place=places[worst],
        elements=ints(bad),
        element=Element.TRIANGLE,
        places=floats(places, -1, 3),
        parts=tuple(parts),
        severity=Severity.RELAXED if is_fault else Severity.FAIL,
        blocks=not is_fault,
    )


def _overlap(surface: Surface, plan: Projection, is_fault: bool, unit: str) -> Defect | None:
    """Return the places of the plan that a surface covers twice without being overturned."""
    least = narrowest_overlap(surface, plan)
    if covers_once(surface, least):
        return None
    found = crossings(_flattened(surface, least), least)
    if not len(found.pairs):
        return None
    found = replace(found, lines=_lifted(surface, found))
    parts = overlap_parts("overlap in plan", surface, found, unit)
    square = f"{unit}²" if unit else ""
    least_many = "" if found.complete else "at least "
    return Defect(
        (surface.name,),
        f"{surface.name} is not a function of x and y: it covers {least_many}"
        f"{plural(len(parts), 'place')} of the plan more than once, "
        f"{amount(found.areas.sum(), square)} in all.",
        "Take one of the two sheets away there, or give it as a surface of its own.",
        count=len(parts),
        value=float(found.areas.sum()),
        unit=square,
        place=found.lines[np.argmax(found.areas), 0],
        elements=ints(np.unique(found.pairs)),
        element=Element.TRIANGLE,
        places=found.lines[:, 0],
        parts=parts,
        severity=Severity.FAIL,
        blocks=not is_fault,
    )


def _lifted(surface: Surface, found: Crossings) -> FloatArray:
    """Return the places of the pairs on the higher of their two triangles, twice, shape (p, 2, 3)."""
    corners = surface.vertices[surface.triangles[found.pairs]]
    normals = np.cross(corners[:, :, 1] - corners[:, :, 0], corners[:, :, 2] - corners[:, :, 0])
    away = found.lines[:, :1, :2] - corners[:, :, 0, :2]
    heights = corners[:, :, 0, 2] - (normals[:, :, :2] * away).sum(axis=2) / normals[:, :, 2]
    places = np.concatenate([found.lines[:, 0, :2], heights.max(axis=1)[:, None]], axis=1)
    return floats(np.stack([places, places], axis=1))


def _flattened(surface: Surface, least: float) -> Surface:
    """Return the surface with its elevations scaled down below ``least``, so that it lies in one plane.

    They are not 0: vertices above each other must not become one.
    """
    relief = float(np.abs(surface.vertices[:, 2]).max(initial=0.0))
    factor = FLAT * least / relief if relief > 0 else 1.0
    return surface.with_vertices(surface.vertices * np.array([1.0, 1.0, factor]))


CHECK = Check(
    "functional",
    "3.1, requirement 1",
    "The plan projection of every surface is injective.",
    "The method writes u and w as functions of x and y: with two elevations at one place there is no answer "
    "to how high the surface is.",
    _run,
    severity=Severity.RELAXED,
    leniency=(
        "a horizon, and a fault that overlaps itself in plan without an overturned triangle, fail under both"
    ),
    scope=Scope.HORIZON,
    blocks_when="where it is a horizon",
    tolerance=Tolerance(
        "steepest slope between two points of a horizon", "degrees", f"{STEEPEST:g}", lambda model: [STEEPEST]
    ),
    repairable=True,
)
