"""acyclic: the cut graph has no cycle (paper Sect. 3.3)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely

from graben.arrays import FloatArray, IntArray, floats, ints
from graben.cutgraph import CutGraph
from graben.finding import Element, Part
from graben.surface import Surface
from graben.validators.context import Anchoring, Check, CheckContext, Defect, Need, Severity
from graben.validators.measuring.measures import amount
from graben.validators.measuring.trace_measures import above
from graben.words import plural


@dataclass(frozen=True, eq=False)
class Cycle:
    """A cycle of a cut graph, around one face of its plan projection.

    Parameters
    ----------
    nodes : (k,) array
        Node indices along it, counter-clockwise, the first not repeated.
    faults : tuple of int
        The faults in the order in which they are met along it, from the one of the least index.
    face : shapely.Polygon
        What it encloses in plan, model units.
    """

    nodes: IntArray
    faults: tuple[int, ...]
    face: Any


def _run(context: CheckContext) -> list[Defect]:
    names = [f.name for f in context.model.faults]
    anchors = context.evidence.anchors
    found = []
    for horizon, graph in context.traced():
        around = cycles(graph)
        if around:
            held = horizon.name in anchors and all(_held(c, anchors[horizon.name]) for c in around)
            found.append(_defect(horizon.surface, graph, around, held, names, context.unit))
    return found


def cycles(graph: CutGraph) -> list[Cycle]:
    """Return the cycle around each bounded face of a cut graph in plan, the smallest face first.

    There are E - V + C of them (Euler), as many as independent cycles; an edge that belongs to two faults
    counts once. What the boundary of the horizon closes is no cycle of the graph.
    """
    pairs, which = np.unique(np.sort(graph.edges, axis=1), axis=0, return_inverse=True)
    fault = np.full(len(pairs), np.iinfo(np.int64).max)
    np.minimum.at(fault, which.reshape(-1), graph.faults)
    lines = shapely.linestrings(graph.nodes[pairs][:, :, :2])
    faces = shapely.get_parts(shapely.polygonize(lines))
    at = {(x, y): k for k, (x, y) in enumerate(graph.nodes[:, :2].tolist())}
    owner = {(a, b): f for (a, b), f in zip(pairs.tolist(), fault.tolist(), strict=True)}
    found = [_around(face, at, owner) for face in faces]
    return sorted(found, key=lambda cycle: float(cycle.face.area))


def _around(face: Any, at: dict[tuple[float, float], int], owner: dict[tuple[int, int], int]) -> Cycle:
    """Return the cycle around a face; ``at`` tells the node at a place, ``owner`` the fault between two."""
    ring = face.exterior if face.exterior.is_ccw else face.exterior.reverse()
    nodes = [at[x, y] for x, y in ring.coords[:-1]]
    onward = [*nodes[1:], nodes[0]]
    faults = [owner[min(a, b), max(a, b)] for a, b in zip(nodes, onward, strict=True)]
    changes = [k for k in range(len(faults)) if faults[k] != faults[k - 1]] or [0]
    turns = [changes[k:] + changes[:k] for k in range(len(changes))]
    turn = min(turns, key=lambda order: [faults[k] for k in order])
    return Cycle(ints(nodes[turn[0] :] + nodes[: turn[0]]), tuple(faults[k] for k in turn), face)


def _held(cycle: Cycle, anchors: Sequence[Anchoring]) -> bool:
    """Return whether every subdomain inside a cycle is held."""
    inside = shapely.contains_xy(cycle.face, [a.place[0] for a in anchors], [a.place[1] for a in anchors])
    return all(a.holds for a, within in zip(anchors, inside, strict=True) if within)


def _defect(
    surface: Surface, graph: CutGraph, around: Sequence[Cycle], held: bool, names: Sequence[str], unit: str
) -> Defect:
    """Return the cycles of a horizon, each a part with its faults and its area."""
    horizon, places = surface.name, _places(surface, around)
    square = f"{unit}²" if unit else ""
    parts = tuple(
        Part(
            "cycle",
            len(cycle.nodes),
            (float(x), float(y), float(z)),
            float(cycle.face.area),
            square,
            (horizon, *(names[k] for k in cycle.faults)),
        )
        for cycle, (x, y, z) in zip(around, places, strict=True)
    )
    smallest = around[0]
    area = amount(smallest.face.area, square)
    closed = [names[k] for k in smallest.faults]
    by = f"{closed[0]} alone" if len(closed) == 1 else f"{', '.join(closed[:-1])} and {closed[-1]}"
    which = "closed" if len(around) == 1 else "the smallest closed"
    if held:
        remedy = "Nothing: each part that the cuts enclose has fixed nodes enough to be modeled."
    elif all(len(cycle.faults) == 1 for cycle in around):
        remedy = "Smooth the horizon beside the fault there, or reduce gamma."
    else:
        remedy = (
            f"Leave a gap in one of the faults of {'the' if len(around) == 1 else 'each'} cycle, or reduce "
            "gamma there."
        )
    return Defect(
        (horizon,),
        f"The cut graph of {horizon} has {plural(len(around), 'cycle')}, {which} by {by} around {area}.",
        remedy,
        count=len(around),
        value=float(smallest.face.area),
        unit=square,
        place=places[0],
        elements=ints(np.unique(np.concatenate([cycle.nodes for cycle in around]))),
        element=Element.NODE,
        places=places,
        paths=tuple(floats(graph.nodes[[*cycle.nodes, cycle.nodes[0]]]) for cycle in around),
        parts=parts,
        severity=Severity.RELAXED if held else Severity.FAIL,
    )


def _places(horizon: Surface, around: Sequence[Cycle]) -> FloatArray:
    """Return a point of the horizon in each face, (n, 3): its middle, where that lies in it."""
    faces = np.array([cycle.face for cycle in around])
    middles = shapely.centroid(faces)
    middles = np.where(shapely.contains(faces, middles), middles, shapely.point_on_surface(faces))
    plan = np.column_stack([shapely.get_coordinates(middles), np.zeros(len(faces))])
    return floats(np.column_stack([plan[:, :2], -above(plan, horizon)]))


CHECK = Check(
    "acyclic",
    "3.3",
    "The cut graph of each horizon has no cycle.",
    "A part of the horizon that cuts surround is tied to the rest by nothing but its own fixed nodes.",
    _run,
    need=Need.GRAPH,
    stage=Need.ANCHORS,
    leniency="where each part that is enclosed has fixed nodes enough it only warns under extended",
)
