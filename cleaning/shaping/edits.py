"""Edits of a triangulation, one place at a time: edges collapsed and flipped, triangles left out."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from graben.arrays import ints
from graben.surface import Surface

Corners = tuple[int, int, int]


@dataclass(frozen=True)
class Edit:
    """One change of a triangulation that leaves what is around it as it is.

    Parameters
    ----------
    removed : tuple of int
        Triangles that go.
    added : tuple of (int, int, int)
        Corners of those that come.
    sources : tuple of int
        For each that comes: the triangle in whose place it stands.
    gone : int
        The vertex that is merged into a neighbour; -1 for none.
    """

    removed: tuple[int, ...]
    added: tuple[Corners, ...]
    sources: tuple[int, ...]
    gone: int = -1


class Patchwork:
    """A triangulation that is being edited; triangles keep their numbers, new ones get further ones."""

    def __init__(self, surface: Surface) -> None:
        self.surface = surface
        self.points = surface.vertices
        self._made: dict[int, Corners] = {}
        self._source: dict[int, int] = {}
        self._dead: set[int] = set()
        self._next = len(surface.triangles)
        flat = surface.triangles.ravel()
        self._order = np.argsort(flat, kind="stable")
        self._start = np.searchsorted(flat[self._order], np.arange(len(surface.vertices) + 1))
        self._around: dict[int, set[int]] = {}
        self.gone: set[int] = set()

    def alive(self, t: int) -> bool:
        """Return whether a triangle is still there."""
        return t not in self._dead

    def corners(self, t: int) -> Corners:
        """Return the vertices of a triangle."""
        if t in self._made:
            return self._made[t]
        a, b, c = self.surface.triangles[t].tolist()
        return a, b, c

    def around(self, v: int) -> set[int]:
        """Return the triangles at a vertex."""
        if v not in self._around:
            of = self._order[self._start[v] : self._start[v + 1]] // 3
            self._around[v] = set(of.tolist())
        return self._around[v]

    def at_edge(self, u: int, v: int) -> set[int]:
        """Return the triangles at an edge."""
        return self.around(u) & self.around(v)

    def neighbours(self, v: int) -> set[int]:
        """Return the vertices that share a triangle with a vertex."""
        return {w for t in self.around(v) for w in self.corners(t)} - {v}

    def rim_neighbours(self, v: int) -> list[int]:
        """Return the other ends of the edges at a vertex that have one triangle, in order."""
        return [w for w in sorted(self.neighbours(v)) if len(self.at_edge(v, w)) == 1]

    def apply(self, edit: Edit) -> list[int]:
        """Make an edit; return the numbers of the triangles that came."""
        for t in edit.removed:
            for v in set(self.corners(t)):
                self.around(v).discard(t)
            self._dead.add(t)
        for corners in edit.added:
            for v in corners:
                self.around(v)
        new = list(range(self._next, self._next + len(edit.added)))
        for t, corners, source in zip(new, edit.added, edit.sources, strict=True):
            self._made[t] = corners
            self._source[t] = self._source.get(source, source)
            for v in corners:
                self.around(v).add(t)
        self._next += len(new)
        if edit.gone >= 0:
            self.gone.add(edit.gone)
        return new

    def without_repeated(self, t: int) -> Edit | None:
        """Return the edit that leaves a triangle out, if two of its corners are one."""
        return Edit((t,), (), ()) if len(set(self.corners(t))) < 3 else None

    def without_spike(self, t: int) -> Edit | None:
        """Return the edit that leaves a triangle out, if two or three of its sides are of the rim."""
        a, b, c = self.corners(t)
        rim = sum(len(self.at_edge(u, v)) == 1 for u, v in ((a, b), (b, c), (c, a)))
        return Edit((t,), (), ()) if rim > 1 else None

    def without_rim(self, t: int) -> tuple[Corners, Edit] | None:
        """Return the edit that leaves out a triangle with one side on the rim and its third corner inside.

        With the corners in turn, those of that side first.
        """
        for k in range(3):
            a, b, c = (self.corners(t)[(k + j) % 3] for j in range(3))
            if len(self.at_edge(a, b)) == 1 and not self.rim_neighbours(c):
                return (a, b, c), Edit((t,), (), ())
        return None

    def flips(self, t: int) -> Iterator[Edit]:
        """Yield the edits that flip a side of a triangle that one other shares, facing the same way."""
        corners = self.corners(t)
        if len(set(corners)) < 3:
            return
        for k in range(3):
            c, a, b = corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]
            there = self.at_edge(a, b)
            if len(there) != 2:
                continue
            (s,) = there - {t}
            other = self.corners(s)
            if len(set(other)) < 3:
                continue
            (d,) = set(other) - {a, b}
            j = other.index(b)
            if other[(j + 1) % 3] == a and d != c and not self.at_edge(c, d):
                yield Edit((t, s), ((c, a, d), (c, d, b)), (t, s))

    def collapses(self, t: int) -> Iterator[tuple[int, int, Edit]]:
        """Yield the edits that merge a corner of a triangle into a neighbour, with both vertices.

        The surface stays a manifold, and its rim is merged along itself only.
        """
        if len(set(self.corners(t))) < 3:
            return
        for u in self.corners(t):
            near, rim = self.neighbours(u), self.rim_neighbours(u)
            for v in sorted(near):
                shared = self.at_edge(u, v)
                if len(near & self.neighbours(v)) != len(shared) or len(shared) > 2:
                    continue
                if rim and len(shared) != 1:
                    continue
                moved = sorted(self.around(u) - shared)
                added = tuple(_with(self.corners(s), u, v) for s in moved)
                if added:
                    yield u, v, Edit(tuple(sorted(self.around(u))), added, tuple(moved), u)

    def result(self) -> Surface:
        """Return the surface as edited, what is new in the place of what it replaces."""
        if not self._dead:
            return self.surface
        old = self.surface.triangles
        kept = np.setdiff1d(np.arange(len(old)), list(self._dead))
        new = [t for t in self._made if t not in self._dead]
        source = np.concatenate([kept, ints([self._source[t] for t in new])])
        triangles = np.concatenate([old[kept], ints([self._made[t] for t in new], -1, 3)])
        order = np.argsort(source, kind="stable")
        unused = np.setdiff1d(old, triangles)
        used = np.delete(np.arange(len(self.points)), unused)
        return replace(
            self.surface,
            vertices=self.points[used],
            triangles=ints(np.searchsorted(used, triangles[order]), -1, 3),
            lines=self.surface.lines[source[order]] if len(self.surface.lines) else self.surface.lines,
        )


def _with(corners: Corners, u: int, v: int) -> Corners:
    a, b, c = (v if w == u else w for w in corners)
    return a, b, c
