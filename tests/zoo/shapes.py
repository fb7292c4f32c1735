"""What the zoo is built of: sheets of triangles, and providers that stand in for the modeling stage."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from graben.complexes import Complex
from graben.cutgraph import CutGraph, NodeKind
from graben.errors import ModelingError
from graben.model import Fault, Horizon, Model
from graben.settings import Parameters
from graben.surface import Surface
from graben.validators.context import Anchoring

STEP = 50.0
N, T, X, J, L = NodeKind.INTERIOR, NodeKind.TIP, NodeKind.EXIT, NodeKind.JUNCTION, NodeKind.LOOSE


@dataclass(frozen=True)
class Fakes:
    """Providers that hand out what a case was made with; a text in place of a value is an error."""

    shape: Complex | str = field(default_factory=lambda: Complex([], [], [], []))
    graphs: Mapping[str, CutGraph | str] = field(default_factory=dict)
    anchors: Mapping[str, tuple[Anchoring, ...] | str] = field(default_factory=dict)

    def complex(self, model: Model) -> Complex:
        return _given(self.shape)

    def graph(self, model: Model, horizon: Horizon, complex: Complex) -> CutGraph:
        return _given(self.graphs.get(horizon.name, CutGraph(horizon.name, [], [], [], [])))

    def anchoring(self, model: Model, horizon: Horizon, graph: CutGraph) -> tuple[Anchoring, ...]:
        return _given(self.anchors.get(horizon.name, (anchoring(100),)))


def _given(value):
    if isinstance(value, str):
        raise ModelingError(value)
    return value


def sheet(columns: int, rows: int, place, name: str = "F") -> Surface:
    """A grid of triangles whose vertex (i, j) lies at ``place(i, j)``."""
    i, j = np.meshgrid(np.arange(columns + 1), np.arange(rows + 1), indexing="ij")
    vertices = np.stack(np.broadcast_arrays(*place(i.ravel().astype(float), j.ravel().astype(float))), axis=1)
    a = (np.arange(columns)[:, None] * (rows + 1) + np.arange(rows)[None, :]).ravel()
    b, c, d = a + rows + 1, a + rows + 2, a + 1
    return Surface(name, vertices, np.concatenate([np.c_[a, b, c], np.c_[a, c, d]]))


def dipping(dip: float, columns: int = 6, rows: int = 4, name: str = "F") -> Surface:
    """A planar fault that strikes along x and dips towards +y."""
    c, s = STEP * np.cos(np.radians(dip)), STEP * np.sin(np.radians(dip))
    return sheet(columns, rows, lambda i, j: (STEP * i, c * j, -s * j), name)


def two_triangles(dip: float = 60.0, name: str = "F") -> Surface:
    return dipping(dip, 1, 1, name)


def level(name: str = "H", size: int = 8, points=None) -> Horizon:
    surface = sheet(size, size, lambda i, j: (STEP * i, STEP * j, 0.1 * STEP * i), name)
    return Horizon(
        name, surface, STEP, picks=np.zeros((0, 3)) if points is None else np.asarray(points, float)
    )


def folded_points(dip_of_limb: float, relief: float = 8.0, spread: float = 2.0):
    """Points of a fold: flat, a limb of the given dip (above 90: overturned), flat; relief in steps."""
    run = relief / np.tan(np.radians(dip_of_limb))
    t = np.linspace(0, 1, int(4 * relief))
    profile = np.concatenate(
        [
            np.c_[np.arange(-6, 0, 0.5), np.zeros(12)],
            np.c_[run * t, relief * t],
            np.c_[run + np.arange(0.5, 6.5, 0.5), np.full(12, relief)],
        ]
    )
    y = np.linspace(-spread, spread, 9) * 0.94  # no two points exactly a step apart
    points = np.array(
        [(x + 0.01 * np.sin(7 * v), v, z) for k, (x, z) in enumerate(profile) for v in y[k % 2 :: 2]]
    )
    return STEP * points


def faults(*surfaces: Surface, horizons=(), **keys) -> Model:
    return Model("zoo", tuple(horizons), tuple(Fault(s) for s in surfaces), unit="m", **keys)


def scene(*surfaces: Surface, **keys) -> Model:
    """The surfaces in the middle of a gently sloping horizon that F60 cuts, with a gamma of two steps."""
    top = sheet(14, 12, lambda i, j: (STEP * (i - 4), STEP * (j - 5), 2 * i + j - 95), "H")
    settings = Parameters(gamma=2 * STEP)
    return faults(*surfaces, horizons=[Horizon("H", top, STEP)], parameters=settings, **keys)


def joined(surface: Surface, other: Surface) -> Surface:
    return Surface(
        surface.name,
        np.concatenate([surface.vertices, other.vertices]),
        np.concatenate([surface.triangles, other.triangles + len(surface.vertices)]),
    )


def anchoring(fixed: int, spread: bool = True, place=(0.0, 0.0, 0.0), subdomain: int = 0) -> Anchoring:
    return Anchoring(subdomain, ("F",), fixed, spread, np.array(place, float))


def graph(nodes, kinds, edges, owner, dropped=()) -> CutGraph:
    plan = STEP * np.array(nodes, float).reshape(-1, 2)
    return CutGraph("H", np.c_[plan, 0.1 * plan[:, 0]], [int(k) for k in kinds], edges, owner, tuple(dropped))


def moved_vertex(surface: Surface, vertex: int, to) -> Surface:
    vertices = surface.vertices.copy()
    vertices[vertex] = to
    return surface.with_vertices(vertices)


def without(surface: Surface, triangles) -> Surface:
    return replace(surface, triangles=np.delete(surface.triangles, triangles, axis=0))


NAN = float("nan")
F60 = dipping(60.0)
MIDDLE = 2 * 5 + 2  # an inner vertex of F60
AT_MIDDLE = F60.vertices[MIDDLE]
