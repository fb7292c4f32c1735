"""duplicate: no two vertices at one place, no triangle twice."""

from __future__ import annotations

import numpy as np

from graben.arrays import floats, ints
from graben.surface import Surface
from graben.validators.context import Check, CheckContext, Defect
from graben.validators.measures import centroids, plural


def _run(context: CheckContext) -> list[Defect]:
    return [d for d in map(_surface, context.surfaces) if d is not None]


def _surface(surface: Surface) -> Defect | None:
    """Return the vertices equal to an earlier one, and the triangles on the places of an earlier one."""
    if len(surface.vertices) == 0:
        return None
    _, first, place = np.unique(surface.vertices + 0.0, axis=0, return_index=True, return_inverse=True)
    place = place.reshape(-1)
    vertices = np.setdiff1d(np.arange(len(surface.vertices)), first)
    corners = np.sort(place[surface.triangles], axis=1)
    _, once = np.unique(corners, axis=0, return_index=True)
    triangles = np.setdiff1d(np.arange(len(corners)), once)
    if not len(vertices) and not len(triangles):
        return None
    places = np.concatenate(
        [centroids(surface.vertices, surface.triangles[triangles]), surface.vertices[vertices]]
    )
    parts = []
    if len(vertices):
        parts.append(f"{plural(len(vertices), 'vertex', 'vertices')} at the place of another")
    if len(triangles):
        parts.append(f"{plural(len(triangles), 'triangle')} on the vertices of another")
    return Defect(
        (surface.name,),
        f"{surface.name} has {' and '.join(parts)}.",
        "Merge the vertices that coincide and keep one of each triangle.",
        count=len(vertices) + len(triangles),
        value=float(len(vertices) + len(triangles)),
        unit="elements",
        place=places[0],
        elements=ints(triangles if len(triangles) else vertices),
        places=floats(places, -1, 3),
    )


CHECK = Check(
    "duplicate",
    "3",
    "No two vertices lie at one place and no triangle stands twice.",
    repairable=True,
    run=_run,
)
