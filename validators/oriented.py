"""oriented: neighbouring triangles turn the same way."""

from __future__ import annotations

import numpy as np

from graben.arrays import floats, ints
from graben.finding import Element
from graben.surface import Surface, chained
from graben.validators.context import Check, CheckContext, Defect
from graben.validators.measuring.measures import Mesh, amount, mesh_of
from graben.validators.measuring.plan import orientation
from graben.words import plural


def _run(context: CheckContext) -> list[Defect]:
    return [d for d in (_surface(s, context.unit) for s in context.surfaces) if d is not None]


def _surface(surface: Surface, unit: str) -> Defect | None:
    """Return the edges that their two triangles run through in the same direction."""
    mesh = mesh_of(surface)
    if not len(mesh.triangles):
        return None
    balance = np.bincount(mesh.sides.ravel(), np.where(mesh.upward, 1.0, -1.0).ravel())
    bad = np.flatnonzero((mesh.sharing == 2) & (balance != 0))
    if not len(bad):
        return None
    ends = surface.vertices[mesh.edges[bad]]
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    places = ends.mean(axis=1)
    return Defect(
        (surface.name,),
        _message(surface.name, mesh, len(bad), amount(float(lengths.max()), unit)),
        "Turn the triangles so that all normals point to one side; cut it where there is no such way.",
        count=len(bad),
        value=float(lengths.max()),
        unit=unit,
        place=places[np.argmax(lengths)],
        elements=ints(mesh.kept[np.isin(mesh.sides, bad).any(axis=1)]),
        element=Element.TRIANGLE,
        places=floats(places, -1, 3),
        paths=tuple(floats(surface.vertices[chain]) for chain in chained(mesh.edges[bad])),
    )


def _message(name: str, mesh: Mesh, edges: int, longest: str) -> str:
    """Return how many triangles face the other way than most of their piece, where there is a way to tell.

    ``edges`` are those between triangles that disagree, ``longest`` is the length of the longest in words.
    """
    signs, part = orientation(mesh)
    fewer = np.minimum(np.bincount(part, signs > 0), np.bincount(part, signs < 0))
    turned = int(fewer.sum())
    if not turned:
        return f"{name} has one side only: its triangles cannot be turned so that all agree."
    verb = "faces" if turned == 1 else "face"
    return (
        f"{plural(turned, 'triangle')} of {name} {verb} the other way than the rest, along "
        f"{plural(edges, 'edge')} ({'the longest ' if edges > 1 else ''}{longest} long)."
    )


CHECK = Check(
    "oriented",
    "3",
    "The triangles of a surface are oriented consistently.",
    "Which lip is the hanging wall is read from the side to which triangles face.",
    _run,
    repairable=True,
)
