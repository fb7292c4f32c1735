"""Faults made one simplicial complex with sound triangles (paper Sect. 3.2, condition 1)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from graben.arrays import BoolArray, FloatArray, IntArray, floats, ints
from graben.cleaning.shaping.complex_mesh import Net, put_together, taken
from graben.cleaning.shaping.complex_passes import Goal, around_bad, collapsed, flipped, renumbered, snapped
from graben.proximity import box_pairs, boxes
from graben.refinement import refined
from graben.surface import Surface, edge_table, triangle_normals
from graben.validators.measuring.measures import components

#: Passes after which bettering ends; a network needs some twenty.
MOST_PASSES = 80
#: So often a net is refined again where bettering made its surfaces cross anew.
MOST_ROUNDS = 4
#: The share of the freedom that is left in the next round.
STRICTER = 0.3


def stacked(surfaces: Sequence[Surface], meeting: BoolArray) -> Net:
    """Return the net of surfaces as they are; vertices equal to the bit are one.

    ``meeting`` (surfaces, surfaces) says which of them meet.
    """
    points = np.concatenate([s.vertices for s in surfaces]) + 0.0
    starts = np.cumsum([0, *(len(s.vertices) for s in surfaces)])
    triangles = np.concatenate([s.triangles + n for s, n in zip(surfaces, starts, strict=False)])
    used, flat = np.unique(triangles, return_inverse=True)
    vertices, index = np.unique(points[used], axis=0, return_inverse=True)
    normals = np.concatenate([_unit(triangle_normals(s.vertices, s.triangles)) for s in surfaces])
    owner = np.repeat(np.arange(len(surfaces)), [len(s.triangles) for s in surfaces])
    fresh = np.zeros(len(triangles), dtype=bool)
    return Net(vertices, index.reshape(-1)[flat].reshape(-1, 3), owner, normals, fresh, meeting)


def divided(net: Net, anew: bool = False) -> tuple[Net, int]:
    """Return the exact common refinement of the surfaces of a net, and how many triangles were divided.

    Surfaces may cross each other in any way; the parts of a divided triangle are fresh.

    Parameters
    ----------
    net : Net
        Surfaces that share vertices by index.
    anew : bool
        Whether only fresh triangles can cross others, all else being conforming already.
    """
    near = _crossing(net) if anew else np.ones(len(net.triangles), dtype=np.bool_)
    part = taken(net, near)
    count = int(net.owner.max(initial=-1)) + 1
    rows = [np.flatnonzero(part.owner == k) for k in range(count)]
    network = refined([Surface("", net.vertices, ints(part.triangles[r], -1, 3)) for r in rows])
    starts = np.cumsum([0, *map(len, rows)])
    parent = np.concatenate(rows)[starts[network.owner] + network.parent]
    parts = np.bincount(parent, minlength=len(part.fresh))
    if not (parts > 1).any():
        return net, 0
    fresh = np.asarray((parts[parent] > 1) | part.fresh[parent], dtype=np.bool_)
    made = Net(network.vertices, network.triangles, network.owner, part.normals[parent], fresh, net.meeting)
    return _one(taken(net, ~near), made), int((parts > 1).sum())


def _crossing(net: Net) -> BoolArray:
    """Return which triangles may cross a fresh one of another surface, or are one, shape (m,)."""
    low, high = boxes(net.vertices, net.triangles)
    fresh = np.flatnonzero(net.fresh)
    pairs = box_pairs(low[fresh], high[fresh], low, high)
    near = net.fresh.copy()
    near[pairs[net.owner[fresh[pairs[:, 0]]] != net.owner[pairs[:, 1]], 1]] = True
    return near


def _one(rest: Net, part: Net) -> Net:
    """Return two parts of a net, each with vertices of its own, as one; vertices equal to the bit are one."""
    points = np.concatenate([rest.vertices, part.vertices]) + 0.0
    moved = replace(part, triangles=part.triangles + len(rest.vertices))
    both = put_together(replace(rest, vertices=points), replace(moved, vertices=points))
    vertices, index = np.unique(points, axis=0, return_inverse=True)
    return replace(both, vertices=vertices, triangles=index.reshape(-1)[both.triangles])


def welded(net: Net, tolerance: float) -> Net:
    """Return a net in which vertices nearer to each other than a tolerance are one, its first in order.

    Exact intersections rounded to doubles leave vertices a rounding error apart, and triangles between them
    whose shape means nothing.
    """
    used = np.unique(net.triangles[net.fresh])
    pairs = cKDTree(net.vertices[used]).query_pairs(tolerance, output_type="ndarray")
    if not len(pairs):
        return net
    label = components(len(used), pairs)
    old = np.isin(used, net.triangles[~net.fresh])
    order = np.lexsort((np.arange(len(used)), ~old, label))
    first = order[np.unique(label[order], return_index=True)[1]]
    target = np.arange(len(net.vertices))
    target[used] = used[first[label]]
    return renumbered(net, target)


def bettered(net: Net, goal: Goal) -> Net:
    """Return a net whose bad triangles, of those that are fresh, are gone as far as that goes."""
    for _ in range(MOST_PASSES):
        done = 0
        for better in (collapsed, flipped, snapped):
            near = around_bad(net, goal)
            if not near.any():
                return net
            part, count = better(taken(net, near), goal)
            if count:
                net = put_together(taken(net, ~near), part)
            done += count
        if not done:
            break
    return net


def torn(net: Net) -> IntArray:
    """Return the surfaces with edges that have more than two of their triangles: they cross themselves."""
    edges, sides = edge_table(net.triangles)
    keys = net.owner[:, None] * len(edges) + sides
    key, count = np.unique(keys, return_counts=True)
    return np.unique(key[count > 2] // len(edges))


def conformed(net: Net, goal: Goal, contact: float) -> Net:
    """Return a net whose surfaces share vertices and edges wherever they meet, with sound triangles.

    The exact common refinement, brought back to good triangles: sides are collapsed and flipped, and lines
    led through vertices that nearly lie on them. No vertex is moved, so all lie on the surfaces refined.
    Where the new triangles cross anew, they are refined again, with less freedom.
    """
    for _ in range(MOST_ROUNDS):
        net, count = divided(net, anew=True)
        if not count:
            break
        net = bettered(welded(net, contact), goal)
        goal = replace(goal, off=STRICTER * goal.off)
    return net


def surfaces_of(net: Net, surfaces: Sequence[Surface]) -> tuple[Surface, ...]:
    """Return the surfaces of a net; one whose triangles are all as they were comes back as it is.

    In others, vertices and triangles that were there come first, in their order.
    """
    return tuple(_surface(net, k, surface) for k, surface in enumerate(surfaces))


def _surface(net: Net, owner: int, surface: Surface) -> Surface:
    used, local = np.unique(net.triangles[net.owner == owner], return_inverse=True)
    points = np.concatenate([surface.vertices, net.vertices[used]]) + 0.0
    # vertices equal to the bit have one number: that of the first of the surface, where it has them
    first, place = np.unique(points, axis=0, return_index=True, return_inverse=True)[1:]
    number = first[place.reshape(-1)]
    count = len(surface.vertices)
    was = number[:count][surface.triangles]
    now = number[count:][local.reshape(-1, 3)]
    base = len(points)
    known, found = (np.sort(t, axis=1) @ np.array([base * base, base, 1]) for t in (was, now))
    order = np.argsort(known, kind="stable")
    at = np.minimum(np.searchsorted(known[order], found), len(known) - 1)
    kept = known[order][at] == found
    if kept.all() and len(found) == len(known):
        return surface
    rank = np.where(kept, order[at], len(known) + np.arange(len(found)))
    now = now[np.argsort(rank, kind="stable")]
    left, corners = np.unique(now, return_inverse=True)
    return Surface(surface.name, floats(points[left]), ints(corners.reshape(-1, 3)), file=surface.file)


def _unit(vectors: FloatArray) -> FloatArray:
    size = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(vectors / np.where(size > 0, size, 1.0))
