"""Twelve clean fault networks of 2 to 8 faults, from which the corrupted ones of the tests are made.

Every fault is a sheet of columns and levels. All faults of a network have their vertices on the same levels
along branch lines, and a branch line is a column of both its faults: what meets shares edges to the bit. The
columns between are sheared so that they lead over from one branch line or tip to the next. Elsewhere the
vertices are jittered within their smooth fault, so that no test sees a regular lattice.

z is elevation, lengths are metres, angles degrees.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from typing import Protocol

import numpy as np

from graben.arrays import FloatArray, IntArray, floats, ints
from graben.model import Fault, Horizon, Model
from graben.settings import Parameters
from graben.surface import Surface
from tests.cleaning.network_list import NETWORKS, FaultPlan, Network, Shape
from tests.models import grid_horizon

SPACING = 125.0  #: distance of columns along strike, m
RISE = 90.0  #: distance of levels, m
STEP = 100.0  #: step of the horizons, m
GAMMA = 300.0  #: m
_JITTER_S, _JITTER_Z = 0.12, 0.10  # shares of a column's and a level's distance
_NEWTON = 30  # 6 reach the last digit
_DIFFERENCE = 1.0  # m, over which a contour's direction is taken


class _Contoured(Protocol):
    def at(self, s: FloatArray, z: FloatArray) -> FloatArray: ...


@dataclass(frozen=True, eq=False)
class _Hung:
    """A fault that hangs from a branch line of two others: the line moved along a plan direction."""

    shape: Shape
    levels: FloatArray
    line: FloatArray

    def at(self, s: FloatArray, z: FloatArray) -> FloatArray:
        along, right = self.shape.axes
        start = np.stack([np.interp(z, self.levels, self.line[:, k]) for k in (0, 1)], axis=-1)
        away = self.shape.corrugation(s) - self.shape.corrugation(np.zeros_like(s))
        return floats(start + s[..., None] * along + away[..., None] * right)


@dataclass(frozen=True, eq=False)
class _Line:
    """A branch line: its points on all levels, (k, 3), and s of them on each fault by its name, (k,)."""

    points: FloatArray
    s: Mapping[str, FloatArray]


@cache
def clean_network(name: str) -> Model:
    """The clean network of this name."""
    network = NETWORKS[name]
    lines = _branch_lines(network)
    rng = np.random.default_rng(sorted(NETWORKS).index(name))
    made = Model(
        name,
        tuple(_horizon(network, k, z) for k, z in enumerate(network.horizons)),
        tuple(Fault(_sheet(network, plan, lines, rng)) for plan in network.faults),
        parameters=Parameters.model_validate({"gamma": GAMMA}),
    )
    return made.moved(floats(network.shift))


def clean_networks() -> list[Model]:
    """All of them, in the order of their list."""
    return [clean_network(name) for name in NETWORKS]


def _horizon(network: Network, number: int, elevation: float) -> Horizon:
    east, north = network.tilt

    def height(x: FloatArray, y: FloatArray) -> FloatArray:
        return floats(elevation + east * x + north * y + 2e-6 * x * y)

    return grid_horizon(height, network.size, STEP, f"H{number + 1}")


def _levels(network: Network) -> FloatArray:
    half = round(network.half_height / RISE)
    return floats(RISE * np.arange(-half, half + 1))


def _branch_lines(network: Network) -> dict[frozenset[str], _Line]:
    """The branch lines of a network, by the two faults that meet there."""
    plans = {p.name: p for p in network.faults}
    pairs = [
        frozenset((p.name, end)) for p in network.faults for end in (p.start, p.stop) if isinstance(end, str)
    ]
    pairs += [frozenset(pair) for pair in network.crossings]
    levels = _levels(network)
    return {pair: _line(plans, pair, levels) for pair in dict.fromkeys(pairs)}


def _line(plans: Mapping[str, FaultPlan], pair: frozenset[str], levels: FloatArray) -> _Line:
    """Where the contours of two faults meet, by Newton's method on all levels at once."""
    first, second = sorted(pair)
    a, b = plans[first].shape, plans[second].shape
    s = np.zeros((2, len(levels)))
    for _ in range(_NEWTON):
        off = b.at(s[1], levels) - a.at(s[0], levels)
        ways = [
            (f.at(t + _DIFFERENCE, levels) - f.at(t, levels)) / _DIFFERENCE for f, t in ((a, s[0]), (b, s[1]))
        ]
        s = s + np.linalg.solve(np.stack([ways[0], -ways[1]], axis=-1), off[..., None])[..., 0].T
    points = np.column_stack([a.at(s[0], levels), levels])
    return _Line(floats(points), {first: floats(s[0]), second: floats(s[1])})


def _sheet(
    network: Network, plan: FaultPlan, lines: Mapping[frozenset[str], _Line], rng: np.random.Generator
) -> Surface:
    """The triangulated surface of a fault."""
    levels = _levels(network)
    own = np.flatnonzero((levels >= plan.low - 1e-6) & (levels <= plan.high + 1e-6))
    contoured: _Contoured = plan.shape
    anchors: list[tuple[FloatArray, FloatArray | None]] = []
    hung = lines[frozenset(plan.hung)] if plan.hung else None
    if hung is not None:
        contoured = _Hung(plan.shape, levels, hung.points)
        anchors.append((floats(np.zeros(len(levels))), hung.points))
    for pair, line in lines.items():
        if plan.name in pair:
            anchors.append((line.s[plan.name], line.points))
    middle, half = levels[own].mean(), np.ptp(levels[own]) / 2
    shrink = plan.taper * ((levels - middle) / half) ** 2
    anchors += [(floats(end + sign * shrink), None) for end, sign in plan.tips]
    anchors.sort(key=lambda anchor: float(anchor[0].mean()))
    s, fixed = _columns([(a[own], None if p is None else p[own]) for a, p in anchors])
    z = np.broadcast_to(levels[own], s.shape).copy()
    free = np.ones(s.shape, dtype=bool)
    free[:, [0, -1]] = False
    free[[0, -1, *fixed]] = False
    s = s + np.where(free, _JITTER_S * SPACING * rng.uniform(-1, 1, s.shape), 0.0)
    z = z + np.where(free, _JITTER_Z * RISE * rng.uniform(-1, 1, s.shape), 0.0)
    points = np.concatenate([contoured.at(floats(s), floats(z)), z[..., None]], axis=-1)
    for column, line_points in fixed.items():
        points[column] = line_points
    return Surface(plan.name, points.reshape(-1, 3), _triangles(points))


def _columns(anchors: list[tuple[FloatArray, FloatArray | None]]) -> tuple[FloatArray, dict[int, FloatArray]]:
    """s of all columns on all levels, (c, k), and the points of those that are branch lines, by number."""
    columns = [anchors[0][0]]
    fixed = {} if anchors[0][1] is None else {0: anchors[0][1]}
    for (left, _), (right, points) in pairwise(anchors):
        cells = max(1, round(float((right - left).mean()) / SPACING))
        columns += [floats(left + (right - left) * k / cells) for k in range(1, cells + 1)]
        if points is not None:
            fixed[len(columns) - 1] = points
    return floats(columns), fixed


def _triangles(points: FloatArray) -> IntArray:
    """The triangles of a lattice of points (c, k, 3), each cell cut along its shorter diagonal."""
    columns, rows = points.shape[:2]
    a = (np.arange(columns - 1)[:, None] * rows + np.arange(rows - 1)).ravel()
    b, c, d = a + rows, a + rows + 1, a + 1
    flat = points.reshape(-1, 3)
    one = np.linalg.norm(flat[a] - flat[c], axis=1) < np.linalg.norm(flat[b] - flat[d], axis=1)
    first = np.where(one[:, None], np.stack([a, b, c], axis=1), np.stack([a, b, d], axis=1))
    second = np.where(one[:, None], np.stack([a, c, d], axis=1), np.stack([b, c, d], axis=1))
    return ints(np.stack([first, second], axis=1).reshape(-1, 3))
