"""Hypothesis strategies: motions that no verdict may depend on, and surfaces of any kind of nonsense."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from graben.model import Fault, GridGeometry, Model
from graben.surface import Surface

FAR = 5e5


@dataclass(frozen=True)
class Motion:
    """A rotation about z, a shift, and another order of vertices, triangles and corners.

    Each point is moved by the same operations whatever its place in an array, so that points equal to
    the bit stay so.

    Parameters
    ----------
    angle : float
        Radians, counter-clockwise.
    offset : tuple of three float
        Model units.
    seed : int
        Of the shuffles; an odd one also turns every surface over.
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
        triangles = rng.permutation(triangles).reshape(-1, 3)
        turns = (np.arange(3) + rng.integers(3, size=len(triangles))[:, None]) % 3
        triangles = np.take_along_axis(triangles, turns, axis=1)
        if self.seed % 2:
            triangles = triangles[:, ::-1]
        return Surface(surface.name, self.points(surface.vertices)[order], triangles)

    def grid(self, grid: GridGeometry) -> GridGeometry:
        x, y, _ = (float(c) for c in self.points([*grid.origin, 0.0])[0])
        return replace(grid, origin=(x, y), rotation=grid.rotation + float(np.degrees(self.angle)))

    def model(self, model: Model) -> Model:
        shuffled = np.random.default_rng(self.seed).permutation
        horizons = [
            replace(
                h,
                surface=self.surface(h.surface),
                grid=None if h.grid is None else self.grid(h.grid),
                picks=self.points(shuffled(h.picks)),
            )
            for h in model.horizons
        ]
        return replace(
            model,
            horizons=tuple(horizons),
            faults=tuple(Fault(self.surface(f.surface), f.gamma) for f in model.faults),
        )


#: A turn, a shift by numbers that round badly, every order another, every surface turned over.
NASTY = Motion(0.7, (437211.37, -5211234.91, 812.3), 7)


def motions() -> st.SearchStrategy[Motion]:
    """Rotations by any angle, shifts of up to 500 km, shuffles, surfaces turned over."""
    shift = st.integers(-500, 500).map(lambda k: 1e-3 * FAR * k)
    return st.builds(
        Motion,
        st.floats(0, 2 * np.pi),
        st.tuples(shift, shift, st.integers(-5000, 5000).map(float)),
        st.integers(0, 99),
    )


def nonsense(name: str) -> st.SearchStrategy[Surface]:
    """A surface with any coordinates, NaN and infinite ones too, and any indices."""
    number = st.one_of(st.sampled_from([0.0, 1.0, np.nan, np.inf, -1e300, 1e-300]), st.floats(-1e3, 1e3))
    return _surfaces(name, number, st.integers(-1, 8))


def tangles(name: str) -> st.SearchStrategy[Surface]:
    """A surface of fit numbers whose triangles lie and meet in any way: few coordinates, many ties."""
    return _surfaces(name, st.integers(-3, 3).map(lambda k: 50.0 * k), st.integers(0, 7), 8)


def _surfaces(name, number, index, least: int = 0) -> st.SearchStrategy[Surface]:
    vertices = arrays.arrays(np.float64, st.tuples(st.integers(least, 8), st.just(3)), elements=number)
    triangles = arrays.arrays(np.int64, st.tuples(st.integers(0, 8), st.just(3)), elements=index)
    return st.builds(Surface, st.just(name), vertices, triangles)
