"""t-vertices: cracks along which vertices of one rim lie on edges of the other (answers `manifold`, ...).

A vertex that lies on an edge without being one of its ends leaves a boundary loop of no area there. A single
one is seen as a hole; where such loops follow each other they meet in points, which `manifold` sees, and
where they run from rim to rim the fault is in pieces, which `strongly-connected` sees.

PyMeshLab's filter for T-vertices was measured on a coarse strip beside a fine one: its edge-collapse mode
leaves all of them, since it looks for flat triangles and not for cracks, and its edge-flip mode refuses
surfaces whose loops meet in points. Hence the splits here.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from graben.arrays import BoolArray, FloatArray, IntArray, ints
from graben.cleaning.repairing import Change, Repair, Step, Task
from graben.cleaning.shaping.fans import crowded_edges
from graben.cleaning.stitch import cracks
from graben.proximity import box_pairs
from graben.surface import Surface, edge_sharing, edge_table
from graben.words import plural

#: Distance of a vertex from an edge, over the edge's length, up to which it lies on the edge: the hole beside
#: it is flatter than a triangle with an angle of half a degree, so that filling it would make a sliver.
ON_EDGE = 4e-3
#: Share of an edge within which a vertex at its end is a matter of merging and not of splitting.
_AT_END = 1e-2
#: After so many rounds splitting ends; each splits an edge at all vertices on it.
_MOST_ROUNDS = 8


@dataclass(frozen=True, eq=False)
class _Hanging:
    """Vertices on edges of the rim: the triangle, its corner opposite to the edge, and where on the edge."""

    vertex: IntArray
    triangle: IntArray
    corner: IntArray
    share: FloatArray

    def only(self, which: BoolArray | IntArray) -> _Hanging:
        return _Hanging(self.vertex[which], self.triangle[which], self.corner[which], self.share[which])


def closed_at_edges(surface: Surface, contact: float, most: float = np.inf) -> tuple[Surface, IntArray]:
    """Return the surface with the edges of its rims split at vertices of facing rims, and those vertices.

    No vertex moves: the triangle of such an edge is split, which bends it to the vertices on the edge. A
    surface without any comes back as it is.

    Parameters
    ----------
    surface : Surface
        A sound surface.
    contact : float
        Distance up to which a vertex lies on an edge however short the edge is, model units.
    most : float
        Distance beyond which it never does, model units.
    """
    done: list[IntArray] = []
    for _ in range(_MOST_ROUNDS):
        hanging = _hanging(surface, contact, most)
        made = _split(surface, hanging)
        # vertices that would give an edge a third triangle do not face it
        new = np.setdiff1d(crowded_edges(made.triangles), crowded_edges(surface.triangles))
        if len(new):
            hanging = hanging.only(~np.isin(hanging.vertex, new))
            made = _split(surface, hanging)
        if not len(hanging.vertex) or len(crowded_edges(made.triangles)) > len(
            crowded_edges(surface.triangles)
        ):
            break
        surface = made
        done.append(hanging.vertex)
    return surface, np.unique(np.concatenate(done)) if done else ints([])


def _hanging(surface: Surface, contact: float, most: float) -> _Hanging:
    """Return the vertices of rims that lie on facing edges of rims; of each triangle for one edge only."""
    t, points = surface.triangles, surface.vertices
    edges, sides = edge_table(t)
    triangle, corner = np.nonzero(edge_sharing(sides, len(edges))[sides] == 1)
    start, end = t[triangle, (corner + 1) % 3], t[triangle, (corner + 2) % 3]
    a, way = points[start], points[end] - points[start]
    length = np.linalg.norm(way, axis=1)
    near = np.minimum(np.maximum(contact, ON_EDGE * length), most)
    rim = np.unique(np.concatenate([start, end]))
    pad = near[:, None]
    low, high = np.minimum(a, a + way) - pad, np.maximum(a, a + way) + pad
    v, e = box_pairs(points[rim], points[rim], low, high).T
    v = rim[v]
    own = (t[triangle[e]] == v[:, None]).any(axis=1) | (length[e] == 0)
    v, e = v[~own], e[~own]
    share = ((points[v] - a[e]) * way[e]).sum(axis=1) / length[e] ** 2
    away = np.linalg.norm(points[v] - a[e] - share[:, None] * way[e], axis=1)
    inside = np.minimum(share, 1.0 - share) > np.maximum(_AT_END, contact / length[e])
    fit = inside & (away <= near[e])
    v, e, share = v[fit], e[fit], share[fit]
    found = _Hanging(v, triangle[e], corner[e], share).only(_facing(surface, v, triangle[e], corner[e]))
    # a triangle can be split along one of its edges at a time
    order = np.lexsort((found.share, found.corner, found.triangle))
    found = found.only(order)
    first = np.unique(found.triangle, return_index=True, return_inverse=True)
    return found.only(np.asarray(found.corner == found.corner[first[1]][first[2]]))


def _facing(surface: Surface, vertex: IntArray, triangle: IntArray, corner: IntArray) -> BoolArray:
    """Return where the triangles at a vertex lie on the other side of an edge than the edge's own triangle.

    Otherwise the vertex is on the far rim of a narrow strip, which has two rims close to each other too.
    """
    t, points = surface.triangles, surface.vertices
    n = len(points)
    count = np.maximum(np.bincount(t.ravel(), minlength=n), 1)
    middles = np.repeat(points[t].mean(axis=1), 3, axis=0)
    total = np.stack([np.bincount(t.ravel(), middles[:, k], minlength=n) for k in range(3)], axis=1)
    fan = total / count[:, None]
    a, b, c = (points[t[triangle, (corner + k) % 3]] for k in (1, 2, 0))
    way = (b - a) / np.linalg.norm(b - a, axis=1)[:, None]
    inward = (c - a) - ((c - a) * way).sum(axis=1)[:, None] * way
    return np.asarray(((fan[vertex] - a) * inward).sum(axis=1) < 0.0, dtype=np.bool_)


def _split(surface: Surface, hanging: _Hanging) -> Surface:
    """Return the surface with each triangle replaced by a fan to the vertices on its edge, in their order."""
    if not len(hanging.vertex):
        return surface
    t, start = np.unique(hanging.triangle, return_index=True)
    tip = surface.triangles[t, hanging.corner[start]]
    first = surface.triangles[t, (hanging.corner[start] + 1) % 3]
    last = surface.triangles[t, (hanging.corner[start] + 2) % 3]
    of = np.searchsorted(t, hanging.triangle)
    # along each edge: its start, the vertices on it, its end
    line = np.concatenate([first, hanging.vertex, last])
    owner = np.concatenate([np.arange(len(t)), of, np.arange(len(t))])
    share = np.concatenate([np.full(len(t), -np.inf), hanging.share, np.full(len(t), np.inf)])
    order = np.lexsort((share, owner))
    line, owner = line[order], owner[order]
    step = np.flatnonzero(owner[1:] == owner[:-1])
    new = np.stack([tip[owner[step]], line[step], line[step + 1]], axis=1)
    parent = t[owner[step]]
    kept = np.setdiff1d(np.arange(len(surface.triangles)), t)
    source = np.concatenate([kept, parent])
    place = np.argsort(source, kind="stable")
    return replace(
        surface,
        triangles=ints(np.concatenate([surface.triangles[kept], new])[place], -1, 3),
        lines=surface.lines[source[place]] if len(surface.lines) else surface.lines,
    )


def propose(task: Task) -> list[Change]:
    """Return for each fault with vertices on facing edges of its rims the fault with these edges split."""
    faults = {f.name: f.surface for f in task.model.faults}
    changes = []
    named = {n: f for f in reversed(task.findings) for n in f.objects if n in faults}
    for name, finding in named.items():
        made, split = closed_at_edges(faults[name], task.contact, task.max_move(name))
        if made is not faults[name]:
            reason = (
                f"Edges of {name} were split at {plural(len(split), 'vertex', 'vertices')} of the rim that "
                "lie on them, which closes the crack between."
            )
            step = Step(finding.check, (name,), len(split), faults[name].vertices[split[0]], reason)
            changes.append(Change({name: (made,)}, (step,)))
    return changes


REPAIR = Repair(
    "t-vertices",
    ("manifold", "strongly-connected"),
    "Splits edges of the rim at vertices of the facing rim that lie on them.",
    propose,
    answers=cracks,
)
