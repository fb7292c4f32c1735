"""manifold: an edge has one or two triangles, those around a vertex are one fan, and a fault has no hole."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from graben.arrays import IntArray, floats, ints
from graben.finding import Element
from graben.surface import Surface
from graben.validators.context import Check, CheckContext, Defect, Scope, Severity
from graben.validators.measuring.measures import (
    Mesh,
    amount,
    components,
    inner_points,
    largest_parts,
    mesh_of,
    part_at,
    remembered,
)
from graben.validators.measuring.openings import openings
from graben.words import plural

#: What a part is called that is a hole.
HOLE = "hole"


def _run(context: CheckContext) -> list[Defect]:
    found = []
    for surface in context.surfaces:
        holes = _holes(surface, context.unit) if context.is_fault(surface.name) else None
        defects = [d for d in (_surface(surface), holes) if d is not None]
        if defects:
            found.append(defects[0] if len(defects) == 1 else _both(*defects))
    return found


@remembered
def _surface(surface: Surface) -> Defect | None:
    """Return the edges with more than two triangles and the vertices with more than one fan."""
    mesh = mesh_of(surface)
    kept, triangles, edges, sides, sharing = mesh.kept, mesh.triangles, mesh.edges, mesh.sides, mesh.sharing
    if not len(triangles):
        return None
    crowded = np.flatnonzero(sharing > 2)
    pinched = np.setdiff1d(_pinched(mesh), edges[crowded])
    if not len(crowded) and not len(pinched):
        return None
    middles = surface.vertices[edges[crowded]].mean(axis=1).reshape(-1, 3)
    points = surface.vertices[pinched]
    worst = int(np.argmax(sharing[crowded])) if len(crowded) else 0
    touched = np.isin(sides, crowded).any(axis=1) | np.isin(triangles, pinched).any(axis=1)
    kinds, parts = [], []
    if len(crowded):
        most = float(sharing[crowded].max())
        kinds.append(f"{plural(len(crowded), 'edge')} with more than two triangles")
        parts.append(
            part_at("edge with more than two triangles", len(crowded), middles[worst], most, "triangles")
        )
    if len(pinched):
        kinds.append(f"{plural(len(pinched), 'vertex', 'vertices')} where parts touch in a point")
        parts.append(part_at("vertex where parts touch", len(pinched), points[0]))
    places = np.concatenate([middles, points])
    return Defect(
        (surface.name,),
        f"{surface.name} has {' and '.join(kinds)}.",
        "Split the surface there: take the extra sheet away, or give each part its own vertex.",
        count=len(crowded) + len(pinched),
        value=float(sharing[crowded].max()) if len(crowded) else float(len(pinched)),
        unit="triangles at an edge" if len(crowded) else "vertices",
        place=places[worst],
        elements=ints(kept[touched]),
        element=Element.TRIANGLE,
        places=floats(places, -1, 3),
        parts=tuple(parts),
        blocks=bool(len(crowded)),
    )


def _holes(surface: Surface, unit: str) -> Defect | None:
    """Return the holes of a fault."""
    holes = openings(surface)
    if not holes:
        return None
    edges = ints([hole.edges for hole in holes])
    around = floats([hole.length for hole in holes])
    loops = [surface.vertices[hole.loop] for hole in holes]
    rims = np.concatenate([loop[:-1] for loop in loops])
    inner = inner_points(rims, np.repeat(np.arange(len(holes)), edges))
    if len(holes) == 1:
        said = f"1 hole inside its rim, of {edges[0]} edges and {amount(around[0], unit)} around"
    else:
        said = (
            f"{len(holes)} holes inside its rim, the longest of {edges[0]} edges and "
            f"{amount(around[0], unit)} around"
        )
    return Defect(
        (surface.name,),
        f"{surface.name} has {said}.",
        "Fill the hole, unless the fault does end there.",
        count=len(holes),
        value=float(around[0]),
        unit=f"{unit} around a hole".lstrip(),
        place=inner[0],
        elements=ints(np.unique(np.concatenate([hole.triangles for hole in holes]))),
        element=Element.TRIANGLE,
        places=floats(rims, -1, 3),
        paths=tuple(floats(loop) for loop in loops),
        parts=largest_parts(HOLE, around, edges, inner, unit),
        severity=Severity.WARN,
    )


def _both(graver: Defect, holes: Defect) -> Defect:
    """Return what fails of a surface, with its holes: one finding, of the worst of what fails."""
    said = holes.message.removeprefix(f"{holes.objects[0]} has ")
    return replace(
        graver,
        message=f"{graver.message[:-1]}; also {said}",
        remedy=f"{graver.remedy} {holes.remedy}",
        count=graver.count + holes.count,
        elements=ints(np.union1d(graver.elements, holes.elements)),
        places=floats(np.concatenate([graver.places, holes.places])),
        paths=holes.paths,
        parts=graver.parts + holes.parts,
    )


def _pinched(mesh: Mesh) -> IntArray:
    """Return the vertices whose triangles form more than one fan, joined through edges at the vertex.

    Edges with more than two triangles join nothing here; their ends are no matter of this.
    """
    first, second = mesh.joints.T
    # the side opposite to corner k runs from corner k + 1 to k + 2, and its neighbour the other way
    start, end = (first // 3 * 3 + (first % 3 + step) % 3 for step in (1, 2))
    other = [second // 3 * 3 + (second % 3 + step) % 3 for step in (1, 2)]
    turned = mesh.triangles.ravel()[start] == mesh.triangles.ravel()[other[0]]
    if not turned.any():
        onward = np.full(mesh.triangles.size, -1)
        onward[start], onward[other[0]] = other[1], end
        return _not_walked(mesh.triangles.ravel(), onward)
    at_start, at_end = np.where(turned, other[0], other[1]), np.where(turned, other[1], other[0])
    steps = np.stack([np.concatenate([start, end]), np.concatenate([at_start, at_end])], axis=1)
    labels = components(mesh.triangles.size, steps)
    one_of_each = np.unique(labels, return_index=True)[1]
    return np.asarray(np.flatnonzero(np.bincount(mesh.triangles.ravel()[one_of_each]) > 1), dtype=np.int64)


def _not_walked(vertex: IntArray, onward: IntArray) -> IntArray:
    """Return the vertices that a walk from corner to corner does not go round, where all is oriented alike.

    Parameters
    ----------
    vertex : (c,) array
        The vertex of each corner.
    onward : (c,) array
        The next corner around the same vertex, each the next of one at most; -1 behind the last of a fan.
    """
    corners = np.bincount(vertex)
    begin = np.full(len(corners), -1)
    begin[vertex] = np.arange(len(vertex))
    first = np.ones(len(vertex), dtype=bool)
    first[onward[onward >= 0]] = False
    begin[vertex[first]] = np.flatnonzero(first)
    walked = (begin >= 0).astype(np.int64)
    at = np.flatnonzero(begin >= 0)
    corner = begin[at]
    while len(at):
        corner = onward[corner]
        goes_on = (corner >= 0) & (corner != begin[at])
        at, corner = at[goes_on], corner[goes_on]
        walked[at] += 1
    return np.flatnonzero(walked < corners)


CHECK = Check(
    "manifold",
    "3",
    "Edges have one or two triangles, the triangles around a vertex form one fan, and a fault has no holes.",
    "Where three sheets meet in an edge a surface has no two sides, so neither lip of a cut is defined; a "
    "hole in a fault breaks its trace.",
    _run,
    leniency="holes of a fault warn under both",
    scope=Scope.MODEL,
    blocks_when="edges with three triangles or more",
    repairable=True,
)
