"""Hypothesis strategies: motions that no verdict may depend on, and surfaces of any kind of nonsense."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from graben.complexes import Complex
from graben.cutgraph import CutGraph, DroppedTrace
from graben.model import Fault, Horizon, Model
from graben.surface import Surface
from tests.zoo_shapes import Case, Fakes

FAR = 5e5


@dataclass(frozen=True)
class Motion:
    """A rotation about z, a shift, and another order of vertices, triangles and corners.

    Each point is moved by the same operations whatever its place in an array, so that points equal to
    the bit stay so.
    """

    angle: float
    offset: tuple[float, float, float]
    seed: int

    def points(self, points):
        c, s = np.cos(self.angle), np.sin(self.angle)
        x, y, z = np.asarray(points, float).reshape(-1, 3).T
        return np.stack([c * x - s * y, s * x + c * y, z], axis=1) + self.offset

    def surface(self, surface: Surface) -> Surface:
        rng = np.random.default_rng(self.seed)
        n = len(surface.vertices)
        order = rng.permutation(n)
        new = np.empty(n, dtype=np.int64)
        new[order] = np.arange(n)
        known = (surface.triangles >= 0) & (surface.triangles < n)
        triangles = np.where(known, new[np.where(known, surface.triangles, 0)] if n else 0, surface.triangles)
        triangles = np.array([np.roll(t, rng.integers(3)) for t in rng.permutation(triangles)])
        return Surface(surface.name, self.points(surface.vertices)[order], triangles)

    def complex(self, shape: Complex) -> Complex:
        order = np.random.default_rng(self.seed).permutation(len(shape.triangles))
        return Complex(
            self.points(shape.vertices), shape.triangles[order], shape.owner[order], shape.parent[order]
        )

    def graph(self, graph: CutGraph) -> CutGraph:
        order = np.random.default_rng(self.seed).permutation(len(graph.edges))
        dropped = [DroppedTrace(d.fault, d.length, self.points(d.place)[0], d.reason) for d in graph.dropped]
        return replace(
            graph,
            nodes=self.points(graph.nodes),
            edges=graph.edges[order],
            faults=graph.faults[order],
            dropped=tuple(dropped),
        )

    def model(self, model: Model) -> Model:
        shuffled = np.random.default_rng(self.seed).permutation
        horizons = [
            Horizon(h.name, self.surface(h.surface), h.step, picks=self.points(shuffled(h.picks)))
            for h in model.horizons
        ]
        return replace(
            model,
            horizons=tuple(horizons),
            faults=tuple(Fault(self.surface(f.surface)) for f in model.faults),
        )

    def providers(self, fakes: Fakes, origin) -> Fakes:
        """The same values moved, in the local frame whose origin is given."""
        local = replace(self, offset=tuple(np.array(self.offset) - origin))
        graphs = {k: g if isinstance(g, str) else local.graph(g) for k, g in fakes.graphs.items()}
        anchors = {
            k: a if isinstance(a, str) else tuple(replace(r, place=local.points(r.place)[0]) for r in a)
            for k, a in fakes.anchors.items()
        }
        shape = fakes.shape if isinstance(fakes.shape, str) else local.complex(fakes.shape)
        return Fakes(shape, graphs, anchors)


def motions() -> st.SearchStrategy[Motion]:
    """Rotations by any angle, shifts of up to 500 km, shuffles."""
    shift = st.integers(-500, 500).map(lambda k: 1e-3 * FAR * k)
    return st.builds(
        Motion,
        st.floats(0, 2 * np.pi),
        st.tuples(shift, shift, st.integers(-5000, 5000).map(float)),
        st.integers(0, 99),
    )


def cases(
    among: tuple[Case, ...], wanted: Callable[[Case], bool] = lambda _: True
) -> st.SearchStrategy[Case]:
    """One of the zoo."""
    return st.sampled_from([c for c in among if wanted(c)])


def nonsense(name: str) -> st.SearchStrategy[Surface]:
    """A surface with any coordinates, NaN and infinite ones too, and any indices."""
    number = st.one_of(st.sampled_from([0.0, 1.0, np.nan, np.inf, -1e300, 1e-300]), st.floats(-1e3, 1e3))
    vertices = arrays.arrays(np.float64, st.tuples(st.integers(0, 8), st.just(3)), elements=number)
    triangles = arrays.arrays(np.int64, st.tuples(st.integers(0, 8), st.just(3)), elements=st.integers(-1, 8))
    return st.builds(Surface, st.just(name), vertices, triangles)
