"""The zoo of z-monotone: faults with summits, pits, saddles and level patches; and ones that only seem to."""

from __future__ import annotations

import numpy as np

from tests.zoo.cases import Case
from tests.zoo.shapes import F60, MIDDLE, STEP, dipping, faults, moved_vertex, scene, sheet

#: How much higher each row of F60 is than the next.
RISE = STEP * np.sin(np.radians(60))


def _raised(vertex: int, rows: float):
    """F60 with one vertex higher by so many rows, and where that is then."""
    place = F60.vertices[vertex] + np.array([0, 0, rows * RISE])
    return moved_vertex(F60, vertex, place), place


def _steps(*heights: float):
    """A fault whose rows lie at these heights, 25 apart in plan."""
    z = np.array(heights)
    return sheet(6, len(z) - 1, lambda i, j: (STEP * i, 25 * j, z[j.astype(int)] + 0 * i))


def _saddle():
    """A fault that rises to two corners and falls to the other two, steep but for its middle."""
    return sheet(4, 4, lambda i, j: (STEP * (i - 2), STEP * (j - 2), 3 * STEP * (i - 2) * (j - 2) / 2))


def _roof(plunge: float):
    """Two sides of 60 degrees on a crest that plunges so many degrees along x."""
    fall = STEP * np.tan(np.radians(plunge))
    return sheet(
        6,
        4,
        lambda i, j: (STEP * i, 25 * (j - 2), -np.abs(j - 2) * RISE - fall * i),
    )


def _rolled_over():
    """A fault that dips 70 degrees below and bends back over its foot above, one way up all along."""
    turn = np.radians([70, 80, 90, 100, 110])
    y = np.concatenate([[0], np.cumsum(STEP * np.cos(turn))])
    z = np.concatenate([[0], np.cumsum(STEP * np.sin(turn))])
    return sheet(6, 5, lambda i, j: (STEP * i, -y[j.astype(int)] + 0 * i, z[j.astype(int)] + 0 * i))


def _rounded():
    """A corrugated fault with coordinates to a centimetre, as files have them, so that edges are level."""
    made = sheet(24, 16, lambda i, j: (10 * i, 5 * j + 0.7 * np.sin(2 * i) + 0.3 * np.sin(i * j), -8.66 * j))
    return made.with_vertices(np.round(made.vertices, 2))


def _case(name, model, place, follows=(), extended: str = "warn") -> Case:
    return Case(name, "z-monotone", model, place, extended=extended, follows=follows)


FAILING: tuple[Case, ...] = (
    _case("summit", scene(_raised(MIDDLE, 1.4)[0]), _raised(MIDDLE, 1.4)[1]),
    _case("pit", scene(_raised(MIDDLE, -1.4)[0]), _raised(MIDDLE, -1.4)[1]),
    _case("saddle", faults(_saddle()), (0, 0, 0), follows=("min-dip",)),
    _case("level crest", faults(_roof(0)), [(STEP * i, 0, 0) for i in range(1, 6)]),
    _case(
        "level patch",
        faults(_steps(0, -RISE, -RISE, -2 * RISE, -3 * RISE)),
        [(STEP * i + STEP / 2, 37.5, -RISE) for i in range(6)],
        follows=("min-dip",),
    ),
    _case("level altogether", faults(dipping(0)), None, follows=("min-dip",)),
)


def _passes(name, model, follows=()) -> Case:
    return Case(name, "z-monotone", model, objects=(), follows=follows)


PASSING: tuple[Case, ...] = (
    _passes("nearly a summit", scene(_raised(MIDDLE, 0.6)[0])),
    _passes("crest that plunges", faults(_roof(2))),
    _passes(
        "terrace that dips half a degree",
        faults(_steps(0, -RISE, -RISE - 0.22, -2 * RISE, -3 * RISE)),
        follows=("min-dip",),
    ),
    _passes("summit on the rim", faults(_raised(2 * 5, 1.4)[0])),
    _passes("level rows", faults(dipping(60, 12, 8))),
    _passes("upright", faults(dipping(90)), follows=("functional",)),
    _passes("bent back over itself", faults(_rolled_over()), follows=("functional",)),
    _passes("rounded to a centimetre", faults(_rounded())),
)
