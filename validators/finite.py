"""finite: coordinates and indices are finite and in range."""

from __future__ import annotations

import numpy as np

from graben.arrays import BoolArray, FloatArray, floats, ints
from graben.model import Horizon
from graben.surface import Surface
from graben.validators.context import Check, CheckContext, Defect
from graben.validators.measures import plural

#: From here on a coordinate is no place: 1e30 marks what is undefined, and products of more overflow.
USABLE = 1e20


def usable(coordinates: FloatArray) -> BoolArray:
    """Return which coordinates are finite numbers that a place can have, same shape."""
    return np.asarray(np.isfinite(coordinates) & (np.abs(coordinates) < USABLE), dtype=bool)


def _run(context: CheckContext) -> list[Defect]:
    found = [_surface(s) for s in context.model.surfaces]
    flawed = {d.objects[0] for d in found if d is not None}
    found += [_picks(h) for h in context.model.horizons if h.name not in flawed]
    return [d for d in found if d is not None]


def _surface(surface: Surface) -> Defect | None:
    """Return the vertices that are not numbers and the triangles whose indices are out of range."""
    n = len(surface.vertices)
    wrong = np.flatnonzero(~usable(surface.vertices).all(axis=1))
    outside = np.flatnonzero(((surface.triangles < 0) | (surface.triangles >= n)).any(axis=1))
    if not len(wrong) and not len(outside):
        return None
    triangles = surface.triangles[outside]
    corners = triangles[(triangles >= 0) & (triangles < n)]
    near = _finite_part(surface.vertices, _around(surface))
    places = _finite_part(near[np.concatenate([wrong, corners])], _middle(surface.vertices))
    parts = []
    if len(wrong):
        verb = "has" if len(wrong) == 1 else "have"
        parts.append(
            f"{plural(len(wrong), 'vertex', 'vertices')} {verb} a coordinate that is not a finite number"
        )
    if len(outside):
        parts.append(f"{plural(len(outside), 'triangle')} with a vertex index outside 0 to {n - 1}")
    return Defect(
        (surface.name,),
        f"In {surface.name}: {' and '.join(parts)}.",
        "Export the surface again, or remove these vertices and triangles from its file.",
        count=len(wrong) + len(outside),
        value=float(len(wrong) + len(outside)),
        unit="elements",
        place=places[0] if len(places) else None,
        elements=ints(outside if len(outside) else wrong),
        places=floats(places, -1, 3),
        blocks=True,
    )


def _picks(horizon: Horizon) -> Defect | None:
    """Return the input points that are not numbers."""
    wrong = np.flatnonzero(~usable(horizon.picks).all(axis=1))
    if not len(wrong):
        return None
    places = _finite_part(horizon.picks[wrong], _middle(horizon.picks))
    verb = "has" if len(wrong) == 1 else "have"
    return Defect(
        (horizon.name,),
        f"{plural(len(wrong), 'point')} of {horizon.name} {verb} a coordinate that is not a finite number.",
        "Remove these points from the horizon's file.",
        count=len(wrong),
        value=float(len(wrong)),
        unit="points",
        place=places[0] if len(places) else None,
        elements=ints(wrong),
        places=floats(places, -1, 3),
        blocks=True,
    )


def _finite_part(places: FloatArray, instead: FloatArray) -> FloatArray:
    """Return places with ``instead``, of the same shape or one for all, for each coordinate not finite."""
    return np.where(usable(places), places, instead)


def _middle(points: FloatArray) -> FloatArray:
    """Return the mean of the finite coordinates, shape (3,); 0 where there are none."""
    good = usable(points)
    return np.asarray(np.where(good, points, 0.0).sum(axis=0) / np.maximum(good.sum(axis=0), 1))


def _around(surface: Surface) -> FloatArray:
    """Return the mean of the finite coordinates of each vertex's neighbours, shape (n, 3); else NaN."""
    n = len(surface.vertices)
    inside = ((surface.triangles >= 0) & (surface.triangles < n)).all(axis=1)
    triangles = surface.triangles[inside]
    vertex, other = np.repeat(triangles, 3, axis=1).ravel(), np.tile(triangles, 3).ravel()
    mean = np.full((n, 3), np.nan)
    for k in range(3):
        values = surface.vertices[other, k]
        good = usable(values)
        count = np.bincount(vertex[good], minlength=n)
        total = np.bincount(vertex[good], values[good], minlength=n)
        mean[count > 0, k] = total[count > 0] / count[count > 0]
    return mean


CHECK = Check(
    "finite",
    "3",
    "Coordinates are finite numbers and vertex indices are in range.",
    run=_run,
)
