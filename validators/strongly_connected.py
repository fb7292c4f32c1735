"""strongly-connected: one component per fault, joined through edges (paper Sect. 3.1)."""

from __future__ import annotations

import numpy as np

from graben.arrays import FloatArray, IntArray, floats, ints
from graben.finding import Element
from graben.surface import Surface
from graben.validators.context import Check, CheckContext, Defect
from graben.validators.measuring.measures import (
    areas_of,
    centroids,
    components,
    inner_points,
    largest_parts,
    percent,
    remembered,
    welded_mesh_of,
)

#: Share of the largest area by which another piece may be smaller and count as large.
AS_LARGE = 1e-9


def _run(context: CheckContext) -> list[Defect]:
    return [d for d in (_fault(f.surface, context.unit) for f in context.faults) if d is not None]


@remembered
def _fault(surface: Surface, unit: str) -> Defect | None:
    """Return the triangles outside the largest component.

    Vertices at one place count as one: a crack between them is a matter of `duplicate`.
    """
    mesh = welded_mesh_of(surface)
    m = len(mesh.triangles)
    # two triangles are joined through the edge that they share
    steps = np.stack([np.repeat(np.arange(m), 3), m + mesh.sides.ravel()], axis=1)
    labels = components(m + len(mesh.edges), steps)[:m]
    count = int(labels.max(initial=0)) + 1
    if count == 1:
        return None
    middles = centroids(surface.vertices, mesh.triangles)
    areas = floats(np.bincount(labels, areas_of(surface)[mesh.kept]))
    loose = np.delete(np.arange(count), _main(labels, areas, middles[:, 2]))
    inner = inner_points(middles, labels)[loose]
    outside = np.isin(labels, loose)
    share = percent(areas[loose].sum(), areas.sum())
    return Defect(
        (surface.name,),
        f"{surface.name} consists of {count} pieces that share no edge; {share} of its area lies "
        "outside the largest.",
        "Join the pieces along their edges, or give each as a fault of its own.",
        count=count - 1,
        value=float(count),
        unit="pieces",
        place=inner[np.argmax(areas[loose])],
        elements=ints(mesh.kept[outside]),
        element=Element.TRIANGLE,
        places=floats(middles[outside], -1, 3),
        parts=largest_parts(
            "loose piece", areas[loose], np.bincount(labels)[loose], inner, f"{unit}²" if unit else ""
        ),
    )


def _main(labels: IntArray, areas: FloatArray, heights: FloatArray) -> int:
    """Return the largest component; of several as large the one that lies highest."""
    largest = areas >= areas.max() * (1.0 - AS_LARGE)
    level = np.bincount(labels, heights) / np.bincount(labels)
    return int(np.argmax(np.where(largest, level, -np.inf)))


CHECK = Check(
    "strongly-connected",
    "3.1",
    "Each fault is one strongly connected component.",
    "A cut node moves along its fault from triangle to triangle and cannot leap to another part.",
    _run,
    faults_only=True,
    repairable=True,
)
