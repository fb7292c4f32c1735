"""strongly-connected: one component per fault, joined through edges (paper Sect. 3.1)."""

from __future__ import annotations

import numpy as np

from graben.arrays import floats, ints
from graben.surface import Surface, strong_components, triangle_areas
from graben.validators.context import Check, CheckContext, Defect
from graben.validators.measures import centroids, with_three_corners


def _run(context: CheckContext) -> list[Defect]:
    return [d for d in (_fault(f.surface) for f in context.faults) if d is not None]


def _fault(surface: Surface) -> Defect | None:
    """Return the triangles outside the largest component."""
    kept = with_three_corners(surface)
    if not len(kept):
        return None
    labels = strong_components(ints(surface.triangles[kept]))
    pieces = int(labels.max()) + 1
    if pieces == 1:
        return None
    areas = np.bincount(labels, triangle_areas(surface.vertices, surface.triangles[kept]))
    loose = np.flatnonzero(labels != np.argmax(areas))
    # one place for each loose component: the triangle of it next to its middle
    middles = centroids(surface.vertices, surface.triangles[kept[loose]])
    parts, part = np.unique(labels[loose], return_inverse=True)
    size = np.bincount(part)
    mean = np.stack([np.bincount(part, middles[:, k]) / size for k in range(3)], axis=1)
    order = np.lexsort((np.linalg.norm(middles - mean[part], axis=1), part))
    places = middles[order[np.concatenate([[0], np.cumsum(size)[:-1]])]]
    return Defect(
        (surface.name,),
        f"{surface.name} consists of {pieces} pieces that share no edge.",
        "Join the pieces along their edges, or give each as a fault of its own.",
        count=pieces - 1,
        value=float(pieces),
        unit="pieces",
        place=places[np.argmax(areas[parts])],
        elements=ints(kept[loose]),
        places=floats(places, -1, 3),
    )


CHECK = Check(
    "strongly-connected",
    "3.1",
    "Each fault is one strongly connected component.",
    faults_only=True,
    repairable=True,
    run=_run,
)
