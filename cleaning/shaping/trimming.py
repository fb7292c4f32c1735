"""A surface cut along the zero line of a function of its vertices, without slivers along the cut."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from graben.arrays import BoolArray, FloatArray, IntArray, bools, floats, ints
from graben.surface import (
    Surface,
    edge_sharing,
    edge_table,
    strong_components,
    triangle_areas,
    triangle_normals,
)
from graben.validators.measuring.measures import smallest_angles

#: A vertex nearer to the cut than this share of an edge is moved onto it: what is split off an edge is then
#: at least a quarter of it, and no angle along the cut far below 15 degrees where triangles are well shaped.
SNAP = 0.25
#: A move to the cut must leave the triangles around it this angle, degrees, or the angle that they had.
_LEAST_ANGLE = 10.0
#: A move to the cut must not turn a triangle around it further than this, as a cosine: 45 degrees.
_TURNED = 0.7
#: Rounds of taking moves back that harm; each takes back at least one, and most cuts need none.
_MOST_ROUNDS = 50


@dataclass(frozen=True, eq=False)
class Cut:
    """A surface with the zero line of a function of its vertices in its edges.

    Parameters
    ----------
    surface : Surface
        Its vertices in their order, some of them moved onto the line, then those in which edges are split.
    values : (n,) array
        The function on these vertices; 0 on the line.
    parent : (m,) array
        The triangle of the uncut surface of which each triangle is a part.
    kept : (m,) array
        Which triangles lie on the side where the function is positive.
    """

    surface: Surface
    values: FloatArray
    parent: IntArray
    kept: BoolArray


def trimmed(
    surface: Surface, values: FloatArray, held: BoolArray | None = None, snap: float = SNAP
) -> Surface:
    """Return the part of a surface where a function of its vertices is not negative.

    Parameters
    ----------
    surface : Surface
        With sound triangles.
    values : (n,) array
        The function at its vertices, taken as linear in each triangle; any unit.
    held : (n,) array, optional
        Vertices that must not be moved: where they are near to the cut, it goes through them.
    snap : float
        Share of an edge nearer than which a vertex is moved onto the cut.

    Returns
    -------
    Surface
        The rim along the cut lies on the zero line of the function along edges of the uncut surface. Vertices
        away from the cut are those of the surface, in their order; it is the very same surface where no value
        is negative, and has no triangles where none is positive. Several parts may remain, see
        :func:`main_part`.

    >>> square = Surface("F", [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], [[0, 1, 2], [1, 3, 2]])
    >>> half = trimmed(square, square.vertices[:, 0] - 0.5)
    >>> half.vertices[:, 0].min(), float(triangle_areas(half.vertices, half.triangles).sum())
    (np.float64(0.5), 0.5)
    """
    return divided(surface, values, held, snap)[0]


def divided(
    surface: Surface, values: FloatArray, held: BoolArray | None = None, snap: float = SNAP
) -> tuple[Surface, Surface]:
    """Return both parts of a surface, see :func:`trimmed`, with the same edges along the cut."""
    values = floats(values)
    if not (values < 0).any():
        return surface, part_of(surface, np.zeros(len(surface.triangles), dtype=np.bool_))
    cut = cut_along(surface, values, held, snap)
    return part_of(cut.surface, cut.kept), part_of(cut.surface, ~cut.kept)


def cut_along(surface: Surface, values: FloatArray, held: BoolArray | None = None, snap: float = SNAP) -> Cut:
    """Return a surface with the zero line of a function of its vertices in its edges, see :func:`trimmed`."""
    vertices, moved_values = _snapped(surface, floats(values), held, snap)
    triangles, parent, new, new_values = _split(vertices, surface.triangles, moved_values)
    after = floats(np.concatenate([moved_values, new_values]))
    corner = after[triangles]
    kept = corner.max(axis=1) > 0
    # a triangle wholly on the line goes with the side on which it was
    flat = (corner == 0).all(axis=1)
    kept[flat] = floats(values)[surface.triangles[parent[flat]]].sum(axis=1) >= 0
    lines = surface.lines[parent] if len(surface.lines) else surface.lines
    result = replace(
        surface,
        vertices=floats(np.concatenate([vertices, new])),
        triangles=ints(triangles),
        lines=ints(lines),
    )
    return Cut(result, after, ints(parent), bools(kept))


def part_of(surface: Surface, kept: BoolArray) -> Surface:
    """Return the triangles of a surface that a mask (m,) keeps, with the vertices that they use."""
    if kept.all():
        return surface
    used = np.unique(surface.triangles[kept])
    return replace(
        surface,
        vertices=surface.vertices[used],
        triangles=ints(np.searchsorted(used, surface.triangles[kept]), -1, 3),
        lines=surface.lines[kept] if len(surface.lines) else surface.lines,
    )


def main_part(surface: Surface) -> Surface:
    """Return the part of a surface, joined through edges, that has the largest area."""
    if not len(surface.triangles):
        return surface
    part = strong_components(surface.triangles)
    size = np.bincount(part, triangle_areas(surface.vertices, surface.triangles))
    return part_of(surface, np.asarray(part == np.argmax(size), dtype=np.bool_))


def _snapped(
    surface: Surface, values: FloatArray, held: BoolArray | None, snap: float
) -> tuple[FloatArray, FloatArray]:
    """Return the vertices moved onto the cut where they are near to it, and the values then."""
    edges, sides = edge_table(surface.triangles)
    rim = edge_sharing(sides, len(edges)) == 1
    edges, on_rim = _crossed(edges, rim, values)
    begin, end = edges.T
    share = values[begin] / (values[begin] - values[end])
    vertex = np.concatenate([begin, end])
    other = np.concatenate([end, begin])
    share = np.concatenate([share, 1.0 - share])
    along_rim = np.concatenate([on_rim, on_rim])
    way = share * np.linalg.norm(surface.vertices[other] - surface.vertices[vertex], axis=1)
    near = share < snap
    # a vertex of the rim stays on the rim where the cut leaves it there; else the nearest place counts
    order = np.lexsort((other, way, ~along_rim, vertex))
    order = order[near[order]]
    vertex, first = np.unique(vertex[order], return_index=True)
    to, share = other[order][first], share[order][first]
    place = surface.vertices[vertex] + share[:, None] * (surface.vertices[to] - surface.vertices[vertex])
    fixed = np.zeros(len(vertex), dtype=bool) if held is None else np.asarray(held)[vertex]
    place[fixed] = surface.vertices[vertex[fixed]]
    return _without_harm(surface, values, vertex, place, fixed)


def _crossed(edges: IntArray, rim: BoolArray, values: FloatArray) -> tuple[IntArray, BoolArray]:
    """Return the edges along which the values change sign, and which of them are of the rim."""
    cut = values[edges[:, 0]] * values[edges[:, 1]] < 0
    return edges[cut], np.asarray(rim[cut], dtype=np.bool_)


def _without_harm(
    surface: Surface, values: FloatArray, vertex: IntArray, place: FloatArray, fixed: BoolArray
) -> tuple[FloatArray, FloatArray]:
    """Move vertices to places on the cut, except where that spoils or turns a triangle or pinches a part."""
    old = surface.vertices
    before = smallest_angles(old, surface.triangles)
    normals = _unit_normals(old, surface.triangles)
    kept = np.ones(len(vertex), dtype=bool)
    for _ in range(_MOST_ROUNDS):
        vertices, moved = old.copy(), values.copy()
        vertices[vertex[kept]] = place[kept]
        moved[vertex[kept]] = 0.0
        angles = smallest_angles(vertices, surface.triangles)
        turned = (_unit_normals(vertices, surface.triangles) * normals).sum(axis=1)
        bad = (angles < np.minimum(before, _LEAST_ANGLE)) | ((turned < _TURNED) & (before > 0))
        harmed = np.zeros(len(old), dtype=bool)
        harmed[surface.triangles[bad]] = True
        harmed[_pinched(surface.triangles, moved)] = True
        back = kept & harmed[vertex] & ~fixed
        if not back.any():
            break
        kept &= ~back
    return floats(vertices), floats(moved)


def _pinched(triangles: IntArray, values: FloatArray) -> IntArray:
    """Return the vertices on the cut at which the part kept or the part left meets itself in that point only.

    Around an inner vertex there are two edges at most on which a side begins or ends, and around one of the
    rim one: the sides change more often around a pinched vertex.
    """
    corner = values[triangles]
    positive, negative = corner.max(axis=1) > 0, corner.min(axis=1) < 0
    t, k = np.nonzero(corner == 0)
    # the runs of each side around a vertex: fans of triangles joined through edges that hold the vertex
    mixed = positive & negative
    side = np.where(mixed, 0, np.where(positive, 1, -1))
    pinched = [np.zeros(0, dtype=np.int64)]
    for sign in (1, -1):
        chosen = (side[t] == sign) | (side[t] == 0)
        node, apart = _fans(triangles, t[chosen], k[chosen], sign * values)
        pinched.append(node[apart > 1])
    return np.unique(np.concatenate(pinched))


def _fans(triangles: IntArray, t: IntArray, k: IntArray, side: FloatArray) -> tuple[IntArray, IntArray]:
    """Return the vertices at corners k of triangles t, and in how many fans these triangles lie around each.

    A fan of n triangles has n - 1 edges between them, which the triangles hold twice; edges to vertices where
    ``side`` is negative join nothing.
    """
    node = triangles[t, k]
    if not len(node):
        return node, node
    spokes = np.concatenate([triangles[t, (k + 1) % 3], triangles[t, (k + 2) % 3]])
    keys = np.concatenate([node, node]) * (int(triangles.max()) + 1) + spokes
    keys = keys[side[spokes] >= 0]
    unique, uses = np.unique(keys, return_counts=True)
    joints = unique[uses == 2] // (int(triangles.max()) + 1)
    vertices, count = np.unique(node, return_counts=True)
    inner = np.bincount(np.searchsorted(vertices, joints), minlength=len(vertices))
    return vertices, count - inner


def _split(
    vertices: FloatArray, triangles: IntArray, values: FloatArray
) -> tuple[IntArray, IntArray, FloatArray, FloatArray]:
    """Return triangles with the cut in their edges, their parents, the new vertices and their values."""
    edges, sides = edge_table(triangles)
    cut = values[edges[:, 0]] * values[edges[:, 1]] < 0
    begin, end = edges[cut].T
    share = (values[begin] / (values[begin] - values[end]))[:, None]
    new = vertices[begin] + share * (vertices[end] - vertices[begin])
    number = np.full(len(edges), -1)
    number[cut] = len(vertices) + np.arange(len(new))
    on_side = number[sides]
    crossed = (on_side >= 0).sum(axis=1)
    whole = np.flatnonzero(crossed == 0)
    pieces, parents = [triangles[whole]], [whole]
    every = np.concatenate([vertices, new])
    for count, splitting in ((1, _halved), (2, _thirded)):
        chosen = np.flatnonzero(crossed == count)
        if len(chosen):
            made = splitting(every, triangles[chosen], on_side[chosen])
            pieces.append(made.reshape(-1, 3))
            parents.append(np.repeat(chosen, made.shape[1]))
    parent = np.concatenate(parents)
    order = np.argsort(parent, kind="stable")
    return ints(np.concatenate(pieces)[order]), ints(parent[order]), floats(new), np.zeros(len(new))


def _turned(triangles: IntArray, on_side: IntArray, first: IntArray) -> tuple[IntArray, IntArray]:
    """Return triangles and the new vertices on their sides with the given corner first."""
    order = (first[:, None] + np.arange(3)) % 3
    return np.take_along_axis(triangles, order, axis=1), np.take_along_axis(on_side, order, axis=1)


def _halved(every: FloatArray, triangles: IntArray, on_side: IntArray) -> IntArray:
    """Split triangles whose cut runs from a corner to the side opposite to it, (k, 2, 3)."""
    (a, b, c), (e, _, _) = (x.T for x in _turned(triangles, on_side, on_side.argmax(axis=1)))
    return np.stack([np.stack([a, b, e], axis=1), np.stack([a, e, c], axis=1)], axis=1)


def _thirded(every: FloatArray, triangles: IntArray, on_side: IntArray) -> IntArray:
    """Split triangles whose cut parts one corner from two, these by the better diagonal, (k, 3, 3)."""
    (a, b, c), (_, e, f) = (x.T for x in _turned(triangles, on_side, on_side.argmin(axis=1)))
    top = np.stack([a, f, e], axis=1)
    one = np.stack([np.stack([f, b, c], axis=1), np.stack([f, c, e], axis=1)], axis=1)
    two = np.stack([np.stack([f, b, e], axis=1), np.stack([b, c, e], axis=1)], axis=1)
    least = [smallest_angles(every, x.reshape(-1, 3)).reshape(-1, 2).min(axis=1) for x in (one, two)]
    rest = np.where((least[0] >= least[1])[:, None, None], one, two)
    return np.concatenate([top[:, None], rest], axis=1)


def _unit_normals(vertices: FloatArray, triangles: IntArray) -> FloatArray:
    normals = triangle_normals(vertices, triangles)
    size = np.linalg.norm(normals, axis=1)
    return floats(normals / np.where(size > 0, size, 1.0)[:, None])
