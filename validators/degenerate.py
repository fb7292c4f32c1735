"""degenerate: no triangle without area, no sliver on a fault."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from graben.arrays import FloatArray, IntArray, floats, ints
from graben.finding import Element, Part
from graben.surface import Surface
from graben.validators.context import Check, CheckContext, Defect, Scope, Tolerance
from graben.validators.measuring.measures import ANGLE_ROUNDING, angles_of, centroids, part_at
from graben.words import plural

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
    angles = angles_of(surface)
    flat = angles == 0.0
    bad = np.flatnonzero(flat | (angles < limit - ANGLE_ROUNDING))
    if not len(bad):
        return None
    if flat.all():
        message = f"No triangle of {surface.name} has an area."
        remedy = "Export the surface again: its triangles have collapsed to lines or points."
    else:
        kinds = [plural(k, "triangle") + what for k, what in _kinds(angles, bad, limit) if k]
        message = f"{surface.name} has {' and '.join(kinds)}."
        remedy = "Merge the vertices that coincide and flip or collapse the slivers, or remesh the surface."
    places = centroids(surface.vertices, surface.triangles[bad])
    worst = int(np.argmin(angles[bad]))
    return Defect(
        (surface.name,),
        message,
        remedy,
        count=len(bad),
        value=float(angles[bad[worst]]),
        unit="degrees",
        place=places[worst],
        elements=ints(bad),
        element=Element.TRIANGLE,
        places=floats(places, -1, 3),
        parts=tuple(_parts(angles[bad], places)),
        blocks=bool(flat.all()),
    )


def _kinds(angles: FloatArray, bad: IntArray, limit: float) -> list[tuple[int, str]]:
    """Return how many triangles have no area and how many a small angle, with the words for it."""
    flat = int((angles == 0.0).sum())
    return [(flat, " without area"), (len(bad) - flat, f" with an angle below {limit:g} degrees")]


def _parts(angles: FloatArray, places: FloatArray) -> Iterator[Part]:
    """Yield the triangles without area and the slivers, each with its worst."""
    for kind, of in (("triangle without area", angles == 0.0), ("sliver", angles > 0.0)):
        if of.any():
            worst = np.flatnonzero(of)[np.argmin(angles[of])]
            yield part_at(kind, int(of.sum()), places[worst], float(angles[worst]), "degrees")


CHECK = Check(
    "degenerate",
    "3",
    "Every triangle has an area, and no angle of a fault's triangle is below the limit.",
    "A triangle without area has no normal and no dip, and a sliver turns rounding errors into large "
    "moves of the cut.",
    _run,
    scope=Scope.MODEL,
    blocks_when="a surface without any area",
    tolerance=Tolerance(
        "least angle of a fault's triangle", "degrees", f"{ANGLE_LIMIT:g}", lambda model: [ANGLE_LIMIT]
    ),
    repairable=True,
)
