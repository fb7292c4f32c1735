"""What all corruptions work with: the value they give, and places of a fault that they may touch."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from itertools import combinations

import numpy as np
from scipy.spatial import cKDTree

from graben.arrays import BoolArray, FloatArray, IntArray, floats, ints
from graben.cleaning.shaping.shared import shared_vertices
from graben.model import Fault, Model
from graben.surface import (
    Surface,
    edge_sharing,
    edge_table,
    strong_components,
    triangle_areas,
    triangle_normals,
)

#: A corruption inside a fault keeps so many median edges away from its rim's neighbours and branch lines.
AWAY = 1.5
#: Share of max_move by which a corruption moves a surface at most, so that a repair within max_move exists.
MOVE = 0.8
_TRIES = 40  # places looked at before a corruption gives a fault up


class CannotCorruptError(Exception):
    """No fault of the network has a place for a corruption."""


@dataclass(frozen=True, eq=False)
class Done:
    """What one corruption did: its kind, the faults it changed, places (p, 3), and a sentence."""

    kind: str
    faults: tuple[str, ...]
    places: FloatArray
    what: str


@dataclass(frozen=True, eq=False)
class Corrupted:
    """A corrupted network with the clean one it came from."""

    clean: Model
    model: Model
    done: tuple[Done, ...] = ()

    @property
    def kinds(self) -> tuple[str, ...]:
        return tuple(d.kind for d in self.done)

    def surface(self, name: str) -> Surface:
        return next(f.surface for f in self.model.faults if f.name == name)

    def limit(self, name: str) -> float:
        """How far a corruption may move the surface of a fault, m."""
        return MOVE * self.clean.max_move(next(f for f in self.clean.faults if f.name == name))

    def with_surfaces(self, surfaces: Sequence[Surface], done: Done) -> Corrupted:
        made = {s.name: s for s in surfaces}
        faults = tuple(Fault(made.get(f.name, f.surface), f.gamma) for f in self.model.faults)
        return replace(self, model=replace(self.model, faults=faults), done=(*self.done, done))


#: What a corruption of one fault gives: the surface, the places and a sentence; nothing where none is found.
Made = tuple[Surface, FloatArray, str] | None


@cache
def branch_points(clean: Model) -> dict[str, FloatArray]:
    """The points of each fault that lie on branch lines of a clean network, by the fault's name."""
    surfaces = [f.surface for f in clean.faults]
    return {s.name: floats(s.vertices[shared_vertices(s, surfaces)], -1, 3) for s in surfaces}


def shared_pairs(model: Model) -> Iterator[tuple[Surface, Surface]]:
    """The pairs of faults that have vertices equal to the bit."""
    for a, b in combinations([f.surface for f in model.faults], 2):
        if shared_vertices(a, [b]).any():
            yield a, b


@dataclass(frozen=True, eq=False)
class Sheet:
    """A fault with what is free to be corrupted: inside, away from the rim and from branch lines."""

    surface: Surface
    branches: FloatArray

    @property
    def triangles(self) -> IntArray:
        return self.surface.triangles

    @property
    def vertices(self) -> FloatArray:
        return self.surface.vertices

    @cached_property
    def edge(self) -> float:
        return self.surface.median_edge

    @cached_property
    def edges(self) -> tuple[IntArray, IntArray, IntArray]:
        """Edges, sides of triangles, and how many triangles have each edge."""
        edges, sides = edge_table(self.triangles)
        return edges, sides, edge_sharing(sides, len(edges))

    @cached_property
    def free(self) -> BoolArray:
        """Which vertices are off the rim, off fins, and away from branch lines."""
        edges, _, sharing = self.edges
        free = np.zeros(len(self.vertices), dtype=bool)
        free[np.unique(self.triangles)] = True
        free[edges[sharing != 2].ravel()] = False
        if len(self.branches):
            free &= cKDTree(self.branches).query(self.vertices)[0] > AWAY * self.edge
        return free

    @cached_property
    def open(self) -> IntArray:
        """Triangles with three free corners."""
        return np.flatnonzero(self.free[self.triangles].all(axis=1))

    @cached_property
    def middles(self) -> FloatArray:
        return floats(self.vertices[self.triangles].mean(axis=1))

    @cached_property
    def normals(self) -> FloatArray:
        """Unit normals of triangles."""
        n = triangle_normals(self.vertices, self.triangles)
        return floats(n / np.linalg.norm(n, axis=1)[:, None])

    @cached_property
    def normal(self) -> FloatArray:
        """The mean unit normal, upwards."""
        n = triangle_normals(self.vertices, self.triangles).sum(axis=0)
        return floats(n / np.linalg.norm(n) * (1.0 if n[2] >= 0 else -1.0))

    @cached_property
    def downdip(self) -> FloatArray:
        """Unit vector in plan of the mean dip direction, (3,)."""
        d = np.array([self.normal[0], self.normal[1], 0.0])
        return floats(d / np.linalg.norm(d))

    @cached_property
    def inner_edges(self) -> tuple[IntArray, IntArray]:
        """Edges between two triangles that are both open: (e, 2) vertices and (e, 2) triangles."""
        edges, sides, sharing = self.edges
        order = np.argsort(sides.ravel(), kind="stable")
        first = np.searchsorted(sides.ravel()[order], np.flatnonzero(sharing == 2))
        pairs = np.stack([order[first] // 3, order[first + 1] // 3], axis=1)
        good = np.isin(pairs, self.open).all(axis=1)
        return ints(edges[sharing == 2][good], -1, 2), ints(pairs[good], -1, 2)

    def some(self, rng: np.random.Generator, low: float, high: float) -> int:
        """A number of triangles that is a random share of all, 1 at least."""
        return max(1, round(rng.uniform(low, high) * len(self.triangles)))

    def patch(self, rng: np.random.Generator, count: int) -> IntArray | None:
        """About ``count`` open triangles that form a disk; none where no place was found."""
        if len(self.open) < count:
            return None
        tree = cKDTree(self.middles[self.open])
        for seed in rng.choice(self.open, min(_TRIES, len(self.open)), replace=False).tolist():
            near = self.open[np.atleast_1d(tree.query(self.middles[seed], count)[1])]
            label = strong_components(ints(self.triangles[near]))
            own = near[label == label[np.flatnonzero(near == seed)[0]]]
            if len(own) >= max(3, 0.8 * count) and _disk(self.triangles[own]):
                return np.sort(own)
        return None

    def apart(self, rng: np.random.Generator, corners: IntArray, count: int) -> IntArray:
        """Up to ``count`` rows of ``corners`` (n, k) at random that have no vertex or neighbour in common."""
        taken = np.zeros(len(self.vertices), dtype=bool)
        chosen: list[int] = []
        around = self._around
        for row in rng.permutation(len(corners)).tolist():
            if len(chosen) == count:
                break
            if not taken[corners[row]].any():
                chosen.append(row)
                taken[np.concatenate([around[v] for v in corners[row].tolist()])] = True
        return ints(chosen)

    @cached_property
    def _around(self) -> list[IntArray]:
        """Each vertex with its neighbours."""
        edges = self.edges[0]
        both = np.concatenate(
            [edges, edges[:, ::-1], np.repeat(np.arange(len(self.vertices)), 2).reshape(-1, 2)]
        )
        both = both[np.argsort(both[:, 0], kind="stable")]
        return np.split(both[:, 1], np.searchsorted(both[:, 0], np.arange(1, len(self.vertices))))

    def without(self, triangles: IntArray | BoolArray) -> Surface:
        """The surface without some triangles and the vertices that only these have."""
        kept = np.ones(len(self.triangles), dtype=bool)
        kept[triangles] = False
        used, local = np.unique(self.triangles[kept], return_inverse=True)
        return replace(self.surface, vertices=self.vertices[used], triangles=local.reshape(-1, 3))

    def grown(self, vertices: FloatArray, triangles: IntArray, kept: BoolArray | None = None) -> Surface:
        """The surface with vertices and triangles appended, and only those of its own that are ``kept``."""
        own = self.triangles if kept is None else self.triangles[kept]
        points = np.concatenate([self.vertices, np.reshape(vertices, (-1, 3))])
        both = np.concatenate([own, np.reshape(triangles, (-1, 3))])
        return replace(self.surface, vertices=points, triangles=ints(both))


def _disk(triangles: IntArray) -> bool:
    """Whether the boundary of triangles is one loop that passes each vertex once."""
    edges, sides = edge_table(ints(triangles))
    rim = edges[edge_sharing(sides, len(edges)) == 1]
    vertices, inner = np.unique(rim), len(edges) - len(rim)
    euler = len(np.unique(triangles)) - len(rim) - inner + len(triangles)
    return len(vertices) == len(rim) and euler == 1


def sheet_of(state: Corrupted, name: str) -> Sheet:
    return Sheet(state.surface(name), branch_points(state.clean)[name])


def by_area(state: Corrupted, rng: np.random.Generator) -> list[str]:
    """The names of the faults in a random order in which large ones tend to come first."""
    areas = np.array(
        [triangle_areas(f.surface.vertices, f.surface.triangles).sum() for f in state.clean.faults]
    )
    names = [f.name for f in state.clean.faults]
    order = rng.choice(len(names), len(names), replace=False, p=areas / areas.sum())
    return [names[k] for k in order]


def on_one_fault(
    kind: str, make: Callable[[Corrupted, Sheet, np.random.Generator], Made]
) -> Callable[[Corrupted, np.random.Generator], Corrupted]:
    """What corrupts the first fault that has a place for it."""

    def apply(state: Corrupted, rng: np.random.Generator) -> Corrupted:
        for name in by_area(state, rng):
            made = make(state, sheet_of(state, name), rng)
            if made is not None:
                surface, places, what = made
                done = Done(kind, (name,), floats(places, -1, 3), f"{name}: {what}")
                return state.with_surfaces([surface], done)
        raise CannotCorruptError(kind)

    return apply
