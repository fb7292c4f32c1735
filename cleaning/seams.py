"""Two parts of a fault sewn together where the vertices of their rims face each other one by one."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from scipy.spatial import cKDTree

from graben.arrays import BoolArray, FloatArray, IntArray, bools, floats, ints
from graben.cleaning.repairing import Step, Task
from graben.cleaning.shaping.bridging import LEAST_ANGLE, LEAST_FACED, boxes_near, in_turn
from graben.cleaning.shaping.limits import ROUNDING
from graben.cleaning.shaping.patching import folds, frame_at
from graben.cleaning.shaping.shared import shared_vertices
from graben.proximity import nearest
from graben.surface import Surface, boundary_edges, strong_components
from graben.validators.measuring.measures import amount, areas_of, lengths, places_of, smallest_angles
from graben.validators.self_intersection import TOUCH

#: The check that is answered.
CHECK = "strongly-connected"
#: So many pieces, the largest, are sewn to each other.
_MOST_SEWN = 24
#: Widest gap that is sewn, in edges of the rims: a missing row of equilateral triangles is 0.87 wide.
_WIDEST = 0.75
#: Rims up to so many times as far apart as those of a seam would belong to it.
_ALIKE = 1.5
#: So many edges of a rim may face the other beyond the ends of a seam: at its two corners.
_BEYOND = 2


@dataclass(frozen=True, eq=False)
class _Rim:
    """A rim of a part: its vertices (k,) in turn, and whether the last is followed by the first."""

    vertices: IntArray
    closed: bool


@dataclass(frozen=True, eq=False)
class Pieces:
    """The pieces of a fault by size: the piece of each triangle (m,), the largest 0, and areas (p,)."""

    label: IntArray
    areas: FloatArray


@dataclass(frozen=True, eq=False)
class Seam:
    """Two parts sewn together.

    Parameters
    ----------
    surface : Surface
        The result.
    points : (k, 3) array
        The merged vertices in turn, model units.
    gap : float
        How far they were apart at most, model units.
    flipped : bool
        Whether the triangles of the second part were turned, to agree with the first.
    """

    surface: Surface
    points: FloatArray
    gap: float
    flipped: bool


def pieces_by_size(surface: Surface) -> Pieces:
    """Return the pieces of a surface; vertices at one place count as one."""
    label = strong_components(places_of(surface)[surface.triangles])
    areas = np.bincount(label, areas_of(surface))
    order = np.argsort(-areas, kind="stable")
    rank = np.empty(len(order), dtype=np.int64)
    rank[order] = np.arange(len(order))
    return Pieces(ints(rank[label]), floats(areas[order]))


def sewn_together(task: Task, surface: Surface) -> tuple[Surface, list[Step]]:
    """Return a fault with those of its pieces sewn together that can be, and what is said of each seam.

    Parameters
    ----------
    task : Task
        With the other faults, and the limits.
    surface : Surface
        The fault, as changed so far.
    """
    move = min(task.max_move(surface.name), task.max_extension(surface.name))
    touch = task.model.checks.get("self-intersection", TOUCH * task.model.size)
    others = [f.surface for f in task.model.faults if f.name != surface.name]
    steps: list[Step] = []
    while True:
        pieces = pieces_by_size(surface)
        masks = [bools(pieces.label == k) for k in range(min(len(pieces.areas), _MOST_SEWN))]
        held = shared_vertices(surface, others) if len(masks) > 1 else bools([])
        near = (
            (first, second)
            for first, second in combinations(masks, 2)
            if boxes_near(surface, first, second, 2.0 * move)
        )
        tried = (sewn(surface, first, second, held, move, touch) for first, second in near)
        seam = next((made for made in tried if made), None)
        if seam is None:
            return surface, steps
        surface = seam.surface
        steps.append(_step(task, surface.name, seam))


def _step(task: Task, name: str, seam: Seam) -> Step:
    """Return what is said of a seam."""
    length = float(lengths(np.diff(seam.points, axis=0)).sum())
    turned = " The smaller one was turned to agree with the other." if seam.flipped else ""
    reason = (
        f"Two pieces of {name} were sewn together along {amount(length, task.unit)}: the vertices of their "
        f"rims face each other one by one, no more than {amount(seam.gap, task.unit)} apart, and were merged "
        f"half way.{turned}"
    )
    count = len(seam.points)
    return Step(CHECK, (name,), count, seam.points[count // 2], reason, seam.gap, task.unit)


def sewn(
    surface: Surface, first: BoolArray, second: BoolArray, held: BoolArray, move: float, touch: float
) -> Seam | None:
    """Return a surface with two parts sewn together, facing vertices merged half way between them.

    A fault that was cut through has the same vertices on both sides of the cut. A strip between them would
    have to be as ragged as the cut; this gives back what was.

    Parameters
    ----------
    surface : Surface
        Its triangles turned one way in each part.
    first, second : (m,) arrays
        The triangles of the two parts; the second is the smaller.
    held : (n,) array
        Vertices that stay in place: the other one comes to them.
    move : float
        How far a vertex may be moved, model units.
    touch : float
        Depth of a crossing that counts, model units.

    Returns
    -------
    Seam or None
        None where the rims do not face each other so, or the result would not be sound.
    """
    rims = [_rims(surface, part) for part in (first, second)]
    edges = [boundary_edges(surface.triangles[part]) for part in (first, second)]
    if not all(map(len, edges)):
        return None
    sides = surface.vertices[np.concatenate(edges)]
    widest = min(2.0 * move, _WIDEST * float(np.median(lengths(sides[:, 1] - sides[:, 0]))))
    best, flipped = ints([], 0, 2), False
    for turned in (False, True):
        for one in rims[0]:
            for two in rims[1]:
                pairs = _matched(surface.vertices, one, two, widest, turned)
                if len(pairs) > len(best):
                    best, flipped = pairs, turned
    if len(best) < 3 or not _whole(surface.vertices, best, edges):
        return None
    made = _merged(surface, best, held, move)
    if made is None:
        return None
    sound, index = made
    if flipped:
        turn = np.where(second[:, None], sound.triangles[:, [1, 0, 2]], sound.triangles)
        sound = replace(sound, triangles=ints(turn))
    if _faulty(sound, ints(index[best[:, 0]]), touch):
        return None
    gaps = surface.vertices[best[:, 0]] - surface.vertices[best[:, 1]]
    points = floats(sound.vertices[index[best[:, 0]]])
    return Seam(sound, points, float(lengths(gaps).max()), flipped)


def _rims(surface: Surface, part: BoolArray) -> list[_Rim]:
    """Return the rims of a part, each in turn."""
    edges = boundary_edges(surface.triangles[part])
    found = []
    for chain in in_turn(edges) if len(edges) else []:
        closed = bool(edges[chain[0], 0] == edges[chain[-1], 1])
        vertices = edges[chain, 0] if closed else np.append(edges[chain, 0], edges[chain[-1], 1])
        found.append(_Rim(ints(vertices), closed))
    return found


def _matched(vertices: FloatArray, one: _Rim, two: _Rim, widest: float, turned: bool) -> IntArray:
    """Return the longest run of facing vertices of two rims, (k, 2): step by step along both."""
    b = two.vertices if turned else two.vertices[::-1]
    # twice around, so that a run over the end of the list stays one
    a = np.tile(one.vertices, 2) if one.closed else one.vertices
    near = cKDTree(vertices[a]).query_ball_tree(cKDTree(vertices[b]), widest)
    i = np.repeat(np.arange(len(a)), [len(found) for found in near])
    j = ints([k for found in near for k in sorted(found)])
    if not len(j):
        return ints([], 0, 2)
    # rims that run side by side keep their offset from step to step
    offset = (j - i) % len(b) if two.closed else j - i
    best, best_gap = ints([], 0, 2), np.inf
    for k in np.unique(offset):
        at = offset == k
        run = _run(i[at])
        pairs = np.stack([a[run], b[(run + k) % len(b)]], axis=1)
        if len(pairs) >= min(len(one.vertices), len(b)):
            continue
        gap = float(lengths(vertices[pairs[:, 0]] - vertices[pairs[:, 1]]).sum())
        if len(pairs) > len(best) or (len(pairs) == len(best) and gap < best_gap):
            best, best_gap = ints(pairs), gap
    return best


def _run(at: IntArray) -> IntArray:
    """Return the longest run of consecutive numbers among ascending ones."""
    return ints(max(np.split(at, np.flatnonzero(np.diff(at) > 1) + 1), key=len))


def _whole(vertices: FloatArray, pairs: IntArray, edges: list[IntArray]) -> bool:
    """Return whether a seam leaves no facing edges of the rims open but those at its ends."""
    ends = vertices[pairs[[0, -1], 0]]
    chord = (ends[1] - ends[0]) / max(float(np.linalg.norm(ends[1] - ends[0])), np.finfo(float).tiny)
    seam = float(np.ptp(vertices[pairs[:, 0]] @ chord))
    if seam < LEAST_FACED * float(np.ptp(vertices[np.unique(edges[1])] @ chord)):
        return False
    widest = _ALIKE * float(lengths(vertices[pairs[:, 0]] - vertices[pairs[:, 1]]).max())
    for side in (0, 1):
        own, other = edges[side], edges[1 - side]
        away = nearest(floats(vertices[own].mean(axis=1), -1, 3), vertices, other).distance
        inside = np.isin(own, pairs[:, side]).all(axis=1)
        if int((~inside & (away <= widest)).sum()) > _BEYOND:
            return False
    return True


def _merged(
    surface: Surface, pairs: IntArray, held: BoolArray, move: float
) -> tuple[Surface, IntArray] | None:
    """Return the surface with each pair of vertices one, and the new index of each old vertex."""
    a, b = surface.vertices[pairs[:, 0]], surface.vertices[pairs[:, 1]]
    stays = held[pairs]
    if (stays.all(axis=1) & (a != b).any(axis=1)).any():
        return None
    share = np.where(stays[:, :1], 0.0, np.where(stays[:, 1:], 1.0, 0.5))
    place = np.where(stays[:, :1], a, np.where(stays[:, 1:], b, (1.0 - share) * a + share * b))
    if max(lengths(place - a).max(), lengths(place - b).max()) > move * (1.0 + ROUNDING):
        return None
    vertices = np.array(surface.vertices)
    vertices[pairs[:, 0]] = place
    kept = np.ones(len(vertices), dtype=np.bool_)
    kept[pairs[:, 1]] = False
    target = np.arange(len(vertices))
    target[pairs[:, 1]] = pairs[:, 0]
    index = ints((np.cumsum(kept) - 1)[target])
    made = replace(surface, vertices=floats(vertices[kept]), triangles=ints(index[surface.triangles], -1, 3))
    return made, index


def _faulty(surface: Surface, seam: IntArray, touch: float) -> bool:
    """Return whether triangles at a seam are turned over, cross others or are slivers."""
    at = bools(np.isin(surface.triangles, seam).any(axis=1))
    order = np.argsort(at, kind="stable")
    last = replace(surface, triangles=surface.triangles[order], lines=ints([]))
    if folds(last, int(at.sum()), frame_at(surface, seam), touch):
        return True
    return float(smallest_angles(surface.vertices, surface.triangles[at]).min()) < LEAST_ANGLE
