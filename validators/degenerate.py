"""degenerate: no triangle without area, no sliver on a fault."""

from __future__ import annotations

import numpy as np

from graben.arrays import floats, ints
from graben.surface import Surface
from graben.validators.context import Check, CheckContext, Defect
from graben.validators.measures import centroids, plural, smallest_angles

#: Smallest angle of a fault's triangle, degrees: a height of 1/115 of the longest side.
ANGLE_LIMIT = 0.5


def _run(context: CheckContext) -> list[Defect]:
    limit = context.tolerance("degenerate", ANGLE_LIMIT)
    found = [_surface(s, limit if context.is_fault(s.name) else 0.0) for s in context.surfaces]
    return [d for d in found if d is not None]


def _surface(surface: Surface, limit: float) -> Defect | None:
    """Return the triangles of a surface whose smallest angle is 0 or below ``limit`` degrees."""
    if len(surface.triangles) == 0:
        return Defect(
            (surface.name,),
            f"{surface.name} has no triangles.",
            "Give a surface with triangles, or take it out of the model.",
            count=0,
            blocks=True,
        )
    angles = smallest_angles(surface.vertices, surface.triangles)
    flat = angles == 0.0
    bad = np.flatnonzero(flat | (angles < limit))
    if not len(bad):
        return None
    worst = bad[np.argmin(angles[bad])]
    places = centroids(surface.vertices, surface.triangles[bad])
    parts = []
    if flat.any():
        parts.append(f"{plural(int(flat.sum()), 'triangle')} without area")
    if len(bad) > flat.sum():
        parts.append(
            f"{plural(len(bad) - int(flat.sum()), 'triangle')} with an angle below {limit:g} degrees"
        )
    whole = bool(flat.all())
    return Defect(
        (surface.name,),
        f"{surface.name} has {' and '.join(parts)}."
        if not whole
        else f"No triangle of {surface.name} has an area.",
        "Merge the vertices that coincide and flip or collapse the slivers, or remesh the surface."
        if not whole
        else "Export the surface again: its triangles have collapsed to lines or points.",
        count=len(bad),
        value=float(angles[worst]),
        unit="degrees",
        place=centroids(surface.vertices, surface.triangles[[worst]])[0],
        elements=ints(bad),
        places=floats(places, -1, 3),
        blocks=whole,
    )


CHECK = Check(
    "degenerate",
    "3",
    "Every triangle has an area, and no angle of a fault's triangle is below the limit.",
    repairable=True,
    tolerance="smallest angle of a fault's triangle, degrees",
    run=_run,
)
