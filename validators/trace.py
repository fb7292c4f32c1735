"""trace: U ∩ W_i is a polyline that ends somewhere (paper Sect. 3.2, condition 3)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from graben.arrays import FloatArray, IntArray, floats, ints
from graben.cutgraph import CutGraph, NodeKind
from graben.finding import Element, Part
from graben.model import Fault, Horizon
from graben.proximity import nearest
from graben.validators.apart import far_horizons, fault_like, too_coarse, too_wide
from graben.validators.context import Check, CheckContext, Defect, Need, Scope, Severity
from graben.validators.idle import idle_faults, missed_by
from graben.validators.measuring.measures import amount
from graben.validators.measuring.reach import reach_of
from graben.validators.measuring.trace_measures import (
    Goal,
    LooseEnd,
    gaps_between,
    loose_ends,
    outline,
    pieces_of,
)
from graben.validators.stated import assumed_sign, other_units
from graben.words import plural

#: How far off a fault's rim a place of the fault lies where the fault goes on, in steps.
_OFF_RIM = 0.5
#: Within so many steps of a trace a boundary is that at which the trace leaves; shorter ones are no boundary.
_AT_TRACE = 2.0
#: What a part is called where a fault ends too early up or down dip.
TOO_SHORT = "fault too short"
#: A fault is too short along so many steps of its trace at least: what planes say of less is uncertain.
_SHORT_ALONG = 1.0


def _run(context: CheckContext) -> list[Defect]:
    evidence = context.evidence
    found = [
        _failed(h, evidence.errors[h.name], evidence.places.get(h.name))
        for h in context.horizons
        if _untraced(context, h)
    ]
    found += [*other_units(context), *assumed_sign(context), *far_horizons(context)]
    missed = {h.name: missed_by(context, h, graph) for h, graph in context.traced()}
    faults = context.model.faults
    found += idle_faults(
        context,
        lambda h, graph, f: faults.index(f) in missed[h.name] or _short(context, h, graph, f) is not None,
    )
    for horizon, graph in context.traced():
        ends = np.isin(graph.kinds, (NodeKind.EXIT, NodeKind.LOOSE)).any()
        parts = outline(horizon.surface) if ends else []
        for k, fault in enumerate(faults):
            objects = (horizon.name, fault.name)
            said = [_loose(context, horizon, graph, k, parts)]
            said += [too_coarse(context, horizon, graph, k), too_wide(context, horizon, graph, k)]
            said += [judge(graph, k, objects, context.unit) for judge in (_pieces, _dropped)]
            said += [_short(context, horizon, graph, fault), _too_short(context, horizon, graph, k)]
            said += [missed[horizon.name].get(k)]
            found += [d for d in said if d is not None]
    return [
        _together([d for d in found if d.objects == names])
        for names in dict.fromkeys(d.objects for d in found)
    ]


def _short(context: CheckContext, horizon: Horizon, graph: CutGraph, fault: Fault) -> Defect | None:
    """Return where a horizon ends just short of a fault that goes on above and below it.

    A boundary of the horizon that runs within a step of the fault, off the fault's rim and off its trace: the
    horizon was cut or left open there before it came, and is not cut anew.
    """
    step = horizon.step
    rim, vertices = fault.surface.rim, fault.surface.vertices
    edges = horizon.surface.vertices[horizon.surface.rim]
    middles = edges.mean(axis=1)
    close = _around(middles, vertices, step)
    near = nearest(middles[close], vertices, fault.surface.triangles)
    within = (near.distance > context.contact) & (near.distance < step)
    close, distance, place = close[within], near.distance[within], near.place[within]
    if len(rim):
        off = nearest(place, vertices, rim).distance > _OFF_RIM * step
        close, distance = close[off], distance[off]
    number = context.model.faults.index(fault)
    trace = graph.edges[graph.faults == number]
    if len(trace) and len(close):
        beside = nearest(middles[close, :2], graph.nodes, trace).distance > _AT_TRACE * step
        close, distance = close[beside], distance[beside]
    along = float(np.linalg.norm(edges[close, 1] - edges[close, 0], axis=1).sum())
    if along < _AT_TRACE * step:
        return None
    # the sides of a strip come near it at its corners only: the middle one says how far short it ends
    gap = float(np.median(distance))
    worst = close[np.argmin(np.abs(distance - gap))]
    x, y, z = (float(c) for c in middles[worst])
    return Defect(
        (horizon.name, fault.name),
        f"{horizon.name} ends {amount(gap, context.unit)} short of {fault.name}, along "
        f"{amount(along, context.unit)} of its boundary, and is not cut there.",
        "Extend the horizon across the fault, so that it can be cut at it.",
        count=len(close),
        value=gap,
        unit=context.unit,
        place=floats(middles[worst]),
        places=floats(middles[close], -1, 3),
        parts=(Part("short of the fault", len(close), (x, y, z), gap, context.unit),),
        severity=Severity.WARN,
    )


def _around(points: FloatArray, places: FloatArray, reach: float) -> IntArray:
    """Return which points (n, 3) lie within ``reach`` of the box of places (k, 3)."""
    low, high = places.min(axis=0) - reach, places.max(axis=0) + reach
    return np.flatnonzero(((points >= low) & (points <= high)).all(axis=1))


def _too_short(context: CheckContext, horizon: Horizon, graph: CutGraph, number: int) -> Defect | None:
    """Return where a fault ends up or down dip before it reaches the place of a cutoff."""
    faults = context.model.faults
    if not (graph.faults == number).any():
        return None
    gammas = {k: context.model.gamma(faults[k], horizon) for k in np.unique(graph.faults).tolist()}
    reach = reach_of(horizon, [f.surface for f in faults], graph, number, gammas, context.contact)
    parts, worst, said = [], [], []
    for where, missing, rim in (
        ("above", reach.missing_above, reach.above),
        ("below", reach.missing_below, reach.below),
    ):
        short = (missing > 0) & reach.sure
        if float(reach.length[short].sum()) < _SHORT_ALONG * horizon.step:
            continue
        far = missing / np.maximum(np.abs(reach.dip[:, 2]), np.finfo(float).tiny)
        k = int(np.argmax(np.where(short, far, -np.inf)))
        parts.append(Part(TOO_SHORT, int(short.sum()), _xyz(rim[k]), float(far[k]), context.unit))
        worst.append((float(far[k]), rim[k]))
        said.append(f"{amount(float(far[k]), context.unit)} too early {where} the trace")
    if not parts:
        return None
    value, place = max(worst, key=lambda w: w[0])
    objects = (horizon.name, faults[number].name)
    return Defect(
        objects,
        f"{objects[1]} ends {' and '.join(said)} on {objects[0]}: the cut will leave it.",
        "Extend the fault up or down dip by at least that much, or lower gamma.",
        count=sum(part.count for part in parts),
        value=value,
        unit=context.unit,
        place=floats(place),
        places=floats([w[1] for w in worst], -1, 3),
        parts=tuple(parts),
        severity=Severity.WARN,
    )


def _together(defects: list[Defect]) -> Defect:
    """Return one defect of several of the same objects: the gravest, first, gives it its place."""
    return replace(
        defects[0],
        message=" ".join(d.message for d in defects),
        places=floats(np.concatenate([d.places for d in defects])),
        paths=tuple(path for d in defects for path in d.paths),
        parts=tuple(part for d in defects for part in d.parts),
    )


def _untraced(context: CheckContext, horizon: Horizon) -> bool:
    return horizon.name in context.evidence.errors and horizon.name not in context.evidence.graphs


def _failed(horizon: Horizon, reason: str, place: tuple[float, float, float] | None) -> Defect:
    like = fault_like(horizon)
    return Defect(
        (horizon.name,),
        f"The cut graph of {horizon.name} could not be made: {like or reason}",
        "Name it under [[faults]]." if like else "Look at the horizon and its faults at that place.",
        value=None if place is None else 1.0,
        unit="" if place is None else "place",
        place=None if place is None else floats(place),
        places=floats([] if place is None else [place], -1, 3),
        blocks=True,
    )


def _loose(
    context: CheckContext, horizon: Horizon, graph: CutGraph, fault: int, parts: Sequence[Any]
) -> Defect | None:
    """Return the ends of a trace that lie on no rim, no other fault and not on the outer boundary."""
    surfaces = [f.surface for f in context.model.faults]
    ends = loose_ends(horizon, graph, fault, surfaces, parts)
    if not ends:
        return None
    objects = (horizon.name, surfaces[fault].name)
    worst = max(ends, key=lambda end: end.distance)
    places = graph.nodes[[end.node for end in ends]]
    where = "at a hole of the horizon" if worst.at_hole else "within the horizon"
    title = "The trace" if len(ends) == 1 else f"{plural(len(ends), 'end')} of the trace"
    verb = "ends" if len(ends) == 1 else "lie"
    farthest = "" if len(ends) == 1 else ", the farthest"
    return Defect(
        objects,
        f"{title} of {objects[1]} on {objects[0]} {verb} {where}{farthest} "
        f"{amount(worst.distance, context.unit)} short of {worst.goal.value}{worst.name}.",
        "Close the hole of the horizon there, or extend the fault." if worst.at_hole else "Extend the fault.",
        count=len(ends),
        value=worst.distance,
        unit=context.unit,
        place=graph.nodes[worst.node],
        elements=ints([end.node for end in ends]),
        element=Element.NODE,
        places=floats(places, -1, 3),
        parts=tuple(
            Part("loose end", 1, _xyz(place), end.distance, context.unit, _about(end, objects))
            for end, place in zip(ends, places, strict=True)
        ),
        blocks=not all(end.at_hole for end in ends),
    )


def _about(end: LooseEnd, objects: tuple[str, str]) -> tuple[str, ...]:
    """Return the horizon, the fault and, where an end falls short of it, the other fault."""
    return (*objects, end.name) if end.goal is Goal.FAULT else objects


def _xyz(place: FloatArray) -> tuple[float, float, float]:
    x, y, z = (float(c) for c in place)
    return x, y, z


def _pieces(graph: CutGraph, fault: int, objects: tuple[str, str], unit: str) -> Defect | None:
    """Return the pieces of a trace other than the longest, with the gaps between all."""
    pieces = pieces_of(graph, fault)
    if len(pieces) < 2:
        return None
    gaps = gaps_between(pieces)
    apart = [amount(gap.width, unit) for gap in (gaps if len(gaps) < 2 else (gaps[0], gaps[-1]))]
    long = [amount(piece.length, unit) for piece in pieces[:2]]
    of = f"of {' and '.join(long)}" if len(pieces) == 2 else f"the longest of {' and '.join(long)}"
    rest = pieces[1:]
    return Defect(
        objects,
        f"The trace of {objects[1]} on {objects[0]} is in {len(pieces)} pieces, {of}, "
        f"{' to '.join(apart)} apart.",
        "Look whether the fault or the horizon has a hole between the pieces, or name the pieces as faults.",
        count=len(rest),
        value=rest[0].length,
        unit=unit,
        place=rest[0].middle,
        elements=ints(np.concatenate([piece.edges for piece in rest])),
        element=Element.EDGE,
        places=floats([piece.middle for piece in rest], -1, 3),
        paths=tuple(path for piece in pieces for path in piece.paths),
        parts=(
            *(piece.part("piece", unit) for piece in pieces),
            *(Part("gap", 1, _xyz(g.place), g.width, unit) for g in gaps),
        ),
        severity=Severity.RELAXED,
    )


def _dropped(graph: CutGraph, fault: int, objects: tuple[str, str], unit: str) -> Defect | None:
    """Return the pieces of a trace left out of the cut graph."""
    pieces = [d for d in graph.dropped if d.fault == fault]
    if not pieces:
        return None
    longest = max(pieces, key=lambda d: d.length)
    reasons = "; ".join(dict.fromkeys(d.reason for d in pieces))
    return Defect(
        objects,
        f"{plural(len(pieces), 'piece')} of the trace of {objects[1]} on {objects[0]} left out ({reasons}).",
        "Nothing, where the horizon is not offset there; else extend the fault.",
        count=len(pieces),
        value=float(longest.length),
        unit=unit,
        place=floats(longest.place),
        places=floats([d.place for d in pieces], -1, 3),
        parts=tuple(Part(d.reason, 1, _xyz(d.place), float(d.length), unit) for d in pieces),
        severity=Severity.WARN,
    )


CHECK = Check(
    "trace",
    "3.2, condition 3",
    "The trace of each fault on each horizon is one polyline that ends at a rim, a fault or the boundary.",
    "The horizon is cut along the trace: an end that lies nowhere has no guide to move along.",
    _run,
    need=Need.GRAPH,
    long=True,
    leniency=(
        "several pieces only warn under extended; pieces left out, faults that cut nothing or end too early, "
        "horizons beyond all faults, and a unit or sign of z that does not fit always warn"
    ),
    scope=Scope.HORIZON,
    blocks_when="an end inside the horizon that lies nowhere, or no cut graph at all",
    repairable=True,
)
