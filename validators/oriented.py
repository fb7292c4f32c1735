"""oriented: neighbouring triangles turn the same way."""

from __future__ import annotations

import numpy as np

from graben.arrays import floats, ints
from graben.surface import Surface, edge_sharing, edge_table
from graben.validators.context import Check, CheckContext, Defect
from graben.validators.measures import plural, with_three_corners


def _run(context: CheckContext) -> list[Defect]:
    return [d for d in (_surface(s, context.unit) for s in context.surfaces) if d is not None]


def _surface(surface: Surface, unit: str) -> Defect | None:
    """Return the edges that their two triangles run through in the same direction."""
    kept = with_three_corners(surface)
    triangles = surface.triangles[kept]
    if not len(triangles):
        return None
    edges, sides = edge_table(ints(triangles))
    upward = triangles[:, [1, 2, 0]] < triangles[:, [2, 0, 1]]
    balance = np.bincount(sides.ravel(), np.where(upward, 1.0, -1.0).ravel(), minlength=len(edges))
    bad = np.flatnonzero((edge_sharing(sides, len(edges)) == 2) & (balance != 0))
    if not len(bad):
        return None
    ends = surface.vertices[edges[bad]]
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    places = ends.mean(axis=1)
    touched = np.isin(sides, bad).any(axis=1)
    return Defect(
        (surface.name,),
        f"The triangles at {plural(len(bad), 'edge')} of {surface.name} turn in opposite ways.",
        "Turn the triangles so that all normals point to one side; cut it where there is no such way.",
        count=len(bad),
        value=float(lengths.max()),
        unit=unit,
        place=places[np.argmax(lengths)],
        elements=ints(kept[touched]),
        places=floats(places, -1, 3),
    )


CHECK = Check(
    "oriented",
    "3",
    "The triangles of a surface are oriented consistently.",
    repairable=True,
    run=_run,
)
