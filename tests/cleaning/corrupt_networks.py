"""Corruptions of how faults meet: gaps, stubs, branch lines that are no longer shared, and tangency."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.spatial import cKDTree

from graben.arrays import FloatArray, IntArray, floats, ints
from graben.cleaning.shaping.shared import shared_vertices
from graben.proximity import nearest
from graben.surface import Surface, boundary_edges, triangle_normals
from tests.cleaning.corrupt_sheets import (
    CannotCorruptError,
    Corrupted,
    Done,
    Sheet,
    branch_points,
    shared_pairs,
    sheet_of,
)

Rng = np.random.Generator

#: Gaps and stubs, in steps of the horizon.
OPEN = (0.2, 2.0)
#: Tangency, and how far a rim strays from the fault it ends on, in steps.
STRAY = 1e-3
_AWAY = 4.0  # a fault's triangles give way over so many median edges behind a gap
_BULGE, _LEAST_BULGE = 4.0, 1.5  # radius of a bulge in median edges, at most and at least
_BULGE_TRIES = 6  # places looked at for two faults
_BEHIND = 2.0  # m by which bulges stay behind the place of touch, so that nothing else comes near
_SLIDE = 0.3  # share of an edge by which vertices slide in their surface


@dataclass(frozen=True, eq=False)
class Ending:
    """A fault that ends on another along a branch line that both share."""

    splay: Surface
    main: Surface
    line: IntArray

    @cached_property
    def points(self) -> FloatArray:
        """The branch line, rising, (k, 3)."""
        return self.splay.vertices[self.line]

    def on_line(self, z: FloatArray) -> FloatArray:
        """Plan positions of the branch line, (n, 2)."""
        return floats(np.stack([np.interp(z, self.points[:, 2], self.points[:, k]) for k in (0, 1)], axis=-1))

    @cached_property
    def away(self) -> FloatArray:
        """Plan vectors from the branch line to the splay's vertices, (n, 2)."""
        return floats(self.splay.vertices[:, :2] - self.on_line(self.splay.vertices[:, 2]))

    @cached_property
    def distance(self) -> FloatArray:
        return floats(np.linalg.norm(self.away, axis=1))

    @cached_property
    def ways(self) -> FloatArray:
        """Unit vectors in plan along which the splay leaves each point of the line, (k, 2)."""
        near = (self.distance > 0) & (self.distance < 1.6 * self.splay.median_edge)
        way = []
        for z in self.points[:, 2]:
            weight = near / (1.0 + (self.splay.vertices[:, 2] - z) ** 2)
            v = (weight[:, None] * self.away).sum(axis=0)
            way.append(v / np.linalg.norm(v))
        return floats(way)

    @cached_property
    def across(self) -> FloatArray:
        """The mean unit normal of the main fault along the line, (3,)."""
        at = np.isin(self.main.triangles, np.flatnonzero(shared_vertices(self.main, [self.splay]))).any(
            axis=1
        )
        n = triangle_normals(self.main.vertices, self.main.triangles[at]).sum(axis=0)
        return floats(n / np.linalg.norm(n))

    def shifted(self, to: FloatArray, room: float) -> Surface:
        """The splay with the line moved ``to`` distances (k,) from the main, less and less up to ``room``."""
        v = self.splay.vertices
        target = np.interp(v[:, 2], self.points[:, 2], to)
        moving = self.distance < room
        new = np.where(moving, target + self.distance * (room - target) / room, self.distance)
        unit = self.away / np.maximum(self.distance, 1e-9)[:, None]
        unit[self.line] = self.ways
        made = np.column_stack([self.on_line(v[:, 2]) + new[:, None] * unit, v[:, 2]])
        behind = moving & (new > 0)
        made[behind] = nearest(floats(made[behind]), v, self.splay.triangles).place
        made[~moving] = v[~moving]
        return replace(self.splay, vertices=made)


def endings(state: Corrupted, rng: Rng) -> Iterator[Ending]:
    """The faults that end on another, as far as the branch line is still shared, in a random order."""
    pairs = [(a, b) for pair in shared_pairs(state.model) for a, b in (pair, pair[::-1])]
    for k in rng.permutation(len(pairs)).tolist():
        splay, main = pairs[k]
        shared = np.flatnonzero(shared_vertices(splay, [main]))
        rim = boundary_edges(splay.triangles)
        line = shared[np.argsort(splay.vertices[shared, 2])]
        if np.isin(rim, shared).all(axis=1).sum() >= len(shared) - 1 >= 2:
            yield Ending(splay, main, ints(line))


def _room(state: Corrupted, ending: Ending, wanted: float) -> float:
    """Up to what distance from its branch line a splay may be moved: not to its next branch line."""
    own = branch_points(state.clean)[ending.splay.name]
    away = np.linalg.norm(own[:, :2] - ending.on_line(own[:, 2]), axis=1)
    next_line = away[away > 1.0].min(initial=np.inf)
    return min(wanted, 0.9 * float(next_line))


def _profile(rng: Rng, ending: Ending, step: float) -> FloatArray:
    """Sizes along a branch line, even or growing from one end to the other, m."""
    sizes = np.exp(rng.uniform(np.log(OPEN[0]), np.log(OPEN[1]), 2)) * step
    if rng.random() < 0.5:
        sizes[1] = sizes[0]
    z = ending.points[:, 2]
    return floats(np.interp(z, z[[0, -1]], sizes))


def _step(state: Corrupted) -> float:
    return min(h.step for h in state.clean.horizons)


def _done(kind: str, ending: Ending, what: str) -> Done:
    return Done(kind, (ending.splay.name, ending.main.name), ending.points, what)


def gaps(state: Corrupted, rng: Rng) -> Corrupted:
    """A fault stops 0.2 to 2 steps short of the one it ended on."""
    for ending in endings(state, rng):
        gap = _profile(rng, ending, _step(state))
        room = _room(state, ending, max(3.0 * gap.max(), _AWAY * ending.splay.median_edge))
        if room < 2.0 * gap.max():
            continue
        what = f"{ending.splay.name} ends {gap.min():.0f} to {gap.max():.0f} m short of {ending.main.name}"
        return state.with_surfaces([ending.shifted(gap, room)], _done("gaps", ending, what))
    raise CannotCorruptError("gaps")


def stubs(state: Corrupted, rng: Rng) -> Corrupted:
    """A fault goes on 0.2 to 2 steps beyond the one it ended on, with common edges or without."""
    for ending in endings(state, rng):
        stub = _profile(rng, ending, _step(state))
        room = _room(state, ending, _AWAY * ending.splay.median_edge)
        if rng.random() < 0.5:
            made, how = _with_strip(ending, stub), "in common edges"
        elif room > 2.0 * ending.splay.median_edge:
            made, how = ending.shifted(-stub, room), "through its triangles"
        else:
            continue
        size = f"{stub.min():.0f} to {stub.max():.0f} m"
        what = f"{ending.splay.name} goes {size} beyond {ending.main.name}, {how}"
        return state.with_surfaces([made], _done("stubs", ending, what))
    raise CannotCorruptError("stubs")


def _with_strip(ending: Ending, length: FloatArray) -> Surface:
    """The splay with a strip of triangles added beyond its branch line."""
    splay, k = ending.splay, len(ending.line)
    count = max(1, round(float(length.mean()) / splay.median_edge))
    rows, points = [ending.line], []
    for n in range(1, count + 1):
        beyond = ending.points[:, :2] - (n / count * length)[:, None] * ending.ways
        points.append(np.column_stack([beyond, ending.points[:, 2]]))
        rows.append(ints(len(splay.vertices) + (n - 1) * k + np.arange(k)))
    rim = boundary_edges(splay.triangles)
    rises = bool((rim == ending.line[:2]).all(axis=1).any())
    added = []
    for near, far in pairwise(rows):
        a, b, c, d = near[:-1], near[1:], far[1:], far[:-1]
        cells = [np.stack([b, a, c], axis=1), np.stack([a, d, c], axis=1)]
        added += [cell if rises else cell[:, ::-1] for cell in cells]
    return replace(
        splay,
        vertices=np.concatenate([splay.vertices, *points]),
        triangles=np.concatenate([splay.triangles, *added]),
    )


def strayed(state: Corrupted, rng: Rng) -> Corrupted:
    """Two faults no longer share their branch line: its vertices slide in one of them or both."""
    pairs = [(a, b) for a, b in shared_pairs(state.model) if len(line_of(a, b)) > 2]
    if not pairs:
        raise CannotCorruptError("non-conforming")
    pair = pairs[rng.integers(len(pairs))]
    chosen = [(0, 1), (0,), (1,)][rng.integers(3)]
    made, stray = list(pair), STRAY * _step(state)
    # what the line lies inside of comes first: a rim that ends there is then laid on it
    for k in sorted((0, 1), key=lambda k: ends_on(pair[k], pair[1 - k])):
        own, other = pair[k], made[1 - k]
        if not ends_on(own, pair[1 - k]):
            made[k] = _slid_inside(own, pair[1 - k], rng) if k in chosen else own
        elif k in chosen or other is not pair[1 - k]:
            made[k] = _slid_along(own, (pair[1 - k], other), rng, _SLIDE * (k in chosen), stray)
    places = pair[0].vertices[shared_vertices(pair[0], [pair[1]])]
    slid = " and ".join(pair[k].name for k in chosen)
    what = f"the branch line of {pair[0].name} and {pair[1].name} has slid in {slid}"
    return state.with_surfaces(made, Done("non-conforming", (pair[0].name, pair[1].name), places, what))


def line_of(own: Surface, other: Surface) -> IntArray:
    """The vertices of a fault that another has as well, from below."""
    shared = np.flatnonzero(shared_vertices(own, [other]))
    return ints(shared[np.argsort(own.vertices[shared, 2])])


def ends_on(own: Surface, other: Surface) -> bool:
    """Whether a fault ends where it meets another: their branch line is part of its rim."""
    shared = line_of(own, other)
    return bool(np.isin(boundary_edges(own.triangles), shared).all(axis=1).sum() >= len(shared) - 1)


def _slid_inside(own: Surface, other: Surface, rng: Rng) -> Surface:
    """A fault whose vertices on a branch line inside it slide in its surface along strike."""
    shared = line_of(own, other)
    n = triangle_normals(own.vertices, own.triangles).sum(axis=0)
    strike = np.array([-n[1], n[0], 0.0]) / np.hypot(n[0], n[1])
    u = rng.uniform(0.3, 1.0, (len(shared), 1)) * rng.choice([-1.0, 1.0], (len(shared), 1))
    vertices = own.vertices.copy()
    moved = vertices[shared] + _SLIDE * own.median_edge * u * strike
    vertices[shared] = nearest(moved, own.vertices, own.triangles).place
    return replace(own, vertices=vertices)


def _slid_along(
    own: Surface, other: tuple[Surface, Surface], rng: Rng, share: float, stray: float
) -> Surface:
    """A fault whose rim slides along its branch line and strays from the other, as it was and as it is."""
    shared = line_of(own, other[0])
    vertices, line = own.vertices.copy(), own.vertices[shared]
    u = rng.uniform(0.3, 1.0, len(shared)) * rng.choice([-1.0, 1.0], len(shared))
    u[[0, -1]] = 0.0
    z = line[:, 2] + share * u * np.median(np.diff(line[:, 2]))
    slid = np.stack([np.interp(z, line[:, 2], line[:, k]) for k in range(3)], axis=-1)
    n = triangle_normals(other[1].vertices, other[1].triangles).sum(axis=0)
    off = rng.uniform(-1, 1, (len(slid), 1)) * n / np.linalg.norm(n)
    vertices[shared] = nearest(slid, other[1].vertices, other[1].triangles).place + stray * off
    return replace(own, vertices=vertices)


def _stray(rng: Rng) -> float:
    """How far a touch misses, in STRAY steps: not at all in half of all cases."""
    return float(rng.uniform(-1, 1)) if rng.random() < 0.5 else 0.0


def tangent(state: Corrupted, rng: Rng) -> Corrupted:
    """Two faults touch in a point, a line or a thin area, to within a thousandth of a step."""
    makers: list[Callable[[Corrupted, Rng], Corrupted | None]] = [_bulging, _pointed]
    for k in rng.permutation(2).tolist():
        made: Corrupted | None = makers[k](state, rng)
        if made is not None:
            return made
    raise CannotCorruptError("tangency")


def _pointed(state: Corrupted, rng: Rng) -> Corrupted | None:
    """A splay that is drawn back from the fault it ended on but for one vertex or edge of its rim."""
    step = _step(state)
    for ending in endings(state, rng):
        k = len(ending.line)
        first, count = int(rng.integers(1, k - 2)), int(rng.integers(1, 3))
        z = ending.points[:, 2]
        off = np.maximum(np.maximum(z[first] - z, z - z[first + count - 1]), 0.0)
        gap = np.where(off > 0, np.maximum(rng.uniform(0.3, 1.0) * off, OPEN[0] * step), 0.0)
        gap = np.minimum(gap, OPEN[1] * step)
        room = _room(state, ending, max(3.0 * gap.max(), _AWAY * ending.splay.median_edge))
        if room < 2.0 * gap.max():
            continue
        made = ending.shifted(floats(gap), room)
        vertices, touching = made.vertices.copy(), ending.line[first : first + count]
        off_main = STRAY * step * _stray(rng) * ending.across
        vertices[touching] = ending.splay.vertices[touching] + off_main
        what = f"{made.name} touches {ending.main.name} with {count} vertices of its rim"
        return state.with_surfaces([replace(made, vertices=vertices)], _done("tangency", ending, what))
    return None


def _bulging(state: Corrupted, rng: Rng) -> Corrupted | None:
    """Two faults side by side that both bulge, so that they touch in a point, an edge or a triangle."""
    names = [f.name for f in state.clean.faults]
    pairs = [(a, b) for a in names for b in names if a != b]
    for k in rng.permutation(len(pairs)).tolist():
        a, b = (sheet_of(state, name) for name in pairs[k])
        inside = np.flatnonzero(a.free)
        if not len(inside) or b.free.all():
            continue
        near = nearest(a.vertices[inside], b.vertices, b.triangles)
        reach = state.limit(pairs[k][0]) + state.limit(pairs[k][1])
        room = np.minimum(_to_held(a, a.vertices[inside]), _to_held(b, near.place)) / a.edge
        close = np.zeros(len(a.vertices), dtype=bool)
        close[inside] = (near.distance < reach) & (near.distance > 3.0 * _BEHIND) & (room > _LEAST_BULGE)
        count = int(rng.integers(1, 4))
        rows = {1: np.arange(len(close))[:, None], 2: a.edges[0], 3: a.triangles}[count]
        rows = rows[close[rows].all(axis=1)]
        for row in rng.permutation(len(rows))[:_BULGE_TRIES].tolist():
            made = _touched(state, (a, b), rows[row], rng)
            if made is not None:
                return made
    return None


def _to_held(sheet: Sheet, points: FloatArray) -> FloatArray:
    """The distance of points from the nearest vertex of a fault that must not move."""
    return floats(cKDTree(sheet.vertices[~sheet.free]).query(points)[0])


def _bulged(sheet: Sheet, middle: FloatArray, move: FloatArray) -> FloatArray:
    """The vertices of a fault moved around a place, less and less up to where it must not move."""
    radius = min(_BULGE * sheet.edge, float(_to_held(sheet, middle[None])[0]))
    share = np.clip(np.linalg.norm(sheet.vertices - middle, axis=1) / radius, 0.0, 1.0)
    window = np.where(sheet.free, np.cos(0.5 * np.pi * share) ** 2, 0.0)
    return floats(sheet.vertices + window[:, None] * move)


def _touched(state: Corrupted, pair: tuple[Sheet, Sheet], mine: IntArray, rng: Rng) -> Corrupted | None:
    """Two faults bulged until vertices of the first lie on a plane part of the second."""
    a, b = pair
    middle = a.vertices[mine].mean(axis=0)
    there = nearest(floats(middle[None]), b.vertices, b.triangles).place[0]
    half = 0.5 * (there - middle)
    normal = half / np.linalg.norm(half)
    half = half - _BEHIND * normal
    va, vb = _bulged(a, floats(middle), half).copy(), _bulged(b, floats(there), -half).copy()
    at = nearest(floats(np.concatenate([va[mine], va[mine].mean(axis=0)[None]])), vb, b.triangles)
    theirs = np.unique(b.triangles[np.unique(at.simplex)])
    if not b.free[theirs].all():
        return None
    # flat, so that an edge or a triangle can lie on it
    centre = vb[theirs].mean(axis=0)
    vb[theirs] += ((centre - vb[theirs]) @ normal)[:, None] * normal
    off = STRAY * _step(state) * _stray(rng)
    va[mine] += ((centre - va[mine]) @ normal + off)[:, None] * normal
    made = [replace(s.surface, vertices=v) for s, v in ((a, va), (b, vb))]
    names = (a.surface.name, b.surface.name)
    moved = [np.linalg.norm(m.vertices - s.vertices, axis=1).max() for m, s in zip(made, pair, strict=True)]
    if any(m > state.limit(name) for m, name in zip(moved, names, strict=True)):
        return None
    shape = ("a point", "a line", "an area")[len(mine) - 1]
    what = f"{names[0]} touches {names[1]} in {shape}"
    return state.with_surfaces(made, Done("tangency", names, floats(va[mine], -1, 3), what))
