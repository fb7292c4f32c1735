"""trace: U ∩ W_i is a polyline that ends somewhere (paper Sect. 3.2, condition 3)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from graben.arrays import FloatArray, IntArray, floats, ints
from graben.cutgraph import CutGraph, NodeKind
from graben.model import Horizon
from graben.surface import Surface
from graben.validators.context import Check, CheckContext, Defect, Need, Severity
from graben.validators.measures import components, plural


def _run(context: CheckContext) -> list[Defect]:
    found = [_failed(h, context.evidence.errors[h.name]) for h in context.horizons if _untraced(context, h)]
    traced = context.traced()
    if traced and len(traced) == len(context.model.horizons):
        cutting = np.unique(np.concatenate([_met(graph) for _, graph in traced]))
        idle = [f.surface for k, f in enumerate(context.model.faults) if k not in cutting]
        found += [_idle(surface, [h.surface for h, _ in traced], context.unit) for surface in idle]
    for horizon, graph in traced:
        for k, fault in enumerate(context.model.faults):
            objects = (horizon.name, fault.name)
            said = [judge(graph, k, objects, context.unit) for judge in (_loose, _pieces, _dropped)]
            defects = [d for d in said if d is not None]
            if defects:
                # the gravest first: it gives the finding its place, the others add their sentence
                found.append(replace(defects[0], message=" ".join(d.message for d in defects)))
    return found


def _met(graph: CutGraph) -> IntArray:
    """Return the faults that meet a horizon, those of dropped pieces with them."""
    return np.concatenate([graph.faults, np.array([d.fault for d in graph.dropped], dtype=np.int64)])


def _idle(fault: Surface, horizons: list[Surface], unit: str) -> Defect:
    """Return the warning that a fault cuts nothing, with what tells why."""
    points = np.concatenate([h.vertices for h in horizons])
    low, high = fault.vertices.min(axis=0), fault.vertices.max(axis=0)
    apart = np.maximum(np.maximum(points.min(axis=0) - high, low - points.max(axis=0)), 0.0)
    beside = float(np.hypot(apart[0], apart[1]))
    length = f" {unit}" if unit else ""
    if beside > 0:
        why = f"it lies {beside:.4g}{length} beside them in plan"
    elif apart[2] > 0:
        where = "above" if low[2] > points[:, 2].max() else "below"
        why = f"it lies {apart[2]:.4g}{length} {where} them"
    else:
        why = "it ends before it reaches one"
    return Defect(
        (fault.name,),
        f"{fault.name} cuts no horizon: {why}.",
        "Check the sign of z, the unit and the coordinates of both, or leave the fault out.",
        value=float(np.linalg.norm(apart)),
        unit=unit,
        place=floats(fault.vertices.mean(axis=0)),
        places=floats(fault.vertices.mean(axis=0), 1, 3),
        severity=Severity.WARN,
    )


def _untraced(context: CheckContext, horizon: Horizon) -> bool:
    return horizon.name in context.evidence.errors and horizon.name not in context.evidence.graphs


def _failed(horizon: Horizon, reason: str) -> Defect:
    return Defect(
        (horizon.name,),
        f"The cut graph of {horizon.name} could not be made: {reason}",
        "Look at the horizon and its faults at that place.",
        blocks=True,
    )


def _loose(graph: CutGraph, fault: int, objects: tuple[str, str], unit: str) -> Defect | None:
    """Return the ends of a trace that lie on no rim, no other fault and not on the outer boundary."""
    nodes = np.unique(graph.edges[graph.faults == fault])
    ends = nodes[graph.kinds[nodes] == NodeKind.LOOSE]
    if not len(ends):
        return None
    places = graph.nodes[ends]
    verb = "ends" if len(ends) == 1 else "end"
    return Defect(
        objects,
        f"{plural(len(ends), 'end')} of the trace of {objects[1]} on {objects[0]} {verb} neither at the "
        "fault's rim nor at another fault or the horizon's boundary.",
        "Extend the fault or close the hole of the horizon there.",
        count=len(ends),
        value=float(len(ends)),
        unit="ends",
        place=places[0],
        elements=ints(ends),
        places=floats(places, -1, 3),
        blocks=True,
    )


def _pieces(graph: CutGraph, fault: int, objects: tuple[str, str], unit: str) -> Defect | None:
    """Return the pieces of a trace other than the longest."""
    edges = graph.edges[graph.faults == fault]
    if not len(edges):
        return None
    nodes, local = np.unique(edges, return_inverse=True)
    local = local.reshape(-1, 2)
    labels = components(len(nodes), local)[local[:, 0]]
    pieces = int(labels.max()) + 1
    if pieces == 1:
        return None
    ends = graph.nodes[edges]
    lengths = np.linalg.norm(ends[:, 1, :2] - ends[:, 0, :2], axis=1)
    total = np.bincount(labels, lengths)
    rest = np.argsort(-total, kind="stable")[1:]
    places = np.stack([_middle(ends[labels == k]) for k in rest])
    return Defect(
        objects,
        f"The trace of {objects[1]} on {objects[0]} is in {pieces} pieces.",
        "Look whether the fault or the horizon has a hole between the pieces, or name the pieces as faults.",
        count=pieces - 1,
        value=float(total[rest[0]]),
        unit=unit,
        place=places[0],
        elements=ints(np.flatnonzero(graph.faults == fault)[np.isin(labels, rest)]),
        places=floats(places, -1, 3),
        severity=Severity.RELAXED,
    )


def _middle(ends: FloatArray) -> FloatArray:
    """Return the middle of the edge (e, 2, 3) that is nearest to the middle of all."""
    middles = ends.mean(axis=1)
    return np.asarray(middles[np.argmin(np.linalg.norm(middles - middles.mean(axis=0), axis=1))])


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
        severity=Severity.WARN,
    )


CHECK = Check(
    "trace",
    "3.2, condition 3",
    "The trace of each fault on each horizon is one polyline that ends at a rim, a fault or the boundary.",
    need=Need.GRAPH,
    run=_run,
)
