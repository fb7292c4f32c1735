"""Small models for the tests of the modeling stage, made from functions of x and y."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from graben.arrays import FloatArray, IntArray
from graben.demo import HORIZON, SyntheticModel
from graben.formats.irap import grid_surface
from graben.model import Fault, GridGeometry, Horizon, Model
from graben.settings import Parameters
from graben.surface import Surface

Height = Callable[[FloatArray, FloatArray], FloatArray]


def grid_horizon(height: Height, size: float = 4000.0, step: float = 100.0, name: str = "H") -> Horizon:
    """A horizon on a square grid about the origin."""
    count = round(size / step) + 1
    grid = GridGeometry(count, count, step, step, (-size / 2, -size / 2))
    x, y = np.moveaxis(grid.nodes(), -1, 0)
    return Horizon(name, grid_surface(name, grid, height(x, y)), step, grid)


def grid_triangles(columns: int, rows: int) -> IntArray:
    i = (np.arange(columns - 1)[:, None] * rows + np.arange(rows - 1)).ravel()
    return np.concatenate(
        [np.stack([i, i + rows, i + rows + 1], axis=1), np.stack([i, i + rows + 1, i + 1], axis=1)]
    )


def plane_fault(
    start: tuple[float, float],
    end: tuple[float, float],
    dip: float = 60.0,
    depth: float = 400.0,
    name: str = "F1",
    parts: tuple[int, int] = (24, 9),
) -> Fault:
    """A plane fault whose line at elevation 0 runs from start to end and that dips to the right of it."""
    s = np.linspace(0.0, 1.0, parts[0])
    z = np.linspace(-depth, depth, parts[1])
    ss, zz = np.meshgrid(s, z, indexing="ij")
    way = np.subtract(end, start)
    right = np.array([way[1], -way[0]]) / np.hypot(*way)
    plan = np.asarray(start) + ss[..., None] * way - (zz / np.tan(np.radians(dip)))[..., None] * right
    points = np.concatenate([plan, zz[..., None]], axis=-1).reshape(-1, 3)
    return Fault(Surface(name, points, grid_triangles(*parts)))


def model_of(horizon: Horizon, *faults: Fault, **parameters: object) -> Model:
    """A model with one horizon."""
    return Model("test", (horizon,), faults, parameters=Parameters.model_validate(parameters))


def model_of_demo(made: SyntheticModel, **parameters: object) -> Model:
    """The model that a synthetic model's files would give."""
    horizon = Horizon(HORIZON, grid_surface(HORIZON, made.grid, made.values), made.grid.step, made.grid)
    settings = Parameters.model_validate({"gamma": made.gamma, **parameters})
    return Model(made.name, (horizon,), tuple(Fault(f) for f in made.faults), parameters=settings)
