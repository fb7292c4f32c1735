"""finite: coordinates and indices are finite and in range."""

from __future__ import annotations

import numpy as np

from graben.arrays import BoolArray, FloatArray, IntArray, floats, ints
from graben.finding import Element
from graben.model import UNFIT, Horizon
from graben.surface import Surface
from graben.validators.context import Check, CheckContext, Defect, Scope
from graben.validators.measuring.measures import part_at
from graben.words import plural

#: From here on a coordinate is no place: 1e30 marks what is undefined, and products of more overflow.
USABLE = 1e20


def usable(coordinates: FloatArray) -> BoolArray:
    """Return which coordinates are finite numbers that a place can have, same shape."""
    return np.asarray(np.isfinite(coordinates) & (np.abs(coordinates) < USABLE), dtype=bool)


def _run(context: CheckContext) -> list[Defect]:
    picks = {h.name: _picks(h) for h in context.model.horizons}
    # Of points that are no places the points are told, not the surface through the others.
    found = [picks.pop(s.name, None) or _surface(s) for s in context.model.surfaces]
    return [d for d in found if d is not None]


def _surface(surface: Surface) -> Defect | None:
    """Return the vertices that are not numbers and the triangles whose indices are out of range."""
    n = len(surface.vertices)
    wrong = np.flatnonzero(~usable(surface.vertices).all(axis=1))
    outside = np.flatnonzero(((surface.triangles < 0) | (surface.triangles >= n)).any(axis=1))
    if not len(wrong) and not len(outside):
        return None
    near = _finite_part(_finite_part(surface.vertices, _around(surface)), _middle(surface.vertices))
    triangles = surface.triangles[outside]
    there = (triangles >= 0) & (triangles < n)
    corners = np.where(there[:, :, None], near[np.where(there, triangles, 0)] if n else 0.0, 0.0)
    known = there.sum(axis=1)[:, None]
    ends = np.where(known > 0, corners.sum(axis=1) / np.maximum(known, 1), _middle(surface.vertices))
    places = np.concatenate([near[wrong], ends])
    kinds, parts = [], []
    if len(wrong):
        verb = "has" if len(wrong) == 1 else "have"
        kinds.append(
            f"{plural(len(wrong), 'vertex', 'vertices')} {verb} a coordinate that is no place (not a number, "
            "infinite, or a mark for undefined)"
        )
        parts.append(part_at("vertex that is no place", len(wrong), places[0]))
    if len(outside):
        verb = "names" if len(outside) == 1 else "name"
        kinds.append(f"{plural(len(outside), 'triangle')} {verb} a vertex that is not there")
        parts.append(part_at("triangle without all its vertices", len(outside), ends[0]))
    return Defect(
        (surface.name,),
        f"In {surface.name}: {' and '.join(kinds)}.",
        "Export the surface again, or remove these vertices and triangles from its file.",
        count=len(wrong) + len(outside),
        value=float(len(wrong) + len(outside)),
        unit="elements",
        place=places[0],
        elements=ints(_at(surface, wrong, outside) if len(outside) else wrong),
        element=Element.TRIANGLE if len(outside) else Element.VERTEX,
        places=floats(places, -1, 3),
        parts=tuple(parts),
        blocks=True,
    )


def _at(surface: Surface, vertices: IntArray, triangles: IntArray) -> IntArray:
    """Return the triangles given and those with a corner among the vertices, in order."""
    return np.union1d(triangles, np.flatnonzero(np.isin(surface.triangles, vertices).any(axis=1)))


def _picks(horizon: Horizon) -> Defect | None:
    """Return the input points that are not numbers."""
    wrong = np.flatnonzero(~usable(horizon.picks).all(axis=1))
    if not len(wrong):
        return None
    places = _finite_part(horizon.picks[wrong], _middle(horizon.picks))
    verb = "has" if len(wrong) == 1 else "have"
    told = "".join(f" {note}" for note in horizon.notes if UNFIT in note)
    return Defect(
        (horizon.name,),
        f"{plural(len(wrong), 'point')} of {horizon.name} {verb} a coordinate that is no place (not a "
        "number, infinite, or a mark for undefined); in their places below it is the mean of the others."
        f"{told}",
        "Remove these points from the horizon's file.",
        count=len(wrong),
        value=float(len(wrong)),
        unit="points",
        place=places[0],
        elements=ints(wrong),
        element=Element.PICK,
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
    "A coordinate that is no number poisons every sum it enters, so nothing further can be said of the "
    "surface.",
    _run,
    scope=Scope.MODEL,
    repairable=True,
)
