"""Faults that do not cut a horizon: those that cut none, and those that end within a step of one."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from graben.arrays import FloatArray, IntArray, floats
from graben.cutgraph import CutGraph
from graben.finding import Part
from graben.model import Fault, Horizon
from graben.proximity import nearest
from graben.surface import Surface
from graben.validators.context import CheckContext, Defect, Severity
from graben.validators.measuring.measures import amount
from graben.validators.measuring.misses import Miss, misses
from graben.words import listed

#: A fault misses a horizon along so many steps at least: shorter pieces of a trace are left out as well.
_LEAST = 2.0
_NONE_CUTS = " No fault of the model cuts any: every horizon stays as it is."


def missed_by(context: CheckContext, horizon: Horizon, graph: CutGraph) -> dict[int, Defect]:
    """Return a warning for each fault that does not meet a horizon but ends within a step of it."""
    met = _met(graph)
    numbers = [k for k in range(len(context.model.faults)) if k not in met]
    surfaces = [f.surface for f in context.model.faults]
    found = misses(horizon, surfaces, numbers, context.contact)
    return {
        k: _missed(horizon, surfaces[k].name, miss, context.unit)
        for k, miss in found.items()
        if miss.length >= _LEAST * horizon.step
    }


def _missed(horizon: Horizon, fault: str, miss: Miss, unit: str) -> Defect:
    away = np.abs(miss.heights)
    worst = int(np.argmin(away))
    least, most = float(away[worst]), float(away.max())
    far = list(dict.fromkeys(amount(a, unit) for a in (least, most)))
    where, way = ("above", "down") if np.median(miss.heights) > 0 else ("below", "up")
    x, y, z = (float(c) for c in miss.places[worst])
    return Defect(
        (horizon.name, fault),
        f"{fault} ends {' to '.join(far)} {where} {horizon.name} along {amount(miss.length, unit)} of its "
        "rim, and does not cut it.",
        f"If {horizon.name} is offset there, extend {fault} {way} dip through it; else do nothing.",
        value=least,
        unit=unit,
        place=miss.places[worst],
        places=miss.places,
        parts=(Part("ends short of it", 1, (x, y, z), least, unit),),
        severity=Severity.WARN,
    )


def idle_faults(context: CheckContext, explained: Callable[[Horizon, CutGraph, Fault], bool]) -> list[Defect]:
    """Return a warning for each fault that cuts nothing, where every horizon could be looked at.

    Parameters
    ----------
    context : CheckContext
        What the check sees.
    explained : callable
        Whether it is said otherwise why a fault does not cut a horizon.
    """
    traced = context.traced()
    if not traced or len(traced) < len(context.model.horizons):
        return []
    cutting = np.unique(np.concatenate([_met(graph) for _, graph in traced]))
    idle = [
        f.surface
        for k, f in enumerate(context.model.faults)
        if k not in cutting and not any(explained(h, g, f) for h, g in traced)
    ]
    alone = len(idle) == len(context.model.faults)
    return [_idle(surface, [h.surface for h, _ in traced], context.unit, alone) for surface in idle]


def _met(graph: CutGraph) -> IntArray:
    """Return the faults that meet a horizon, those of dropped pieces with them."""
    return np.concatenate([graph.faults, np.array([d.fault for d in graph.dropped], dtype=np.int64)])


def _idle(fault: Surface, horizons: Sequence[Surface], unit: str, alone: bool) -> Defect:
    """Return the warning that a fault cuts nothing, and why; ``alone`` where no other cuts either."""
    points = np.concatenate([h.vertices for h in horizons])
    names = listed([h.name for h in horizons])
    low, high = fault.vertices.min(axis=0), fault.vertices.max(axis=0)
    apart = np.maximum(np.maximum(points.min(axis=0) - high, low - points.max(axis=0)), 0.0)
    beside = float(np.hypot(apart[0], apart[1]))
    value, place = float(np.linalg.norm(apart)), fault.vertices.mean(axis=0)
    if beside > 0:
        why = f"lies {amount(beside, unit)} beside {names} in plan"
    elif apart[2] > 0:
        where = "above" if low[2] > points[:, 2].max() else "below"
        why = f"lies {amount(float(apart[2]), unit)} {where} {names}"
    else:
        value, place = min((_between(fault, horizon) for horizon in horizons), key=lambda near: near[0])
        why = f"ends {amount(value, unit)} before it reaches one"
    return Defect(
        (fault.name,),
        f"{fault.name} cuts no horizon: it {why}." + (_NONE_CUTS if alone else ""),
        f"{fault.name} cuts no horizon: check the sign of z, the unit and the coordinate system of it and of "
        f"{names}, or leave it out.",
        value=value,
        unit=unit,
        place=floats(place),
        places=floats(place, 1, 3),
        severity=Severity.WARN,
    )


def _between(fault: Surface, horizon: Surface) -> tuple[float, FloatArray]:
    """Return the least distance of a vertex of one from the other, and its place on the fault."""
    down = nearest(fault.vertices, horizon.vertices, horizon.triangles)
    across = nearest(horizon.vertices, fault.vertices, fault.triangles)
    a, b = int(np.argmin(down.distance)), int(np.argmin(across.distance))
    if down.distance[a] <= across.distance[b]:
        return float(down.distance[a]), fault.vertices[a]
    return float(across.distance[b]), across.place[b]
