"""What models of faults that cut a horizon are built of: a field of some twenty steps and its faults."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from graben.model import Fault, Horizon, Model
from graben.refinement import refined
from graben.settings import Parameters
from graben.surface import Surface
from tests.zoo.shapes import STEP, sheet

SLOPE = 0.05
#: Start and end of a plane fault at elevation 0, and its dip.
Line = tuple[Sequence[float], Sequence[float], float]


def slope(x, y):
    """The elevation of the common horizon: it rises to the north-east, so that no fault follows it."""
    return SLOPE * x + 0.6 * SLOPE * y


def flat(x, y):
    return 0.0 * x


def field(height: Callable = slope, size: int = 20, hole: Sequence[float] | None = None) -> Horizon:
    """A horizon of ``size`` by ``size`` cells about the origin; ``hole``: x0, x1, y0, y1 in steps."""
    half = size / 2

    def place(i, j):
        x, y = STEP * (i - half), STEP * (j - half)
        return x, y, height(x, y)

    surface = sheet(size, size, place, "H")
    if hole is not None:
        x, y, _ = (surface.vertices[surface.triangles].mean(axis=1) / STEP).T
        inside = (hole[0] < x) & (x < hole[1]) & (hole[2] < y) & (y < hole[3])
        used, flat_index = np.unique(surface.triangles[~inside], return_inverse=True)
        surface = replace(surface, vertices=surface.vertices[used], triangles=flat_index.reshape(-1, 3))
    return Horizon("H", surface, STEP)


def _level_line(start, end, dip: float, z):
    """The ends of the line of a plane fault at elevations z, in steps: two arrays (n, 2)."""
    way = np.subtract(end, start)
    right = np.array([way[1], -way[0]]) / np.hypot(*way)
    shift = -right * np.atleast_1d(z)[:, None] / np.tan(np.radians(dip))
    return np.asarray(start) + shift, np.asarray(end) + shift


def plane(
    start: Sequence[float],
    end: Sequence[float],
    name: str = "F",
    dip: float = 70.0,
    top: float = 2.0,
    bottom: float = -2.0,
    parts: tuple[int, int] = (2, 2),
    onto: Line | None = None,
    short: float | Callable = 0.0,
) -> Surface:
    """A plane fault, all in steps: its line at elevation 0 runs from start to end, it dips to the right.

    ``onto``: start, end and dip of another on which it ends, or ends ``short`` of it, steps; which may
    depend on the elevation.
    """

    def place(i, j):
        z = top + (bottom - top) * j / parts[1]
        first, last = _level_line(start, end, dip, z)
        if onto is not None:
            p, q = _level_line(*onto, z)
            way, other = last - first, q - p
            share = _cross(p - first, other) / _cross(way, other)
            missing = short(z) if callable(short) else short
            last = first + (share - missing / np.hypot(*way.T))[:, None] * way
        x, y = (STEP * (first + (last - first) * (i / parts[0])[:, None])).T
        return x, y, STEP * z

    return sheet(*parts, place, name)


def _cross(a, b):
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


def conforming(*surfaces: Surface, ends_on: Mapping[str, Line] = MappingProxyType({})) -> list[Surface]:
    """The surfaces as parts of one complex: where they meet they share edges, equal to the bit.

    What lies beyond the plane fault of ``ends_on`` is left out of the surface of that name.
    """
    shape = refined(surfaces)
    made = []
    for k, surface in enumerate(surfaces):
        triangles = shape.triangles[shape.owner == k]
        if surface.name in ends_on:
            x, y, z = (shape.vertices[triangles].mean(axis=1) / STEP).T
            p, q = _level_line(*ends_on[surface.name], z)
            triangles = triangles[_cross(q - p, np.column_stack([x, y]) - p) > 0]
        used, local = np.unique(triangles, return_inverse=True)
        made.append(replace(surface, vertices=shape.vertices[used], triangles=local.reshape(-1, 3)))
    return made


def cut(
    horizon: Horizon,
    *surfaces: Surface,
    gamma: float = 2.0,
    checks: Mapping[str, float] = MappingProxyType({}),
    ends_on: Mapping[str, Line] = MappingProxyType({}),
) -> Model:
    """A model of one horizon and conforming faults; gamma in steps.

    Slivers do not matter here: parts of triangles that cross may be as thin as they come.
    """
    return Model(
        "zoo",
        (horizon,),
        tuple(Fault(s) for s in conforming(*surfaces, ends_on=ends_on)),
        parameters=Parameters.model_validate({"gamma": gamma * STEP}),
        checks={"degenerate": 1e-6, **checks},
    )


def around(
    radius: float,
    count: int = 3,
    beyond: float = 3.0,
    *,
    names: str = "FGKL",
    dips: Sequence[float] = (70, 65, 75, 68),
    open_by: float = 0.0,
) -> list[Surface]:
    """Faults along the sides of a polygon of that inner radius that go on ``beyond`` its corners, in steps.

    The first ends ``open_by`` before its second corner, where that is given.
    """
    middle, half = np.array([0.4, 0.3]), radius * np.tan(np.pi / count)
    made = []
    for k in range(count):
        angle = 2.0 * np.pi * k / count + 0.2
        out, along = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
        to = half - open_by if open_by and k == 0 else half + beyond
        foot = middle + radius * out
        made.append(plane(foot - (half + beyond) * along, foot + to * along, names[k], dip=dips[k]))
    return made


def pipe(radius: float, dip: float = 70.0, count: int = 24, name: str = "F", turns: int = 24) -> Surface:
    """A fault that goes ``turns`` of ``count`` parts of the way round a middle; closed with all; in steps."""
    angle = 2.0 * np.pi * np.arange(turns if turns == count else turns + 1) / count
    egg = 1.0 + 0.1 * np.sin(angle)  # so that it has one sharpest corner, in the north
    rows = []
    for z in (2.0, 0.0, -2.0):
        away = radius * egg - z / np.tan(np.radians(dip))
        rows.append(
            np.c_[0.3 + away * np.cos(angle), 0.2 + 1.2 * away * np.sin(angle), np.full(len(angle), z)]
        )
    n = len(angle)
    i = np.arange(turns)
    j = (i + 1) % n
    sides = [np.c_[i + k * n, i + k * n + n, j + k * n + n] for k in (0, 1)]
    sides += [np.c_[i + k * n, j + k * n + n, j + k * n] for k in (0, 1)]
    return Surface(name, STEP * np.concatenate(rows), np.concatenate(sides))
