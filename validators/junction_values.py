"""junction-values: two faults agree at a junction (paper Sect. 9, limitation 4)."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from graben.arrays import FloatArray, IntArray, floats, ints
from graben.complexes import Complex
from graben.cutgraph import CutGraph
from graben.finding import Element, Part
from graben.proximity import nearest
from graben.surface import Surface, edge_table, triangle_normals
from graben.validators.context import CONTACT, Check, CheckContext, Defect, Need, Tolerance
from graben.validators.junction import common_edges
from graben.validators.measuring.trace_measures import above
from graben.words import plural

#: A junction stands within this many steps of the place where its faults cross: points closer to each other
#: than the mesh can resolve are one node of the cut graph.
RESOLVED = 1.0
#: Dip from which a fault has no elevation at a place of the plan, degrees.
VERTICAL = 89.9


def _run(context: CheckContext) -> list[Defect]:
    network = context.evidence.complex
    if network is None:
        return []
    tolerance = context.tolerance("junction-values", CONTACT * context.model.size)
    surfaces = [f.surface for f in context.model.faults]
    found = []
    for horizon, graph in context.traced():
        together = common_edges(graph)
        for (i, j), met in junctions(graph).items():
            # Where they run together they have no junction: that is a matter of the check `junction`.
            nodes = np.setdiff1d(met, graph.edges[together.get((i, j), ints([]))])
            points = graph.nodes[nodes]
            apart = difference(surfaces[i], surfaces[j], points, context.contact)
            apart[apart <= tolerance] = 0.0
            line = _common_line(network, i, j)
            for k in np.flatnonzero(apart):
                if _crosses(line, horizon.surface, points[k], RESOLVED * horizon.step, context.contact):
                    apart[k] = 0.0
            if apart.any():
                objects = (horizon.name, surfaces[i].name, surfaces[j].name)
                found.append(_defect(objects, nodes[apart > 0], points[apart > 0], apart[apart > 0], context))
    return found


def junctions(graph: CutGraph) -> dict[tuple[int, int], IntArray]:
    """Return for each pair of faults that meet in nodes of a cut graph these nodes."""
    rows = np.unique(np.stack([graph.edges.ravel(), np.repeat(graph.faults, 2)], axis=1), axis=0)
    shared = rows[np.bincount(rows[:, 0], minlength=len(graph.nodes))[rows[:, 0]] > 1]
    met: dict[tuple[int, int], list[int]] = {}
    for node in np.unique(shared[:, 0]).tolist():
        for i, j in combinations(shared[shared[:, 0] == node, 1].tolist(), 2):
            met.setdefault((i, j), []).append(node)
    return {pair: ints(met[pair]) for pair in sorted(met)}


def difference(first: Surface, second: Surface, points: FloatArray, contact: float) -> FloatArray:
    """Return by how much two faults differ near points at which they should meet, shape (n,), model units.

    Points of the two nearest to each other are sought; the difference is that of the elevations
    ``|w_i - w_j|`` there, or the distance of the two points where a fault is vertical or does not reach.

    Parameters
    ----------
    first, second : Surface
        Two faults.
    points : (n, 3) array
        On or very near both.
    contact : float
        Distance at which a point lies on a fault's rim, model units.
    """
    a = nearest(points, first.vertices, first.triangles).place
    b = nearest(a, second.vertices, second.triangles).place
    a = nearest(b, first.vertices, first.triangles).place
    over = np.fmax(np.abs(_above(first, b, contact)), np.abs(_above(second, a, contact)))
    return np.asarray(np.where(np.isnan(over), np.linalg.norm(a - b, axis=1), over), dtype=np.float64)


def _above(fault: Surface, points: FloatArray, contact: float) -> FloatArray:
    """Return the elevation of a fault less that of points near it; NaN where it is vertical or not there."""
    near = nearest(points, fault.vertices, fault.triangles)
    normal = triangle_normals(fault.vertices, fault.triangles[near.simplex])
    steep = np.abs(normal[:, 2]) <= np.cos(np.radians(VERTICAL)) * np.linalg.norm(normal, axis=1)
    rim = fault.rim
    if len(rim):
        steep |= nearest(near.place, fault.vertices, rim).distance <= contact
    away = near.place - points
    rise = (normal * away).sum(axis=1) / np.where(steep, 1.0, normal[:, 2])
    return np.asarray(np.where(steep, np.nan, rise), dtype=np.float64)


def _common_line(network: Complex, i: int, j: int) -> FloatArray:
    """Return what two faults of a complex share as segments, (s, 2, 3): edges, and vertices without any."""
    first, second = (network.triangles[network.owner == owner] for owner in (i, j))
    edges = np.concatenate([edge_table(first)[0], edge_table(second)[0]])
    rows, count = np.unique(edges, axis=0, return_counts=True)
    shared = rows[count == 2]
    alone = np.setdiff1d(np.intersect1d(first, second), shared)
    return floats(network.vertices[np.concatenate([shared, np.stack([alone, alone], axis=1)])])


def _crosses(line: FloatArray, horizon: Surface, point: FloatArray, reach: float, contact: float) -> bool:
    """Return whether segments (s, 2, 3) reach the horizon or pass through it within ``reach`` of a point."""
    start, way = line[:, 0], line[:, 1] - line[:, 0]
    square = np.maximum((way**2).sum(axis=1), np.finfo(float).tiny)
    middle = ((point - start) * way).sum(axis=1) / square
    off = np.linalg.norm(start + middle[:, None] * way - point, axis=1)
    half = np.sqrt(np.maximum(reach**2 - off**2, 0.0) / square)
    share = np.clip(np.stack([middle - half, middle, middle + half], axis=1), 0.0, 1.0)
    ends = start[:, None] + share[:, :, None] * way[:, None]
    ends = ends[(np.linalg.norm(ends - point, axis=2) <= reach * (1.0 + CONTACT)).all(axis=1)]
    height = above(ends.reshape(-1, 3), horizon).reshape(-1, 3)
    return bool(((height.min(axis=1) <= contact) & (height.max(axis=1) >= -contact)).any())


def _defect(
    objects: tuple[str, str, str],
    nodes: IntArray,
    points: FloatArray,
    apart: FloatArray,
    context: CheckContext,
) -> Defect:
    """Return the junctions of two faults on a horizon at which they differ."""
    horizon, first, second = objects
    worst = int(np.argmax(apart))
    length = f" {context.unit}" if context.unit else ""
    where = "their junction" if len(nodes) == 1 else plural(len(nodes), "junction")
    by = f"by {apart[worst]:.2g}{length}" if len(nodes) == 1 else f"by up to {apart[worst]:.2g}{length}"
    return Defect(
        objects,
        f"{first} and {second} differ {by} at {where} on {horizon}.",
        "Let the two share their branch line: extend the one that stops short until it crosses the other.",
        count=len(nodes),
        value=float(apart[worst]),
        unit=context.unit,
        place=points[worst],
        elements=nodes,
        element=Element.NODE,
        places=floats(points, -1, 3),
        parts=tuple(
            Part("junction", 1, (float(x), float(y), float(z)), float(d), context.unit)
            for (x, y, z), d in zip(points, apart, strict=True)
        ),
    )


CHECK = Check(
    "junction-values",
    "9, limitation 4",
    "Two faults have the same elevation at every junction.",
    "A junction ends on the line that the faults share; where they differ the cutoffs of one do not meet "
    "those of the other.",
    _run,
    need=Need.GRAPH,
    tolerance=Tolerance(
        "difference in elevation",
        "model units",
        "1e-6 of the model's size",
        lambda model: [CONTACT * model.size],
    ),
    repairable=True,
)
