"""manifold: an edge has one or two triangles, and those around a vertex are one fan."""

from __future__ import annotations

import numpy as np

from graben.arrays import IntArray, floats, ints
from graben.surface import Surface, edge_sharing, edge_table
from graben.validators.context import Check, CheckContext, Defect
from graben.validators.measures import components, plural, with_three_corners


def _run(context: CheckContext) -> list[Defect]:
    return [d for d in map(_surface, context.surfaces) if d is not None]


def _surface(surface: Surface) -> Defect | None:
    """Return the edges with more than two triangles and the vertices with more than one fan."""
    kept = with_three_corners(surface)
    triangles = surface.triangles[kept]
    if not len(triangles):
        return None
    edges, sides = edge_table(ints(triangles))
    sharing = edge_sharing(sides, len(edges))
    crowded = np.flatnonzero(sharing > 2)
    pinched = np.setdiff1d(_pinched(triangles, edges, sides), edges[crowded])
    if not len(crowded) and not len(pinched):
        return None
    middles = surface.vertices[edges[crowded]].mean(axis=1).reshape(-1, 3)
    places = np.concatenate([middles, surface.vertices[pinched]])
    touched = np.isin(sides, crowded).any(axis=1) | np.isin(triangles, pinched).any(axis=1)
    parts = []
    if len(crowded):
        parts.append(f"{plural(len(crowded), 'edge')} with more than two triangles")
    if len(pinched):
        parts.append(f"{plural(len(pinched), 'vertex', 'vertices')} where parts touch in a point")
    worst = int(np.argmax(sharing[crowded])) if len(crowded) else 0
    return Defect(
        (surface.name,),
        f"{surface.name} has {' and '.join(parts)}.",
        "Split the surface there: take the extra sheet away, or give each part its own vertex.",
        count=len(crowded) + len(pinched),
        value=float(sharing[crowded].max()) if len(crowded) else float(len(pinched)),
        unit="triangles at an edge" if len(crowded) else "vertices",
        place=places[worst],
        elements=ints(kept[touched]),
        places=floats(places, -1, 3),
        blocks=bool(len(crowded)),
    )


def _pinched(triangles: IntArray, edges: IntArray, sides: IntArray) -> IntArray:
    """Return the vertices whose triangles form more than one fan, joined through edges at the vertex."""
    m = len(triangles)
    corners = np.repeat(np.arange(3 * m), 2)
    # two corners at one vertex are neighbours in its fan when their triangles share an edge that ends
    # there: corner k of a triangle ends its sides k + 1 and k + 2
    around = np.stack([np.roll(sides, -1, axis=1), np.roll(sides, -2, axis=1)], axis=2).reshape(-1)
    end = 2 * around + (edges[around, 1] == np.repeat(triangles.reshape(-1), 2))
    labels = components(3 * m + 2 * len(edges), np.stack([corners, 3 * m + end], axis=1))[: 3 * m]
    first = np.unique(labels, return_index=True)[1]
    return np.asarray(np.flatnonzero(np.bincount(triangles.reshape(-1)[first]) > 1), dtype=np.int64)


CHECK = Check(
    "manifold",
    "3",
    "Edges have one or two triangles, and the triangles around a vertex form one fan.",
    repairable=True,
    run=_run,
)
