"""The zoo of self-intersection: surfaces that pass through or lie upon themselves; and those that touch."""

from __future__ import annotations

import numpy as np

from graben.surface import Surface
from tests.zoo.cases import Case
from tests.zoo.shapes import AT_MIDDLE, F60, MIDDLE, STEP, dipping, faults, joined, moved_vertex, sheet

DOWN = F60.vertices[1] - F60.vertices[0]


def rolled(first: float = -1.45, last: float = 1.5) -> Surface:
    """A fault rolled up like the letter alpha, that passes through itself at y = 0, z = -4 steps."""

    def place(i, j):
        t = first + (last - first) * j / 12
        return STEP * i, 5 * STEP * t * (t * t - 1), -4 * STEP * t * t

    return sheet(6, 12, place)


def across(dip: float, along: float) -> Surface:
    """F60 and a sheet of another dip that passes through it halfway down, ``along`` steps further east."""
    c, s = STEP * np.cos(np.radians(dip)), STEP * np.sin(np.radians(dip))
    other = sheet(4, 4, lambda i, j: (STEP * i, c * (j - 2), -s * (j - 2)))
    return joined(F60, other.moved(2 * DOWN + [along * STEP, 0, 0]))


def hanging(through: float = 0.0) -> Surface:
    """F60 and a sheet that hangs down from halfway down it, its rim as far ``through`` F60 in metres."""
    other = sheet(3, 2, lambda i, j: (STEP * i, -0.2 * STEP * j, -STEP * j))
    return joined(F60, other.moved(2 * DOWN + [1.3 * STEP, through, 0]))


def folded(width: float) -> Surface:
    """A fault folded back on itself halfway down, the lower limb ``width`` behind the upper at its end."""
    below = np.array([0.0, -np.sin(np.radians(60)), -np.cos(np.radians(60))])

    def place(i, j):
        down = np.minimum(j, 8 - j)[:, None] * DOWN + np.maximum(j - 4, 0)[:, None] / 4 * width * below
        return STEP * (i + 0.1 * np.maximum(j - 4, 0)), down[:, 1], down[:, 2]

    return sheet(6, 8, place)


def twisted() -> Surface:
    """F60 with a vertex drawn down past its neighbours in the plane of the fault."""
    return moved_vertex(F60, MIDDLE, AT_MIDDLE + 1.5 * DOWN)


def _case(name, surface, place, *follows: str) -> Case:
    return Case(name, "self-intersection", faults(surface), place, follows=follows)


_BENT, _PIECES = ("functional", "z-monotone"), ("strongly-connected", "functional")
_AT = (2 * DOWN + [STEP, 0, 0], 2 * DOWN + [3 * STEP, 0, 0])

FAILING: tuple[Case, ...] = (
    _case("rolled up", rolled(), [(x, 0, -4 * STEP) for x in (25, 150, 275)], *_BENT, "min-dip"),
    _case("two faults in one", across(-30, 0.3), _AT, *_PIECES),
    # the crossing runs along edges of both sheets: no triangle passes through another by itself
    _case("crossing along edges", across(-50, 0.5), _AT, *_PIECES),
    _case("folded flat", folded(0.0), None, *_BENT),
    _case("a vertex past its neighbours", twisted(), AT_MIDDLE + 1.2 * DOWN, *_BENT),
)


def _passes(name, surface, *follows: str) -> Case:
    return Case(name, "self-intersection", faults(surface), objects=(), follows=follows)


_NORMAL = np.array([0.0, np.sin(np.radians(60)), np.cos(np.radians(60))])
_CORNER = AT_MIDDLE + 0.3 * DOWN + [20.0, 0, 0]
_FLAG = Surface(
    "F", _CORNER + STEP * np.array([[0, 0, 0], _NORMAL + np.array([0.4, 0, 0]), _NORMAL]), [[0, 1, 2]]
)
PASSING: tuple[Case, ...] = (
    _passes("two triangles", dipping(60, 1, 1)),
    _passes("a sheet that hangs on it", hanging(), "strongly-connected", "functional"),
    _passes("a rim through it by rounding", hanging(1e-7), "strongly-connected", "functional"),
    _passes("open roll", rolled(-0.95, 0.9), "functional", "z-monotone", "min-dip"),
    _passes("tight fold", folded(1.0), "functional", "z-monotone"),
    _passes("a corner on it", joined(F60, _FLAG), "strongly-connected", "functional"),
)
