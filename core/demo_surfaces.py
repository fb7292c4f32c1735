"""Triangulations of the synthetic faults, with a branch line shared to the bit."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq

from graben.arrays import FloatArray, IntArray, floats, ints
from graben.surface import Surface
from graben.synthetic import TrueFault

SPACING = 125.0  #: length of the sides of a fault's triangles, m
_CLEARANCE = 0.4  # regular nodes and columns nearer than this share of the spacing to a branch line give way


@dataclass(frozen=True, eq=False)
class Joined:
    """A fault and its branch with their triangulations, which share the branch line."""

    main: TrueFault
    branch: TrueFault
    main_surface: Surface
    branch_surface: Surface


def sheet(fault: TrueFault, low: float, high: float) -> Surface:
    """Return the triangulation of a fault between two elevations (m), vertices on its columns."""
    return _woven(fault, [_rows(fault, low, high)] * len(fault.columns), {})


def joined(main: TrueFault, branch: TrueFault, low: float, high: float) -> Joined:
    """Return a fault and its branch triangulated between two elevations (m), conforming on the branch line.

    The branch line is straight between the columns of the main fault, so its vertices lie on them; the
    main fault gets a column where the branch line starts and ends. The branch must be planar there.
    """
    ends = {_line_end(main, branch, z): z for z in (low, high)}
    kept = [s for s in main.columns if min(abs(s - e) for e in ends) > _CLEARANCE * SPACING]
    main = replace(main, columns=floats(sorted([*kept, *ends])))
    on_line = {
        i: ends.get(s, _line_elevation(main, branch, s))
        for i, s in enumerate(main.columns.tolist())
        if min(ends) <= s <= max(ends)
    }
    rows = _rows(main, low, high)
    columns = [_with_node(rows, on_line[i]) if i in on_line else rows for i in range(len(main.columns))]
    main_surface = _woven(main, columns, on_line)
    counts = np.cumsum([0, *(len(c) for c in columns)])
    line = [counts[i] + int(np.searchsorted(columns[i], z)) for i, z in on_line.items()]
    points = main_surface.vertices[line]
    points = points[np.argsort(points[:, 2])]
    return Joined(main, branch, main_surface, _hung(branch, points))


def _rows(fault: TrueFault, low: float, high: float) -> FloatArray:
    length = (high - low) / np.sin(np.radians(fault.dip))
    return floats(np.linspace(low, high, max(2, round(length / SPACING) + 1)))


def _point(fault: TrueFault, s: FloatArray, z: FloatArray) -> FloatArray:
    """Return the points of a fault's column lines at given elevations, shape (..., 3)."""
    q = np.interp(s, fault.columns, fault.corrugation(fault.columns)) - (z - fault.elevation) / fault.grade
    return floats(np.concatenate([fault.position(s, q), z[..., None]], axis=-1))


def _line_elevation(main: TrueFault, branch: TrueFault, s: float) -> float:
    """Return the elevation at which the line of constant s on the main fault meets the branch's plane."""
    q = float(main.corrugation(np.array(s)))
    ends = main.position(
        np.array([s, s]), np.array([q, q - 1.0 / main.grade])
    )  # at main.elevation and 1 m above
    q0, q1 = branch.coordinates(ends)[1]
    height = (branch.elevation - branch.grade * q0 - main.elevation) / (1.0 + branch.grade * (q1 - q0))
    return main.elevation + float(height)


def _line_end(main: TrueFault, branch: TrueFault, z: float) -> float:
    """Return s of the main fault at which the branch line has elevation z."""
    s = brentq(lambda s: _line_elevation(main, branch, s) - z, main.columns[0], main.columns[-1], xtol=1e-9)
    return float(s)


def _with_node(rows: FloatArray, z: float) -> FloatArray:
    """Return sorted elevations with z among them; inner ones too near to it give way."""
    near = np.abs(rows - z) <= _CLEARANCE * (rows[1] - rows[0])
    near[[0, -1]] = rows[[0, -1]] == z
    return floats(np.sort(np.append(rows[~near], z)))


def _woven(fault: TrueFault, columns: list[FloatArray], on_line: dict[int, float]) -> Surface:
    """Return the surface over columns of nodes; an edge joins the nodes on a line in neighbouring columns."""
    s = np.repeat(fault.columns, [len(c) for c in columns])
    vertices = _point(fault, s, np.concatenate(columns))
    starts = np.cumsum([0, *(len(c) for c in columns)])
    triangles = []
    for i in range(len(columns) - 1):
        left, right = columns[i], columns[i + 1]
        cuts = [(0, 0), (len(left) - 1, len(right) - 1)]
        if i in on_line and i + 1 in on_line:
            middle = (int(np.searchsorted(left, on_line[i])), int(np.searchsorted(right, on_line[i + 1])))
            cuts.insert(1, middle)
        for (a, b), (c, d) in pairwise(cuts):
            offset = np.array([starts[i] + a, starts[i + 1] + b])
            triangles.append(_ladder(left[a : c + 1], right[b : d + 1], offset))
    return Surface(fault.name, vertices, ints(np.concatenate(triangles)))


def _ladder(left: FloatArray, right: FloatArray, offset: IntArray) -> IntArray:
    """Return the triangles between two columns of sorted elevations, numbered from the two offsets."""
    of_left, of_right = 0.5 * (left[1:] + left[:-1]), 0.5 * (right[1:] + right[:-1])
    i, j = np.arange(len(of_left)), np.arange(len(of_right))
    facing = np.searchsorted(of_right, of_left, side="left")
    opposite = np.searchsorted(of_left, of_right, side="right")
    lower = np.column_stack([offset[0] + i, offset[1] + facing, offset[0] + i + 1])
    upper = np.column_stack([offset[0] + opposite, offset[1] + j, offset[1] + j + 1])
    return ints(np.concatenate([lower, upper]))


def _hung(branch: TrueFault, line: FloatArray) -> Surface:
    """Return the branch's surface from a branch line (k, 3), rising, whose elevations give its rows."""
    z = line[:, 2]
    start = branch.coordinates(line[:, :2])[0]
    cells = max(1, round(float(branch.planar - start.mean()) / SPACING))
    share = np.linspace(0.0, 1.0, cells + 1)[1:, None]
    sheared = start + share * (branch.planar - start)
    straight = branch.columns[branch.columns > branch.planar]
    s = np.concatenate([sheared, np.repeat(straight[:, None], len(z), axis=1)])
    rest = _point(branch, s, np.broadcast_to(z, s.shape))
    vertices = np.concatenate([line, rest.reshape(-1, 3)])
    k = len(z)
    triangles = [_ladder(z, z, np.array([c * k, (c + 1) * k])) for c in range(len(s))]
    return Surface(branch.name, floats(vertices), ints(np.concatenate(triangles)))
