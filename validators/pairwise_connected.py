"""pairwise-connected: two faults meet in nothing or in one connected polyline (Sect. 3.2, condition 2)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graben.arrays import FloatArray, IntArray, floats, ints
from graben.complexes import Complex
from graben.surface import triangle_areas
from graben.validators.context import Check, CheckContext, Defect, Need
from graben.validators.measures import centroids, components, plural


@dataclass(frozen=True)
class _Contact:
    """What two surfaces of the complex share: vertices, edges (e, 2) and triangles (t, 3), as indices."""

    vertices: IntArray
    edges: IntArray
    triangles: IntArray


def _run(context: CheckContext) -> list[Defect]:
    shape = context.evidence.complex
    if shape is None:
        return []
    names = [f.name for f in context.model.faults]
    parts = [_parts(shape, k) for k in range(len(names))]
    found = []
    for i, j in _touching(shape, len(names)):
        contact = _Contact(*(_common(a, b) for a, b in zip(parts[i], parts[j], strict=True)))
        found.append(_judged(shape, contact, (names[i], names[j]), context.unit))
    return [d for d in found if d is not None]


def _parts(shape: Complex, owner: int) -> tuple[IntArray, IntArray, IntArray]:
    """Return the vertices (n, 1), edges (e, 2) and triangles (t, 3) of one surface, rows sorted."""
    triangles = np.sort(shape.triangles[shape.owner == owner], axis=1)
    edges = np.unique(
        np.concatenate([triangles[:, [0, 1]], triangles[:, [0, 2]], triangles[:, [1, 2]]]), axis=0
    )
    return np.unique(triangles).reshape(-1, 1), edges, np.unique(triangles, axis=0)


def _touching(shape: Complex, count: int) -> list[tuple[int, int]]:
    """Return the pairs of surfaces that share a vertex, in the model's order."""
    pairs = np.unique(np.stack([shape.triangles.ravel(), np.repeat(shape.owner, 3)], axis=1), axis=0)
    uses = np.bincount(pairs[:, 0]) if len(pairs) else np.zeros(0, int)
    shared = pairs[uses[pairs[:, 0]] > 1]
    meets = np.zeros((count, int(shared[:, 0].max()) + 1 if len(shared) else 0), dtype=bool)
    meets[shared[:, 1], shared[:, 0]] = True
    return [(i, j) for i in range(count) for j in range(i + 1, count) if (meets[i] & meets[j]).any()]


def _common(a: IntArray, b: IntArray) -> IntArray:
    """Return the rows that stand in both arrays; each holds a row once."""
    rows, count = np.unique(np.concatenate([a, b]), axis=0, return_counts=True)
    return np.asarray(rows[count == 2], dtype=np.int64)


def _judged(shape: Complex, contact: _Contact, objects: tuple[str, str], unit: str) -> Defect | None:
    """Return what is wrong with the contact of two surfaces; None for one connected polyline."""
    if len(contact.triangles):
        return _overlap(shape, contact.triangles, objects, unit)
    vertices = contact.vertices[:, 0]
    edges = np.searchsorted(vertices, contact.edges)
    labels = components(len(vertices), edges)
    pieces = int(labels.max()) + 1
    points = np.flatnonzero(np.bincount(edges.ravel(), minlength=len(vertices)) == 0)
    degree = np.bincount(edges.ravel(), minlength=len(vertices))
    forks = np.flatnonzero(degree > 2)
    positions = shape.vertices[vertices]
    title = f"{objects[0]} and {objects[1]}"
    if pieces > 1:
        lengths = np.linalg.norm(positions[edges[:, 1]] - positions[edges[:, 0]], axis=1)
        total = (
            np.bincount(labels[edges[:, 0]], lengths, minlength=pieces) if len(edges) else np.zeros(pieces)
        )
        rest = np.flatnonzero(np.arange(pieces) != np.argmax(total))
        places = np.stack([_on_it(positions[labels == k]) for k in rest])
        only = "only in points" if len(points) == pieces else f"in {pieces} separate pieces"
        if 0 < len(points) < pieces:
            only += f", {len(points)} of them {'a single point' if len(points) == 1 else 'single points'}"
        return _contact_defect(objects, f"{title} meet {only}.", places, pieces, "pieces")
    if not len(edges):
        return _contact_defect(objects, f"{title} touch in a single point.", positions, 1, "points")
    if len(forks):
        return _contact_defect(
            objects,
            f"The line in which {title} meet forks at {plural(len(forks), 'point')}.",
            positions[forks],
            int(degree.max()),
            "branches",
        )
    if len(edges) >= len(vertices):
        return _contact_defect(
            objects, f"The line in which {title} meet is closed.", positions, len(edges), "edges"
        )
    return None


def _overlap(shape: Complex, triangles: IntArray, objects: tuple[str, str], unit: str) -> Defect:
    areas = triangle_areas(shape.vertices, ints(triangles))
    places = centroids(shape.vertices, ints(triangles))
    return Defect(
        objects,
        f"{objects[0]} and {objects[1]} coincide over an area, in {plural(len(triangles), 'triangle')}.",
        "Take the common part out of one of the two, or keep only one of them.",
        count=len(triangles),
        value=float(areas.sum()),
        unit=f"{unit}²" if unit else "",
        place=places[np.argmax(areas)],
        places=floats(places, -1, 3),
        blocks=True,
    )


def _contact_defect(
    objects: tuple[str, str], message: str, places: FloatArray, value: int, unit: str
) -> Defect:
    return Defect(
        objects,
        message,
        "Move one of the two so that they cross in one line or stay apart.",
        count=len(places),
        value=float(value),
        unit=unit,
        place=places[0],
        places=floats(places, -1, 3),
    )


def _on_it(points: FloatArray) -> FloatArray:
    """Return the point of a set that is nearest to its middle."""
    return np.asarray(points[np.argmin(np.linalg.norm(points - points.mean(axis=0), axis=1))])


CHECK = Check(
    "pairwise-connected",
    "3.2, condition 2",
    "Two faults meet in nothing or in one connected polyline.",
    need=Need.COMPLEX,
    repairable=True,
    run=_run,
)
