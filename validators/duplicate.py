"""duplicate: no two vertices at one place, no triangle twice."""

from __future__ import annotations

import numpy as np

from graben.arrays import IntArray, floats, ints
from graben.finding import Element
from graben.surface import Surface
from graben.validators.context import Check, CheckContext, Defect
from graben.validators.measuring.measures import centroids, once_of, part_at, places_of
from graben.words import plural


def _run(context: CheckContext) -> list[Defect]:
    return [d for d in map(_surface, context.surfaces) if d is not None]


def _surface(surface: Surface) -> Defect | None:
    """Return the vertices equal to an earlier one, and the triangles on the places of an earlier one."""
    place = places_of(surface)
    vertices = np.flatnonzero(place != np.arange(len(place)))
    once = np.zeros(len(surface.triangles), dtype=bool)
    once[once_of(surface)] = True
    triangles = np.flatnonzero(~once)
    if not len(vertices) and not len(triangles):
        return None
    kinds, parts = [], []
    middles = centroids(surface.vertices, surface.triangles[triangles])
    if len(vertices):
        kinds.append(f"{plural(len(vertices), 'vertex', 'vertices')} at the place of another")
        parts.append(part_at("vertex at the place of another", len(vertices), surface.vertices[vertices[0]]))
    if len(triangles):
        kinds.append(f"{plural(len(triangles), 'triangle')} on the vertices of another")
        parts.append(part_at("triangle on the vertices of another", len(triangles), middles[0]))
    places = np.concatenate([middles, surface.vertices[vertices]])
    return Defect(
        (surface.name,),
        f"{surface.name} has {' and '.join(kinds)}.",
        "Merge the vertices that coincide and keep one of each triangle.",
        count=len(vertices) + len(triangles),
        value=float(len(vertices) + len(triangles)),
        unit="elements",
        place=places[0],
        elements=ints(_at(surface, vertices, triangles) if len(triangles) else vertices),
        element=Element.TRIANGLE if len(triangles) else Element.VERTEX,
        places=floats(places, -1, 3),
        parts=tuple(parts),
    )


def _at(surface: Surface, vertices: IntArray, triangles: IntArray) -> IntArray:
    """Return the triangles given and those with a corner among the vertices, in order."""
    return np.union1d(triangles, np.flatnonzero(np.isin(surface.triangles, vertices).any(axis=1)))


CHECK = Check(
    "duplicate",
    "3",
    "No two vertices lie at one place and no triangle stands twice.",
    "Two vertices at one place are a crack through which no path along the surface leads.",
    _run,
    repairable=True,
)
